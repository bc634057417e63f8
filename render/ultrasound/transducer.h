// An ultrasound probe: the geometry of its scan lines and the width of its beam. Loaded from
// assets/ultrasound/*.toml.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/geometry.h"

namespace stylet::render {

enum class TransducerShape : std::uint8_t { convex, linear };

struct Transducer {
    std::string name = "convex";
    TransducerShape shape = TransducerShape::convex;
    double radius_m = 0.060;           // convex: radius of the face
    double half_angle_rad = 0.523599;  // convex
    double width_m = 0.040;            // linear: between the outermost lines
    double depth_m = 0.160, focus_m = 0.080;
    double frequency_hz = 3.5e6, lowest_frequency_hz = 2.0e6, highest_frequency_hz = 5.0e6;
    double aperture_m = 0.024;  // the elements that form one line
    double pulse_cycles = 2.5;
    // Thickness of the beam across the picture's plane, at half of its amplitude: waist, depth of the waist,
    // and the distance from it at which the thickness has grown by a factor of sqrt 2.
    double thickness_m = 0.0024, thickness_focus_m = 0.075, thickness_range_m = 0.050;
    friend bool operator==(const Transducer&, const Transducer&) = default;
};

Transducer loadTransducer(const std::filesystem::path& toml);  // throws DataError
// The same from memory; errors name `file`.
Transducer parseTransducer(const std::filesystem::path& file, std::string_view toml);

// True if a face, a bar of this length that is bent to a radius of curvature, counts as flat.
inline bool isFlatFace(double length_m, double curvature_m) {
    return curvature_m > 100.0 * length_m;
}
// The transducer with the scan lines of another face. They are parallel if it is flat.
Transducer withFace(Transducer, double length_m, double curvature_m);

// A scan line in the probe's frame; `share` from -1 (at -x) to 1.
struct ScanLine {
    Vec3 origin_m, direction;
};
ScanLine scanLine(const Transducer&, double share);
// Distance between neighbouring lines at a depth, of `lines` lines.
double linePitch_m(const Transducer&, int lines, double depth_m);

// Full widths at half of the two-way amplitude. Sound at 1540 m/s.
double pulseLength_m(const Transducer&, double frequency_hz);  // along the line, as it is drawn
double beamWidth_m(const Transducer&, double frequency_hz, double focus_m, double depth_m);  // in the picture
double beamThickness_m(const Transducer&, double depth_m);                                   // across it

inline constexpr double kAssumedSpeed_m_per_s = 1540.0;  // every machine draws at this speed
inline constexpr double kWidthsPerSigma = 2.354820045;   // full width of a Gaussian at half of its height

}  // namespace stylet::render
