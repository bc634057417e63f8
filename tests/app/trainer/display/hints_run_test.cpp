// Tests the hints in the headset at each difficulty, by comparing the mock runtime's images of the same
// capture point.
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include <array>
#include <cstdlib>
#include <fstream>
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

}  // namespace
}  // namespace stylet::trainer
