// Shows a record in a headset. The controller's stick scrubs it, and each tick looks the same as in the
// attempt.
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <regex>

#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

using test::Outcome;

constexpr int kReplayPixels = 320;
// The head looks at the point of entry on the skin. The scenario counts frames, not seconds, because the
// machine may be busy.
const std::string kReplayHead = R"({"version": 2, "eyes": {"recommended_size": [320, 320]},
    "head": [{"t_s": 0, "position": [0.12, 1.45, 0.0], "orientation": [-0.36, -0.06, 0, 0.93]}])";
// The stick is always pushed slightly to the right. But only from frame 16 to 32 does the mock present a
// controller that has a stick, so the replay scrubs only then.
const std::string kScrubs = kReplayHead + R"(, "exit_after_frames": 42,
    "controllers": {"right": {
        "poses": [{"t_s": 0, "position": [0.3, 1.0, -0.3], "orientation": [0, 0, 0, 1]}],
        "values": [{"t_s": 0, "thumbstick/x": 0.4}]}},
    "events": [{"frame": 16, "interaction_profile": "/interaction_profiles/oculus/touch_controller"},
               {"frame": 32, "interaction_profile": "/interaction_profiles/khr/simple_controller"},
               {"frame": 38, "capture": "there"}]})";
const std::string kLooks = kReplayHead + R"(, "exit_after_frames": 18})";

// PSNR of the image centres. They contain neither the guide panel nor an alert.
double psnrOfMiddles_db(const std::filesystem::path& a, const std::filesystem::path& b) {
    std::unique_ptr<stbi_uc, void (*)(void*)> pictures[2]{{nullptr, stbi_image_free},
                                                          {nullptr, stbi_image_free}};
    const std::filesystem::path files[2]{a, b};
    for (int i = 0; i < 2; ++i) {
        int width = 0, height = 0, channels = 0;
        pictures[i].reset(stbi_load(files[i].c_str(), &width, &height, &channels, 3));
        if (!pictures[i] || width != kReplayPixels || height != kReplayPixels)
            throw std::runtime_error(files[i].string());
    }
    double sum = 0.0;
    int count = 0;
    for (int y = 100; y < 250; ++y)
        for (int x = 81; x < 200; ++x)
            for (int c = 0; c < 3; ++c, ++count) {
                const std::size_t at = std::size_t(3 * (y * kReplayPixels + x) + c);
                const double d = double(pictures[0].get()[at]) - pictures[1].get()[at];
                sum += d * d;
            }
    return 10.0 * std::log10(255.0 * 255.0 * count / std::max(sum, 1e-9));
}

class ReplayHeadset : public testing::Test {
  protected:
    Outcome show(const std::string& scenario, const std::string& rest) {
        std::ofstream(command_ / "scenario.json") << scenario;
        return command_.run("replay --show '" + live_.string() + "' " + rest);
    }
    static double numberIn(const std::string& text, const char* before) {
        std::smatch found;
        if (!std::regex_search(text, found, std::regex(std::string(before) + " ([0-9.]+)"))) return -1.0;
        return std::stod(found[1]);
    }
    test::Command command_;
    std::filesystem::path live_ = command_ / "live";
};

TEST_F(ReplayHeadset, TheStickScrubsAndEachInstantIsThatOfTheAttempt) {
    std::ofstream(command_ / "scenario.json") << kReplayHead << "}";
    // Only the capture points that are compared. The replay draws each of them again.
    std::ofstream(command_ / "replayed.toml")
        << std::regex_replace(test::readText(test::testScenario("short")), std::regex("moments = .*"),
                              "moments = [\"approach\", \"duct\"]");
    command_.set("XRMOCK_SCENARIO", (command_ / "scenario.json").string());
    command_.set("DISPLAY", "");
    const Outcome attempt =
        command_.runInto(live_, "run --headless --fast --fps 1 --spacing-mm 2.5 --scenario '" +
                                    (command_ / "replayed.toml").string() + "'");
    ASSERT_EQ(attempt.status, 0) << attempt.err;

    command_.set("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST);
    const Outcome scrubbed = show(kScrubs, "--at 0.5");
    ASSERT_EQ(scrubbed.status, 0) << scrubbed.err;
    const std::filesystem::path there = command_.out() / "there_left.png";
    const double stood_s = numberIn(scrubbed.err, "the replay ended at");
    EXPECT_GT(stood_s, 0.51) << scrubbed.err;

    const Outcome looked = show(kLooks, "--at " + std::to_string(stood_s));
    ASSERT_EQ(looked.status, 0) << looked.err;
    EXPECT_GT(psnrOfMiddles_db(there, command_.out() / "at_left.png"), 38.0)
        << "scrubbed there, and gone there at once";

    double duct_s = 0.0;
    for (const auto& moment : attempt.summary.at("moments"))
        if (moment.at("name") == "duct") duct_s = 0.001 * moment.at("tick").get<double>();
    ASSERT_GT(duct_s, 0.0);
    const Outcome duct = show(kLooks, "--at " + std::to_string(duct_s));
    ASSERT_EQ(duct.status, 0) << duct.err;
    EXPECT_GT(psnrOfMiddles_db(live_ / "duct_left.png", command_.out() / "at_left.png"), 38.0);
    EXPECT_GT(psnrOfMiddles_db(live_ / "duct_left.png", command_.out() / "duct_left.png"), 38.0);
    EXPECT_LT(psnrOfMiddles_db(live_ / "approach_left.png", command_.out() / "at_left.png"), 38.0)
        << "another instant";
}

}  // namespace
}  // namespace stylet::trainer
