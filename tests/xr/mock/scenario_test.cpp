#include <fstream>
#include <random>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

class Scenario : public MockTest {
  protected:
    // The runtime's single line on stderr, without the file name.
    std::string refusal(const std::string& text) {
        setScript(text);
        testing::internal::CaptureStderr();
        EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE) << text;
        std::string output = testing::internal::GetCapturedStderr();
        const std::string start = "xrmock: " + file("scenario.json").string() + ": ";
        const std::size_t found = output.find(start);
        if (found == std::string::npos) return output;
        output = output.substr(found + start.size());
        return output.substr(0, output.find('\n'));
    }
};

TEST_F(Scenario, ErrorsNameFieldAndReason) {
    EXPECT_EQ(refusal("{}"), "document: version is missing");
    EXPECT_EQ(refusal("[]"), "document: an object expected");
    EXPECT_EQ(refusal(R"({"version": 3})"), "version: a number from 1 to 2 expected");
    EXPECT_EQ(refusal(R"({"version": 1, "haed": []})"), "haed: unknown field");
    EXPECT_EQ(refusal(R"({"version": 1, "head": []})"), "head: at least one key expected");
    EXPECT_EQ(refusal(R"({"version": 1, "head": [{"t_s": 0, "position": [1, 2]}]})"),
              "head[0].position: 3 numbers expected");
    EXPECT_EQ(refusal(R"({"version": 1, "head": [{"t_s": 0, "position": [1, 2, "x"]}]})"),
              "head[0].position[2]: a number expected");
    EXPECT_EQ(
        refusal(
            R"({"version": 1, "head": [{"t_s": 1, "position": [0,0,0]}, {"t_s": 1, "position": [0,0,0]}]})"),
        "head[1].t_s: later than the key before expected");
    EXPECT_EQ(
        refusal(R"({"version": 1, "head": [{"t_s": 1, "position": [0,0,0], "orientation": [0,0,0,0]}]})"),
        "head[0].orientation: a unit quaternion x y z w expected");
    EXPECT_EQ(refusal(R"({"version": 1, "session": [{"t_s": 0, "state": "asleep"}]})"),
              "session[0].state: focused, visible, synchronized, stopped or exiting expected");
    EXPECT_EQ(refusal(R"({"version": 1, "controllers": {"profile": "/interaction_profiles/x/y"}})"),
              "controllers.profile: not an interaction profile");
    EXPECT_EQ(refusal(R"({"version": 1, "eyes": {"left_fov_rad": [1, -1, 1, -1]}})"),
              "eyes.left_fov_rad: left < right and down < up expected");
    EXPECT_EQ(refusal(R"({"version": 1, "exit_after_frames": 0})"),
              "exit_after_frames: a number from 1 to 1e+09 expected");
    EXPECT_TRUE(refusal("{\"version\": 1").starts_with("document: parse error at line 1, "));
    EXPECT_NE(refusal("{\"version\": 1e999}").find("document: "), std::string::npos);
    EXPECT_NE(refusal(R"({"version": 1, "head": 1})").find("head: an array expected"), std::string::npos);
}

TEST_F(Scenario, AMissingFileAndABadClockAreRefused) {
    setVariable("XRMOCK_SCENARIO", file("none.json").string());
    EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE);
    setVariable("XRMOCK_SCENARIO", file("").string());
    EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE);
    setVariable("XRMOCK_SCENARIO", "");
    setVariable("XRMOCK_CLOCK", "imaginary");
    EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE);
    setVariable("XRMOCK_CLOCK", "");
    EXPECT_EQ(tryInstance(), XR_SUCCESS);
}

// Damaged scenarios are either rejected or accepted.
TEST_F(Scenario, DamagedFilesDoNotCrash) {
    const std::string whole =
        R"({"version":1,"refresh_hz":90,"eyes":{"ipd_m":0.06,"recommended_size":[64,64]},"head":[{"t_s":0,)"
        R"("position":[0,1,2],"orientation":[0,0,0,1]}],"controllers":{"left":{"poses":[{"t_s":0,"position":)"
        R"([0,0,0]}],"values":[{"t_s":1,"select/click":true}]}},"session":[{"t_s":1,"state":"visible"}]})";
    std::mt19937 random(7);
    testing::internal::CaptureStderr();
    for (int i = 0; i < 300; ++i) {
        std::string damaged = whole;
        for (unsigned edits = random() % 3 + 1; edits > 0; --edits) {
            const std::size_t at = random() % damaged.size();
            switch (random() % 3) {
                case 0:
                    damaged[at] = static_cast<char>(random() % 96 + 32);
                    break;
                case 1:
                    damaged.erase(at, random() % 8 + 1);
                    break;
                default:
                    damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 16));
                    break;
            }
            if (damaged.empty()) damaged = "{";
        }
        setScript(damaged);
        const XrResult result = tryInstance();
        EXPECT_TRUE(result == XR_SUCCESS || result == XR_ERROR_RUNTIME_FAILURE) << damaged;
        if (result == XR_SUCCESS) xrDestroyInstance(instance_);
        instance_ = XR_NULL_HANDLE;
    }
    testing::internal::GetCapturedStderr();
}

}  // namespace
}  // namespace mock_test
