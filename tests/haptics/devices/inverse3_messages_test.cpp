#include "haptics/devices/inverse3/inverse3_messages.h"

#include <gtest/gtest.h>

#include <string>

namespace stylet::haptics::inverse3 {
namespace {

// Based on the examples in the documentation. The newer message has fields that only version 3.5 sends.
const std::string kOlder =
    R"({"inverse3":[{"device_id":"04BA","config":{"type":"inverse3","handedness":"right"},)"
    R"("state":{"cursor_position":{"x":0.07842738,"y":-0.14836666,"z":0.14297646},"mode":"idle"},)"
    R"("status":{"calibrated":false,"in_use":false,"power_supply":true,"ready":true,"started":true}}],)"
    R"("verse_grip":[{"device_id":"61548","state":{"button":true,"hall":0,)"
    R"("orientation":{"x":-0.5019531,"y":0.8632202,"z":-0.048095703,"w":-0.022338867}}}]})";
const std::string kNewer =
    R"({"session_id":7,"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.0,"y":-0.12,"z":0.15},)"
    R"("control_mode":"idle"}}],"wireless_verse_grip":[{"device_id":"8","state":{"buttons":{"a":true,"b":false,)"
    R"("c":true},"orientation":{"w":1.0,"x":0.0,"y":0.0,"z":0.0}}}]})";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), with);
}

std::string refusal(const std::string& text) {
    std::string why;
    return parseUpdate(text, why) ? "" : why;
}

TEST(Inverse3Messages, ReadsTheOlderInventory) {
    std::string why;
    const auto update = parseUpdate(kOlder, why);
    ASSERT_TRUE(update) << why;
    EXPECT_TRUE(update->present);
    EXPECT_EQ(update->device_id, "04BA");
    EXPECT_EQ(update->cursor_m, Vec3(0.07842738, -0.14836666, 0.14297646));
    EXPECT_FALSE(update->calibrated);
    EXPECT_TRUE(update->ready && update->powered && update->grip_present);
    EXPECT_EQ(update->buttons, 1u);
    EXPECT_FALSE(update->has_session);
    EXPECT_NEAR(glm::length(update->haply_from_grip), 1.0, 1e-15);
}

TEST(Inverse3Messages, ReadsTheNewerInventory) {
    std::string why;
    const auto update = parseUpdate(kNewer, why);
    ASSERT_TRUE(update) << why;
    EXPECT_EQ(update->device_id, "049D");
    EXPECT_TRUE(update->calibrated && update->ready && update->powered);  // missing fields default to true
    EXPECT_EQ(update->buttons, 5u);
    EXPECT_TRUE(update->has_session);
}

// Haply: x right, y forward (away from the user), z up. Device: x right, y up, z toward the user.
TEST(Inverse3Messages, TheStylusLiesAlongTheGrip) {
    constexpr double kHalf = 0.70710678118654752;
    const auto needle = [](const Update& update) { return stylusPose(update).direction({0.0, 0.0, -1.0}); };
    Update update;
    update.cursor_m = {0.1, 0.2, 0.3};
    update.grip_present = true;
    // The grip points along its +y. The needle's tip points along -z: forward.
    EXPECT_NEAR(glm::distance(needle(update), Vec3(0.0, 0.0, -1.0)), 0.0, 1e-15);
    EXPECT_EQ(stylusPose(update).position_m, Vec3(0.1, 0.3, -0.2));
    update.haply_from_grip = Quat(kHalf, 0.0, 0.0, -kHalf);  // y to x: to the right
    EXPECT_NEAR(glm::distance(needle(update), Vec3(1.0, 0.0, 0.0)), 0.0, 1e-15);
    update.haply_from_grip = Quat(kHalf, kHalf, 0.0, 0.0);  // y to z: up
    EXPECT_NEAR(glm::distance(needle(update), Vec3(0.0, 1.0, 0.0)), 0.0, 1e-15);
    update.grip_present = false;
    EXPECT_EQ(stylusPose(update).rotation, Quat(1.0, 0.0, 0.0, 0.0));
    EXPECT_EQ(stylusPose(update).position_m, Vec3(0.1, 0.3, -0.2));
}

// A force to the user's right, up, or toward the user keeps its direction.
// HZ-FORCE-10
TEST(Inverse3Messages, TheForceIsWrittenInHaplysFrame) {
    const std::pair<Vec3, const char*> cases[] = {
        {{2.0, 0.0, 0.0}, R"({"x":2,"y":0,"z":0})"},
        {{0.0, 2.0, 0.0}, R"({"x":0,"y":0,"z":2})"},
        {{0.0, 0.0, 2.0}, R"({"x":0,"y":-2,"z":0})"},
    };
    for (const auto& [force_n, written] : cases) {
        std::string text;
        writeForce(text, "049D", force_n, Spelling::vector);
        EXPECT_NE(text.find(written), std::string::npos) << text;
    }
}

