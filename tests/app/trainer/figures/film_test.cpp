// Runs `stylet film` as a user does, on a small patient.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "patient/motion/recording.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/app/trainer/marker.h"

namespace stylet::trainer {
namespace {

using testing::HasSubstr;

#ifdef STYLET_PICTURES
constexpr bool kHasPictures = true;
#else
constexpr bool kHasPictures = false;  // a build without Vulkan and OpenXR
#endif

using test::Command;
using test::Outcome;

struct Row {
    double t_s, v, rate_per_s, creep_v, held, dome_mm;
};

std::vector<Row> rowsOf(const std::filesystem::path& csv) {
    std::istringstream text(test::readText(csv));
    std::string line;
    std::getline(text, line);
    EXPECT_EQ(line, "time_s,v,rate_per_s,creep_v,held,dome_mm");
    std::vector<Row> rows;
    while (std::getline(text, line)) {
        Row r{};
        EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf", &r.t_s, &r.v, &r.rate_per_s,
                              &r.creep_v, &r.held, &r.dome_mm),
                  6)
            << line;
        rows.push_back(r);
    }
    return rows;
}

// Size in the header of a PNG.
std::array<std::uint32_t, 2> sizeOf(const std::filesystem::path& png) {
    const std::string bytes = test::readText(png);
    if (bytes.size() < 24 || bytes.substr(1, 3) != "PNG") return {0, 0};
    const auto number = [&](std::size_t at) {
        std::uint32_t n = 0;
        for (std::size_t i = 0; i < 4; ++i)
            n = n << 8 | std::uint8_t(bytes[at + i]);
        return n;
    };
    return {number(16), number(20)};
}

class Film : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        command_ = new Command;
        test::writeMarker(*command_ / "marker.csv", 4.0);
        recorded_ =
            new Outcome(command_->run(film() + " --scenario demo-breathing --recording '" +
                                      (*command_ / "marker.csv").string() + "' --no-stereo --frames 6"));
        out_ = command_->out();
    }
    static void TearDownTestSuite() {
        delete recorded_;
        delete command_;
    }
    static std::string film() { return "film --spacing-mm 2.5"; }

    static inline Command* command_ = nullptr;
    static inline Outcome* recorded_ = nullptr;
    static inline std::filesystem::path out_;
};

TEST_F(Film, TheTableFollowsTheRecording) {
    ASSERT_EQ(recorded_->status, 0) << recorded_->err;
    const patient::RecordedBreath marker = patient::loadRecordedBreath(*command_ / "marker.csv");
    const std::vector<Row> rows = rowsOf(out_ / "breath.csv");
    ASSERT_GT(rows.size(), 500u);
    double most_v = 0.0, most_mm = 0.0;
    for (const Row& r : rows) {
        const double at = std::fmod(r.t_s / marker.dt_s, double(marker.v.size()));
        const auto low = std::size_t(at);
        const double f = at - double(low);
        const double v = (1.0 - f) * marker.v[low] + f * marker.v[(low + 1) % marker.v.size()];
        ASSERT_NEAR(r.v, v, 0.02) << r.t_s;
        ASSERT_EQ(r.held, 0.0);
        // Hysteresis adds up to 2 mm to the 15 mm per unit of v.
        ASSERT_NEAR(r.dome_mm, 15.0 * r.v, 2.0) << r.t_s;
        most_v = std::max(most_v, r.v), most_mm = std::max(most_mm, r.dome_mm);
    }
    EXPECT_GT(most_v, 0.95);
    EXPECT_GT(most_mm, 13.0);
    EXPECT_THAT(recorded_->out, HasSubstr("the dome travels"));
}

TEST_F(Film, EveryPictureIsThereAndTheSheetHoldsThemAll) {
    EXPECT_GT(sizeOf(out_ / "breath.png")[0], 1000u);
    const auto frame = sizeOf(out_ / "coronal-000.png"), sheet = sizeOf(out_ / "coronal.png");
    EXPECT_GT(frame[0], 400u);
    EXPECT_EQ(sizeOf(out_ / "coronal-005.png"), frame);
    EXPECT_FALSE(std::filesystem::exists(out_ / "coronal-006.png"));
    EXPECT_FALSE(std::filesystem::exists(out_ / "stereo.png"));
    // The sheet has three columns and two rows, and its pictures are not scaled down.
    EXPECT_EQ(sheet[0] / frame[0], 3u);
    EXPECT_EQ(sheet[1] / frame[1], 2u);
    // The patient has moved.
    EXPECT_NE(test::readText(out_ / "coronal-000.png"), test::readText(out_ / "coronal-003.png"));
}

