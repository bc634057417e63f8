// Tests the hints in the headset at each difficulty, by comparing the mock runtime's images of the same
// capture point.
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <regex>

#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

constexpr int kHintsPixels = 512;
// The head looks at the entry; the panel is on the right.
const std::string kHintsHead = R"({"version": 2, "eyes": {"recommended_size": [512, 512]},
    "head": [{"t_s": 0, "position": [0.12, 1.45, 0.0], "orientation": [-0.36, -0.06, 0, 0.93]}]})";

class HintsRun : public testing::Test {
  protected:
    struct Seen {
        test::Outcome outcome;
        std::filesystem::path folder;
        double skip(const char* name) const { return outcome.summary.at("skips").at(name).get<double>(); }
    };
    static Seen run(const std::string& difficulty, const std::string& look = "closed") {
        std::ofstream(command_ / "scenario.json") << kHintsHead;
        // Only the capture points that are compared.
        std::ofstream(command_ / "hints.toml")
            << std::regex_replace(test::readText(test::testScenario("short")), std::regex("moments = .*"),
                                  "moments = [\"approach\", \"duct\"]");
        command_.set("XRMOCK_SCENARIO", (command_ / "scenario.json").string());
        Seen seen;
        seen.outcome = command_.run("run --headless --fast --fps 1 --spacing-mm 2.5 --scenario '" +
                                    (command_ / "hints.toml").string() + "' --difficulty " + difficulty +
                                    " --look " + look);
        seen.folder = command_.out();
        return seen;
    }
    // Fraction of pixels in these columns and rows of the left eye that differ clearly.
    static double difference(const Seen& a, const Seen& b, const std::string& moment, int x0, int x1, int y0,
                             int y1) {
        std::array<std::unique_ptr<stbi_uc, void (*)(void*)>, 2> pictures{
            {{nullptr, stbi_image_free}, {nullptr, stbi_image_free}}};
        const std::array folders{&a.folder, &b.folder};
        for (std::size_t i = 0; i < 2; ++i) {
            int width = 0, height = 0, channels = 0;
            const std::string file = (*folders[i] / (moment + "_left.png")).string();
            pictures[i].reset(stbi_load(file.c_str(), &width, &height, &channels, 3));
            if (!pictures[i] || width != kHintsPixels || height != kHintsPixels)
                throw std::runtime_error(file);
        }
        int differing = 0;
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x)
                for (int c = 0; c < 3; ++c) {
                    const std::size_t at = std::size_t(3 * (y * kHintsPixels + x) + c);
                    if (std::abs(int(pictures[0].get()[at]) - int(pictures[1].get()[at])) <= 25) continue;
                    ++differing;
                    break;
                }
        return double(differing) / ((x1 - x0) * (y1 - y0));
    }
    static inline test::Command command_;
};

// HZ-TEACH-12
TEST_F(HintsRun, AnExamShowsNothingButTheRoom) {
    const Seen guided = run("guided"), practice = run("practice"), exam = run("exam", "reveal"),
               closed = run("exam"), open = run("guided", "reveal");
    for (const Seen* seen : {&guided, &practice, &exam, &closed, &open})
        ASSERT_EQ(seen->outcome.status, 0) << seen->outcome.err;
    EXPECT_EQ(guided.outcome.summary.at("state_hash"), exam.outcome.summary.at("state_hash"))
        << "what is shown is never felt";

    EXPECT_GT(guided.skip("panels_drawn"), 0.0);
    EXPECT_EQ(exam.skip("panels_drawn"), 0.0);
    EXPECT_EQ(exam.skip("unseen_panels"), 0.0) << "there is none";
    // The panel is in the upper right corner. The rest of the border shows only the room, in which an exam's
    // patient lies elsewhere.
    EXPECT_GT(difference(guided, exam, "approach", 340, 512, 0, 120), 0.5);
    EXPECT_LT(difference(guided, exam, "approach", 0, 180, 300, 512), 0.2);
    // An exam closes the skin, whatever look was asked for.
    EXPECT_GT(difference(guided, open, "approach", 120, 290, 140, 320), 0.3);
    EXPECT_LT(difference(closed, exam, "approach", 120, 290, 140, 320), 0.01);
    // The drape's opening is not at the entry, and the entry is not in the middle of the view.
    EXPECT_GT(difference(practice, exam, "approach", 120, 290, 140, 320), 0.05);
    // The reference path is drawn at the guided level only.
    const double ghost = difference(guided, practice, "approach", 120, 290, 140, 320);
    EXPECT_GT(ghost, 0.0002);
    EXPECT_LT(ghost, 0.1) << "a thin line";
    // When the target is reached, the border shows an alert, and the middle of the image stays free but for
    // the exam's other drape.
    EXPECT_GT(difference(practice, exam, "duct", 0, 512, 0, 20), 0.8);
    EXPECT_LT(difference(practice, exam, "duct", 130, 320, 160, 400), 0.2);
}

// Two exams whose planned paths differ, with the same hand: nothing that the trainee sees may differ.
// HZ-TEACH-24
TEST_F(HintsRun, AnExamsPicturesDoNotDependOnThePlannedPath) {
    std::ofstream(command_ / "room.toml") << R"(name = "room"
description = "X-rays first, because the time of a move depends on the path."
moments = ["xray", "skin", "liver"]
approach_distance_mm = 5.0
[start]
deeper_mm = -10.0
[hand]
ramp_s = 0.1
tremor_mm = 0.1
tremor_low_hz = 8.0
tremor_high_hz = 10.0
[[stage]]
do = "pedal"
down = true
[[stage]]
do = "wait"
seconds = 0.3
[[stage]]
do = "pedal"
down = false
[[stage]]
do = "move"
share = 1.0
speed_mm_s = 50.0
)";
    command_.unset("XRMOCK_SCENARIO");  // the head leans over the field
    const std::string run = "run --headless --fast --spacing-mm 2.5 --look closed --scenario '" +
                            (command_ / "room.toml").string() + "'";
    ASSERT_EQ(command_.run(run + " --fps 0").status, 0);
    const std::string hand = (command_ / "hand.csv").string();
    ASSERT_EQ(
        command_
            .run("replay '" + (command_.out() / "record").string() + "' --fast --save-hand '" + hand + "'")
            .status,
        0);
    const auto pictures = [&](const std::string& difficulty, const std::string& path) {
        const test::Outcome outcome = command_.run(run + " --fps 0.5 --device replay --trace '" + hand +
                                                   "' --difficulty " + difficulty + " --path " + path);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        std::map<std::string, std::string> files;
        for (const auto& file : std::filesystem::directory_iterator(command_.out()))
            if (file.path().extension() == ".png" && file.path().stem() != "slices" &&
                file.path().stem() != "force-depth")  // those two are written after the attempt
                files[file.path().filename()] = test::readText(file.path());
        return files;
    };
    const auto exam = pictures("exam", "1"), other = pictures("exam", "20"),
               practice = pictures("practice", "1"), other_practice = pictures("practice", "20");
    EXPECT_GE(exam.size(), 9u) << "both eyes and the X-ray screen at three captures";
    for (const auto* all : {&other, &practice, &other_practice})
        ASSERT_EQ(all->size(), exam.size());
    for (const auto& [name, picture] : exam) {
        EXPECT_TRUE(picture == other.at(name)) << name;
        if (name.ends_with("_left.png") || name == "xray_xray.png") {
            EXPECT_FALSE(practice.at(name) == other_practice.at(name)) << name;
        }
    }
}

}  // namespace
}  // namespace stylet::trainer
