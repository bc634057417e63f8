#include "haptics/devices/woodenhaptics/woodenhaptics_model.h"

#include <gtest/gtest.h>

#include "tests/haptics/devices/wooden_json.h"
#include "tests/support/refused.h"

namespace stylet::haptics {
namespace {

using test::expectRefused;
using test::woodenJson;

void refuses(const std::string& text, const std::string& field) {
    expectRefused([&] { parseWoodenModel(text, "arm.json"); }, "arm.json", field);
}

TEST(WoodenModel, ReadsTheLibrarysFile) {
    const WoodenModel m = parseWoodenModel(woodenJson(), "arm.json");
    EXPECT_EQ(m.capstan_diameter_m, (std::array<double, 3>{0.010, 0.011, 0.012}));
    EXPECT_EQ(m.body_diameter_m, (std::array<double, 3>{0.160, 0.120, 0.125}));
    EXPECT_EQ(m.length_m, (std::array<double, 3>{0.080, 0.205, 0.245}));
    EXPECT_EQ(m.torque_constant_n_m_per_a, (std::array<double, 3>{0.0259, 0.026, 0.027}));
    EXPECT_EQ(m.counts_per_turn, (std::array<double, 6>{2000, 2000, 2000, 0, 0, 0}));
    EXPECT_EQ(m.calibration_counts, (std::array<std::int16_t, 6>{0, -10, 6000, 0, 0, 0}));
    EXPECT_EQ(m.motor_aligned, (std::array<bool, 3>{false, true, false}));
    EXPECT_EQ(m.workspace_origin_m, Vec3(0.220, 0.0, 0.080));
    EXPECT_EQ(m.workspace_radius_m, 0.1);
    EXPECT_EQ(m.force_peak_n, 5.0);
    EXPECT_EQ(m.stiffness_n_per_m, 1000.0);
    EXPECT_FALSE(m.hasWrist());
}

TEST(WoodenModel, NamesTheFieldThatIsBad) {
    refuses(woodenJson("length_body_b", ""), "length_body_b");
    refuses(woodenJson("length_body_b", "\"0.2\""), "length_body_b");
    refuses(woodenJson("length_body_b", "0.0"), "length_body_b");
    refuses(woodenJson("length_body_b", "1e999"), "json");
    refuses(woodenJson("diameter_body_c", "-0.1"), "diameter_body_c");
    refuses(woodenJson("torque_constant_motor_a", "0"), "torque_constant_motor_a");
    refuses(woodenJson("cpr_encoder_a", "0"), "cpr_encoder_a");
    refuses(woodenJson("cpr_encoder_e", "1024"), "cpr_encoder_d");
    refuses(woodenJson("calibrate_enc_c", "40000"), "calibrate_enc_c");
    refuses(woodenJson("calibrate_enc_c", "0.5"), "calibrate_enc_c");
    refuses(woodenJson("motor_and_body_aligned_b", "2"), "motor_and_body_aligned_b");
    refuses(woodenJson("variant", "3"), "variant");
    refuses(woodenJson("max_linear_force", "null"), "max_linear_force");
    refuses(woodenJson("g_constant", "[9.81]"), "g_constant");
}

TEST(WoodenModel, RefusesInvalidFiles) {
    refuses("", "json");
    refuses("{", "json");
    refuses("[1, 2]", "json");
    refuses("{\"variant\": {\"a\": {\"b\": 1}}}", "variant");
    refuses(woodenJson("a_key_of_ours", "1"), "a_key_of_ours");
    std::string twice = woodenJson();
    twice.insert(1, "\"variant\": 0,");
    refuses(twice, "variant");
}

// The manufacturer's library writes the fifth value under the fourth's name.
TEST(WoodenModel, ExplainsTheLibrarysDuplicateKey) {
    std::string text = woodenJson();
    const std::size_t at = text.find("enc_and_body_aligned_e");
    text.replace(at, 22, "enc_and_body_aligned_d");
    refuses(text,
            "enc_and_body_aligned_d: given twice: the maker's library writes this key instead of "
            "enc_and_body_aligned_e");
}

TEST(WoodenModel, ReportsMissingAndOversizedFiles) {
    expectRefused([] { loadWoodenModel("/nonexistent/arm.json"); }, "/nonexistent/arm.json", "file");
    expectRefused([] { loadWoodenModel("/dev/zero"); }, "/dev/zero", "file");
}

}  // namespace
}  // namespace stylet::haptics
