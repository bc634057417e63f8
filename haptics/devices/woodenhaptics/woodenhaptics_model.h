// Dimensions of one WoodenHaptics or Polhem device, from the JSON file that the maker's library stores as
// woodenhaptics.json.
// Facts from forsslund/haptikfabrikenapi (src/haptikfabrikenapi.h: the fields, their units and the shipped
// models; src/kinematics.cpp: the file). Unproven on hardware here.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/geometry.h"

namespace stylet::haptics {

// Bodies a (turns about the vertical), b (upper arm) and c (forearm), each driven by a motor's capstan.
struct WoodenModel {
    std::string name = "woodenhaptics";
    std::array<double, 3> capstan_diameter_m{}, body_diameter_m{}, length_m{};
    std::array<double, 3> torque_constant_n_m_per_a{};
    std::array<bool, 3> motor_aligned{};      // true: motor and body turn in opposite directions
    std::array<double, 6> counts_per_turn{};  // of encoders a..f; d, e, f are zero if there is no wrist
    std::array<bool, 3> wrist_aligned{};      // true: encoders d, e, f count in their body's direction
    std::array<std::int16_t, 6> calibration_counts{};  // encoder values of the parked arm
    std::array<double, 2> mass_kg{};                   // bodies b and c
    std::array<double, 2> centre_of_mass_m{};          // from the body's joint
    double gravity_m_s2 = 0.0;                         // 0: no gravity compensation
    Vec3 workspace_origin_m{0.0};                      // base frame
    double workspace_radius_m = 0.0;
    double force_peak_n = 0.0, stiffness_n_per_m = 0.0;

    bool hasWrist() const noexcept { return counts_per_turn[3] > 0.0; }
};

// Throw DataError: file, field, reason. All of the library's fields must be present, and no others
// but "name". Fields used only by its analogue boards are checked and ignored. Variant 3 (Polhem v2, v3) is
// refused because its kinematics are not public.
WoodenModel loadWoodenModel(const std::filesystem::path& json);
WoodenModel parseWoodenModel(std::string_view json, const std::filesystem::path& file);

}  // namespace stylet::haptics