TEST_F(Film, WritesStereoPictures) {
    const Outcome outcome = command_->run(film() + " --frames 2 --seconds 4");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::filesystem::path& out = command_->out();
    if (!kHasPictures) {
        EXPECT_THAT(outcome.err, HasSubstr("no stereo view"));
        EXPECT_TRUE(std::filesystem::exists(out / "coronal.png"));
        return;
    }
    const auto frame = sizeOf(out / "stereo-000.png");
    EXPECT_EQ(frame[0], 1280u);
    EXPECT_GE(frame[1], 640u);
    EXPECT_NE(test::readText(out / "stereo-000.png"), test::readText(out / "stereo-001.png"));
}

TEST_F(Film, LooksShowEveryViewOfThePatient) {
    const Outcome outcome = command_->run("looks --spacing-mm 2.5 --pixels 96");
    const std::filesystem::path& out = command_->out();
    EXPECT_GT(sizeOf(out / "classes.png")[0], 1000u) << outcome.err;
    if (!kHasPictures) {
        EXPECT_EQ(outcome.status, 3);
        EXPECT_THAT(outcome.err, HasSubstr("no pictures can be drawn"));
        return;
    }
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::vector<std::string> seen;
    for (int i = 0; i < 8; ++i) {
        const std::filesystem::path file = out / ("looks-00" + std::to_string(i) + ".png");
        EXPECT_EQ(sizeOf(file)[0], 2u * 96u);
        seen.push_back(test::readText(file));
        EXPECT_EQ(std::count(seen.begin(), seen.end(), seen.back()), 1) << i;
    }
}

TEST_F(Film, BreathHoldStopsTheDome) {
    const Outcome held = command_->run(film() + " --no-stereo --frames 1");
    ASSERT_EQ(held.status, 0) << held.err;
    int ticks_held = 0;
    for (const Row& r : rowsOf(command_->out() / "breath.csv"))
        if (r.held != 0.0) {
            ++ticks_held;
            ASSERT_NEAR(r.dome_mm, 0.0, 1e-6) << r.t_s;  // the breath is held at end-exhale
        }
    EXPECT_GT(ticks_held, 500);
    EXPECT_THAT(held.out, HasSubstr("held"));
}

TEST_F(Film, RefusesInvalidOptions) {
    EXPECT_NE(command_->run(film() + " --frames 0").status, 0);
    const Outcome missing = command_->run(film() + " --recording /no/such.csv");
    EXPECT_EQ(missing.status, 2);
    EXPECT_THAT(missing.err, HasSubstr("/no/such.csv"));
}

// Uses every ninth of the available recordings. Their travel is not 15 mm, but the dome must follow each of
// them.
TEST_F(Film, TheDomeFollowsRealRecordings) {
    const char* data = std::getenv("STYLET_DATA");
    if (!data) GTEST_SKIP() << "STYLET_DATA is not set: it names the folder that holds breathing/";
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "breathing")) {
        if (entry.path().extension() != ".csv" || ++files % 9 != 0) continue;
        const Outcome outcome = command_->run(film() + " --no-stereo --frames 1 --scenario demo-breathing" +
                                              " --recording '" + entry.path().string() + "'");
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        double least_mm = 1e9, most_mm = -1e9;
        for (const Row& r : rowsOf(command_->out() / "breath.csv"))
            least_mm = std::min(least_mm, r.dome_mm), most_mm = std::max(most_mm, r.dome_mm);
        EXPECT_GT(most_mm - least_mm, 8.0) << entry.path();
        EXPECT_LT(most_mm - least_mm, 30.0) << entry.path();
    }
    EXPECT_EQ(files, 27);
}

}  // namespace
}  // namespace stylet::trainer
