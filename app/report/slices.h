// Three slices through the CT at the needle's tip, with the needle, in radiological orientation.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "patient/patient.h"

namespace stylet::report {

// A plane in the deformed patient. `right` and `down` are unit vectors of the picture.
struct SlicePlane {
    std::string title;
    Vec3 centre_m{0.0}, right{-1.0, 0.0, 0.0}, down{0.0, 0.0, -1.0};
    double width_m = 0.2;
};

struct NeedlePicture {
    Vec3 tip_m{0.0};       // deformed patient
    Vec3 axis{0.0};        // unit, into the body
    Vec3 target_m{0.0};    // end of the planned path; the rest of the path is dashed
    double depth_m = 0.0;  // of the tip along the track
    patient::Surrogate breath;
    std::string title, caption;
    std::vector<Vec3> trail_m{};      // earlier tip positions
    std::vector<Vec3> reference_m{};  // the reference path from entry to target; empty: not shown
};

// The CT window of the pictures: 400 HU wide around 50 HU.
inline constexpr double kWindowLow_hu = -150.0, kWindowHigh_hu = 250.0;

// Two planes that contain the needle, nearest to axial and to coronal, and the plane across it at the tip,
// seen along the needle.
std::array<SlicePlane, 3> slicePlanes(const NeedlePicture&);

// Samples the plane as `width` x `height` RGB triples: windowed CT with tinted labels. Counts the pixels of
// each label in `seen`.
std::vector<std::uint8_t> samplePlane(const patient::Patient&, const patient::Surrogate&, const SlicePlane&,
                                      int width, int height, std::array<std::size_t, 256>& seen);

// The slices as a PNG.
struct SliceSheet {
    std::vector<std::uint8_t> png;
    int width = 0, height = 0;
};
SliceSheet sliceSheet(const patient::Patient&, const NeedlePicture&);

// Throws DataError.
void drawSlices(const patient::Patient&, const NeedlePicture&, const std::filesystem::path& png);

}  // namespace stylet::report