TEST(Inverse3Messages, MessageWithoutADeviceIsValid) {
    std::string why;
    for (const char* text : {"{}", R"({"inverse3":[]})", R"({"inverse3":null,"verse_grip":[]})"}) {
        const auto update = parseUpdate(text, why);
        ASSERT_TRUE(update) << why;
        EXPECT_FALSE(update->present);
    }
}

// HZ-FORCE-21
TEST(Inverse3Messages, EachBadFieldIsNamed) {
    const char* position = "inverse3: state.cursor_position";
    EXPECT_EQ(refusal(replaced(kNewer, "\"y\":-0.12", "\"y\":1e6")), position);
    EXPECT_EQ(refusal(replaced(kNewer, "\"y\":-0.12", "\"y\":\"0\"")), position);
    EXPECT_EQ(refusal(replaced(kNewer, "\"y\":-0.12", "\"y\":null")), position);
    EXPECT_EQ(refusal(replaced(kNewer, "\"y\":-0.12,", "")), position);
    EXPECT_EQ(refusal(replaced(kNewer, "cursor_position", "cursor_velocity")), position);
    EXPECT_EQ(refusal(replaced(kNewer, "049D", "04\\\"9D")), "inverse3: device_id");
    EXPECT_EQ(refusal(replaced(kNewer, "\"049D\"", "49")), "inverse3: device_id");
    EXPECT_EQ(refusal(replaced(kNewer, "049D", "")), "inverse3: device_id");
    EXPECT_EQ(refusal(replaced(kNewer, "\"w\":1.0", "\"w\":2.0")), "wireless_verse_grip: state.orientation");
    EXPECT_EQ(refusal(R"({"inverse3":{}})"), "inverse3");
    EXPECT_EQ(refusal(R"({"inverse3":[7]})"), "inverse3");
    EXPECT_EQ(refusal(R"({"verse_grip":3})"), "verse_grip");
    std::string many = R"({"inverse3":[{})";
    for (int i = 0; i < 16; ++i)
        many += ",{}";
    EXPECT_EQ(refusal(many + "]}"), "inverse3");
}

TEST(Inverse3Messages, InvalidOrOversizedJsonIsRefused) {
    const char* why = "not JSON within the limits";
    for (const std::string& text : {std::string(), std::string("7"), std::string("[]"), kNewer + "x",
                                    kNewer.substr(0, kNewer.size() - 1), replaced(kNewer, "-0.12", "NaN"),
                                    replaced(kNewer, "-0.12", "1e999"), std::string(100'000, '['),
                                    R"({"a":)" + std::string(20, '[') + std::string(20, ']') + "}",
                                    "{\"a\":\"" + std::string(300'000, 'x') + "\"}",
                                    std::string("{\"a\":\"\xFF\"}"), std::string("{\"a\":\"\0\"}", 9)})
        EXPECT_EQ(refusal(text), why) << text.substr(0, 60);
    // Brackets inside strings do not count as nesting.
    std::string ignored;
    EXPECT_TRUE(parseUpdate(R"({"a":"\"[[[[[[[[[[[[[[[[[[[[[["})", ignored)) << ignored;
}

TEST(Inverse3Messages, TheVersionDecidesTheSpelling) {
    EXPECT_EQ(parseSpelling(R"({"project_version":"3.5.0.0"})"), Spelling::vector);
    EXPECT_EQ(parseSpelling(R"({"ok":true,"data":{"project_version":"3.12.1"}})"), Spelling::vector);
    EXPECT_EQ(parseSpelling(R"({"project_version":"4.0.0"})"), Spelling::vector);
    EXPECT_EQ(parseSpelling(R"({"project_version":"3.1.1.0"})"), Spelling::values);
    EXPECT_EQ(parseSpelling(R"({"project_version":"3.4"})"), Spelling::values);
    for (const char* text : {"", "3.5", "{}", R"({"project_version":3.5})", R"({"project_version":"3"})",
                             R"({"project_version":"x.5"})", R"({"project_version":"99999999999.1"})"})
        EXPECT_FALSE(parseSpelling(text)) << text;
}

TEST(Inverse3Messages, WritesTheCommandByteForByte) {
    std::string text;
    writeForce(text, "049D", {0.0, 1.5, 0.25}, Spelling::vector);
    EXPECT_EQ(
        text,
        R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":0,"y":-0.25,"z":1.5}}}}]})");
    writeForce(text, "049D", {1e-7, 0.0, 0.0}, Spelling::values);
    EXPECT_EQ(
        text,
        R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"values":{"x":1e-07,"y":0,"z":0}}}}]})");
}

}  // namespace
}  // namespace stylet::haptics::inverse3
