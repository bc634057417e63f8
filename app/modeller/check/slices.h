// Montages of a patient's slices: the CT in an abdominal window, plain and with coloured labels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "patient/patient.h"

namespace stylet::modeller {

struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

enum class Plane { axial, coronal, sagittal };

struct Window {
    double level_hu = 40.0, width_hu = 400.0;
};

// One slice in radiological orientation: the patient's right on the left, front or head up.
Picture slicePicture(const patient::Package&, Plane, int index, const Window&, double label_share);
// `count` slices spread evenly over the volume, in `columns` columns.
Picture montage(const patient::Package&, Plane, int count, int columns, const Window&, double label_share);
void writePng(const Picture&, const std::filesystem::path&);

// Writes axial.png, coronal.png, sagittal.png, and the same with labels.
void writeSlices(const patient::Package&, const std::filesystem::path& folder);

}  // namespace stylet::modeller
