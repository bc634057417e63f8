#include "haptics/devices/woodenhaptics/woodenhaptics_model.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "base/fields.h"
#include "base/whole_file.h"
#include "patient/patient.h"

namespace stylet::haptics {

namespace {

constexpr std::size_t kMaxModelBytes = 64 << 10;
constexpr std::size_t kMaxNameBytes = 100;
constexpr int kUnpublishedVariant = 3;

int readWhole(Fields& in, const std::string& key, int low, int high) {
    const double v = in.number(key, low, high);
    if (v != std::floor(v)) in.refuse(key, "not a whole number");
    return int(v);
}

// The library writes true and false; its tables use 1 and 0.
bool readFlag(Fields& in, const std::string& key) {
    return in.kind(key) == FieldKind::number ? readWhole(in, key, 0, 1) == 1 : in.flag(key);
}

template <std::size_t kCount>
std::array<double, kCount> readNumbers(Fields& in, const std::string& stem, const char* bodies, double low,
                                       double high) {
    std::array<double, kCount> values{};
    for (std::size_t i = 0; i < kCount; ++i)
        values[i] = in.number(stem + bodies[i], low, high);
    return values;
}

std::array<bool, 3> readFlags(Fields& in, const std::string& stem, const char* bodies) {
    return {readFlag(in, stem + bodies[0]), readFlag(in, stem + bodies[1]), readFlag(in, stem + bodies[2])};
}

void refuseRepeated(const Fields& in) {
    for (const std::string& key : in.duplicateKeys())
        in.refuse(key,
                  key == "enc_and_body_aligned_d"
                      ? "given twice: the maker's library writes this key instead of enc_and_body_aligned_e; "
                        "rename the second one"
                      : "given twice");
}

void readEncoders(Fields& in, WoodenModel& m) {
    const auto arm = readNumbers<3>(in, "cpr_encoder_", "abc", 16.0, 1e6);
    const auto wrist = readNumbers<3>(in, "cpr_encoder_", "def", 0.0, 1e6);
    const auto fitted = std::count_if(wrist.begin(), wrist.end(), [](double n) { return n > 0.0; });
    if (fitted != 0 && fitted != 3)
        in.refuse("cpr_encoder_d",
                  fmt::format("a wrist has three encoders or none; this one has {}", fitted));
    for (std::size_t i = 0; i < 3; ++i) {
        if (fitted == 3 && wrist[i] < 16.0)
            in.refuse(std::string("cpr_encoder_") + "def"[i], "not within 16 and 1000000");
        m.counts_per_turn[i] = arm[i];
        m.counts_per_turn[3 + i] = wrist[i];
    }
    for (std::size_t i = 0; i < 6; ++i)
        m.calibration_counts[i] =
            std::int16_t(readWhole(in, std::string("calibrate_enc_") + "abcdef"[i], INT16_MIN, INT16_MAX));
    m.motor_aligned = readFlags(in, "motor_and_body_aligned_", "abc");
    m.wrist_aligned = readFlags(in, "enc_and_body_aligned_", "def");
}

}  // namespace

WoodenModel parseWoodenModel(std::string_view text, const std::filesystem::path& file) {
    Fields in = parseJson(file, text);
    refuseRepeated(in);
    WoodenModel m;
    m.name = in.textOr("name", m.name, kMaxNameBytes);
    if (readWhole(in, "variant", 0, kUnpublishedVariant) == kUnpublishedVariant)
        in.refuse("variant", "3 (Polhem v2 and v3): its kinematics are not public, so it cannot be driven");
    m.capstan_diameter_m = readNumbers<3>(in, "diameter_capstan_", "abc", 0.001, 1.0);
    m.body_diameter_m = readNumbers<3>(in, "diameter_body_", "abc", 0.001, 1.0);
    m.length_m = readNumbers<3>(in, "length_body_", "abc", 0.01, 1.0);
    m.workspace_origin_m = {in.number("workspace_origin_x", -1.0, 1.0),
                            in.number("workspace_origin_y", -1.0, 1.0),
                            in.number("workspace_origin_z", -1.0, 1.0)};
    m.workspace_radius_m = in.number("workspace_radius", 0.01, 1.0);
    m.torque_constant_n_m_per_a = readNumbers<3>(in, "torque_constant_motor_", "abc", 0.001, 10.0);
    in.number("current_for_10_v_signal", 0.0, 100.0);  // for analogue amplifiers only
    readEncoders(in, m);
    m.force_peak_n = in.number("max_linear_force", 0.1, 50.0);
    m.stiffness_n_per_m = in.number("max_linear_stiffness", 1.0, 20000.0);
    in.number("max_linear_damping", 0.0, 1000.0);  // rendered, not physical
    m.mass_kg = readNumbers<2>(in, "mass_body_", "bc", 0.0, 5.0);
    m.centre_of_mass_m = readNumbers<2>(in, "length_cm_body_", "bc", -1.0, 1.0);
    m.gravity_m_s2 = in.number("g_constant", -20.0, 20.0);
    in.finish();
    return m;
}

WoodenModel loadWoodenModel(const std::filesystem::path& json) {
    return parseWoodenModel(readWholeFile(json, kMaxModelBytes), json);
}

}  // namespace stylet::haptics
