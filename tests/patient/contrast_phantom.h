// Phantoms of liver tissue with tubes in it: ducts or vessels.
#pragma once

#include <string>

#include "tests/support/phantom.h"

namespace stylet::test {

inline constexpr std::uint8_t kFirstOwnLabel = 20;

// Liver along +x from x = 0 to `length_m`. The extent in y and z is that of makeSlabs().
inline patient::Package liverBlock(double length_m, double spacing_m) {
    return makeSlabs({{patient::Tissue::liver, length_m}}, spacing_m);
}

// Adds a label to the table and returns its id.
inline std::uint8_t addLabel(patient::Package& package, const std::string& name, patient::Tissue tissue,
                             patient::Role role, patient::BloodKind blood = patient::BloodKind::none) {
    patient::Label label = package.label_table.back();
    label.id = std::uint8_t(kFirstOwnLabel + package.label_table.size());
    label.name = name;
    label.tissue = tissue;
    label.role = role;
    label.blood = blood;
    package.label_table.push_back(label);
    return label.id;
}

// Labels the voxels whose centre satisfies `in(x, y, z)`, in metres.
inline void carve(patient::Package& package, std::uint8_t id, const auto& in) {
    forEachVoxel(package.labels.grid, [&](const Index3& i) {
        const Vec3 p = package.labels.grid.centre(i);
        if (in(p.x, p.y, p.z)) package.labels[i] = id;
    });
}

// A square tube along x with sides of 2 * half_m.
inline auto tubeAlongX(double from_m, double to_m, double half_m, double y_m = 0.0, double z_m = 0.0) {
    return [=](double x, double y, double z) {
        return x > from_m && x < to_m && std::abs(y - y_m) < half_m && std::abs(z - z_m) < half_m;
    };
}

inline std::uint8_t idOf(patient::Tissue tissue) {
    return std::uint8_t(tissue);
}

}  // namespace stylet::test
