// A valid WoodenHaptics model file, optionally with one value changed. The value "" removes the key.
#pragma once

#include <array>
#include <string>
#include <utility>

namespace stylet::test {

inline std::string woodenJson(const std::string& key = {}, const std::string& value = {}) {
    static const std::array<std::pair<const char*, const char*>, 44> kFields{{
        {"variant", "0"},
        {"diameter_capstan_a", "0.010"},
        {"diameter_capstan_b", "0.011"},
        {"diameter_capstan_c", "0.012"},
        {"length_body_a", "0.080"},
        {"length_body_b", "0.205"},
        {"length_body_c", "0.245"},
        {"diameter_body_a", "0.160"},
        {"diameter_body_b", "0.120"},
        {"diameter_body_c", "0.125"},
        {"workspace_origin_x", "0.220"},
        {"workspace_origin_y", "0.000"},
        {"workspace_origin_z", "0.080"},
        {"workspace_radius", "0.100"},
        {"torque_constant_motor_a", "0.0259"},
        {"torque_constant_motor_b", "0.026"},
        {"torque_constant_motor_c", "0.027"},
        {"current_for_10_v_signal", "3"},
        {"cpr_encoder_a", "2000"},
        {"cpr_encoder_b", "2000"},
        {"cpr_encoder_c", "2000"},
        {"cpr_encoder_d", "0"},
        {"cpr_encoder_e", "0"},
        {"cpr_encoder_f", "0"},
        {"max_linear_force", "5"},
        {"max_linear_stiffness", "1000"},
        {"max_linear_damping", "8"},
        {"mass_body_b", "0.170"},
        {"mass_body_c", "0.110"},
        {"length_cm_body_b", "0.051"},
        {"length_cm_body_c", "0.091"},
        {"g_constant", "9.81"},
        {"calibrate_enc_a", "0"},
        {"calibrate_enc_b", "-10"},
        {"calibrate_enc_c", "6000"},
        {"calibrate_enc_d", "0"},
        {"calibrate_enc_e", "0"},
        {"calibrate_enc_f", "0"},
        {"motor_and_body_aligned_a", "false"},
        {"motor_and_body_aligned_b", "true"},
        {"motor_and_body_aligned_c", "0"},
        {"enc_and_body_aligned_d", "false"},
        {"enc_and_body_aligned_e", "true"},
        {"enc_and_body_aligned_f", "false"},
    }};
    std::string text;
    bool placed = key.empty();
    const auto add = [&text](const std::string& k, const std::string& v) {
        if (!v.empty()) text += (text.empty() ? "{\"" : ",\n\"") + k + "\": " + v;
    };
    for (const auto& [k, v] : kFields) {
        add(k, k == key ? value : v);
        placed = placed || k == key;
    }
    if (!placed) add(key, value);
    return text + "}\n";
}

}  // namespace stylet::test
