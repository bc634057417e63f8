#include "patient/motion/recording.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

#include "patient/motion/signal.h"
#include "tests/support/refused.h"

namespace stylet::patient {
namespace {

const std::string kHead = "\"Frame\";\"Timestamp\";\"x\";\"y\";\"z\"\r\n";

std::string decimal(double value) {
    std::string text = fmt::format("{:.4f}", value);
    std::replace(text.begin(), text.end(), '.', ',');
    return text;
}

std::string rowAt(double t_ms, double x_mm, double y_mm, double z_mm) {
    return fmt::format("{};{};{};{};{}\r\n", int(t_ms * 0.06), decimal(t_ms), decimal(x_mm), decimal(y_mm),
                       decimal(z_mm));
}

// A marker that rises by 12 mm and moves 5 mm sideways, ten times in 50 s.
std::string marker(double seconds = 50.0) {
    std::string csv = kHead;
    for (int i = 0; i * 0.1 <= seconds; ++i) {
        const double v = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (i * 0.1 - 1.0) / 5.0);
        csv += rowAt(i * 100.0, -400.0 + 5.0 * v, 3.0, 60.0 + 12.0 * v);
    }
    return csv;
}

RecordedBreath parse(const std::string& csv) {
    return parseRecordedBreath(csv, "breath.csv");
}

void expectRefused(const std::string& csv, const std::string& field) {
    test::expectRefused([&] { (void)parse(csv); }, "breath.csv", field);
}

void expectLine2Refused(const std::string& row) {
    expectRefused(kHead + row, "line 2");
}

TEST(RecordedBreath, IsScaledByItsOwnBreathsAndClosed) {
    const RecordedBreath r = parse(marker());
    EXPECT_EQ(r.breaths, 8);
    EXPECT_NEAR(r.period_s, 5.0, 0.1);
    EXPECT_NEAR(r.travel_m, 0.013 * 0.98, 0.0002);  // reduced by smoothing
    ASSERT_EQ(r.v.size(), 400u);
    for (std::size_t i = 0; i < r.v.size(); ++i)
        ASSERT_NEAR(r.v[i], 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * double(i) * 0.1 / 5.0), 0.002);
    EXPECT_EQ(r.misdated_rows, 0);
    EXPECT_EQ(r.zero_rows, 0);
}

TEST(RecordedBreath, AcceptsEitherDecimalMarkAndLineEnding) {
    std::string points = marker();
    std::replace(points.begin(), points.end(), ',', '.');
    std::erase(points, '\r');
    std::erase(points, '"');
    EXPECT_EQ(parse(points).v, parse(marker()).v);
    points.pop_back();
    EXPECT_EQ(parse(points).v, parse(marker()).v);
}

TEST(RecordedBreath, DropsZerosAtTheEndAndRowsDatedOutOfOrder) {
    const std::vector<double> whole = parse(marker()).v;
    const RecordedBreath zeros = parse(marker() + "0;0;0;0;0\r\n0;0;0;0;0\r\n");
    EXPECT_EQ(zeros.v, whole);
    EXPECT_EQ(zeros.zero_rows, 2);

    std::string csv = marker();
    const std::size_t at = csv.find(";12700,0000;");
    ASSERT_NE(at, std::string::npos);
    csv.replace(at, 12, ";25,4;");
    const RecordedBreath misdated = parse(csv);
    EXPECT_EQ(misdated.misdated_rows, 1);
    ASSERT_EQ(misdated.v.size(), whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i)
        ASSERT_NEAR(misdated.v[i], whole[i], 0.01);
}

TEST(RecordedBreath, LoopClosesWithoutAJump) {
    // The level rises by 4 mm over the recording.
    std::string csv = kHead;
    for (int i = 0; i <= 500; ++i)
        csv += rowAt(
            i * 100.0, 0.0, 0.0,
            60.0 + 0.008 * i + 10.0 * (0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (i * 0.1 - 1.0) / 5.0)));
    const RecordedBreath r = parse(csv);
    EXPECT_LT(std::fabs(r.v.front() - r.v.back()), 0.02);
}

TEST(RecordedBreath, RejectsInvalidRecordings) {
    expectRefused("", "line 1");
    expectRefused("Frame;Timestamp;x;y\n1;2;3;4\n", "line 1");
    expectRefused("Frame;Timestamp;x;y;z;w\n", "line 1");
    expectRefused(std::string(kHead), "rows");
    expectRefused(kHead + "0;0;0;0;0\n", "rows");
    expectLine2Refused("0;0;1;1\n");
    expectLine2Refused("0;0;1;1;1;1\n");
    expectLine2Refused("0;0;1;1;nan\n");
    expectLine2Refused("0;0;1;1;1e999\n");
    expectLine2Refused("0;0;1;1;0x10\n");
    expectLine2Refused("0;0;1;1;1,5,2\n");
    expectLine2Refused("0;0;1;1;20000\n");
    expectLine2Refused("0;-5;1;1;1\n");
    expectLine2Refused("0;1e12;1;1;1\n");
    expectRefused(kHead + "\n" + marker(), "line 2");
    expectRefused(kHead + std::string(100, '1') + ";0;1;1;1\n", "line 2");
    expectRefused(marker(8.0), "rows");  // only one whole breath
    std::string csv = marker();
    csv.insert(csv.find('\n', 5000) + 1, "0;0;0;0;0\r\n");
    expectRefused(csv, "line");

    std::string leap = kHead;  // one row is off by several metres
    for (int i = 0; i < 500; ++i)
        leap += rowAt(i * 100.0, 0.0, 0.0, i == 250 ? 7024.0 : 60.0 + 12.0 * std::sin(0.12 * i));
    expectRefused(leap, "x, y, z");

    // A gap of three seconds, timestamps that stop, and a marker that does not move.
    std::string gap = kHead, still = kHead, rigid = kHead;
    for (int i = 0; i < 300; ++i) {
        const double z_mm = 60.0 + 12.0 * std::sin(0.12 * i);
        gap += rowAt(i * 100.0 + (i > 150 ? 3000.0 : 0.0), 0.0, 0.0, z_mm);
        still += rowAt(i < 150 ? i * 100.0 : 14900.0, 0.0, 0.0, z_mm);
        rigid += rowAt(i * 100.0, 1.0, 2.0, 3.0);
    }
    expectRefused(gap, "Timestamp");
    expectRefused(still, "Timestamp");
    expectRefused(rigid, "x, y, z");
    EXPECT_THROW((void)loadRecordedBreath("no-such-file.csv"), DataError);
}

// A damaged file is rejected, or the result is finite, bounded and periodic.
TEST(RecordedBreath, SurvivesDamage) {
    const std::string good = marker();
    std::mt19937 random(5);
    int taken = 0;
    for (int i = 0; i < 400; ++i) {
        std::string csv = good;
        for (int k = 0; k < 3; ++k)
            csv[random() % csv.size()] = "0123456789;,.-e\n\"Z"[random() % 18];
        if (i % 4 == 0) csv.resize(random() % csv.size());
        try {
            const RecordedBreath r = parse(csv);
            ASSERT_FALSE(r.v.empty());
            for (const double v : r.v)
                ASSERT_TRUE(std::isfinite(v) && std::fabs(v) < 1e6);
            ++taken;
        } catch (const DataError&) {
        }
    }
    EXPECT_GT(taken, 10);
}

TEST(RealRecordings, AllTwentySevenLoadAndPlay) {
    const char* data = std::getenv("STYLET_DATA");
    if (!data) GTEST_SKIP() << "STYLET_DATA is not set: no recorded breaths";
    int files = 0, ended_in_zeros = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(data) / "breathing")) {
        if (entry.path().extension() != ".csv") continue;
        const std::string name = entry.path().filename().string();
        SCOPED_TRACE(name);
        const RecordedBreath r = loadRecordedBreath(entry.path());
        ++files;
        ended_in_zeros += r.zero_rows;
        EXPECT_LE(r.misdated_rows, 6);
        // Names with -O-: the subject sits and breathes with a period of about twenty seconds.
        const bool slow = name.find("-O-") != std::string::npos;
        EXPECT_GE(r.breaths, slow ? 2 : 12);
        // Names with -N-: normal breathing.
        const bool calm = name.find("-N-") != std::string::npos;
        EXPECT_NEAR(r.period_s, slow ? 19.0 : 5.8, slow ? 3.0 : calm ? 1.3 : 2.0);
        if (calm && name.find("LAC") != std::string::npos) {
            EXPECT_NEAR(r.travel_m, 0.0175, 0.0075);
        }
        BreathPlan plan;
        plan.recording_v = r.v;
        plan.recording_dt_s = r.dt_s;
        BreathingState state;
        Surrogate before = surrogateAt(state, plan, 0.001);
        for (int i = 0; i < int(double(r.v.size()) * r.dt_s * 1000.0) + 2000; ++i) {
            stepBreathing(state, plan, 0.001);
            const Surrogate now = surrogateAt(state, plan, 0.001);
            ASSERT_NEAR(now.v - before.v, 0.0005 * (now.rate_per_s + before.rate_per_s), 1e-4);
            ASSERT_LT(std::fabs(now.v), 8.0);
            before = now;
        }
        EXPECT_LT(longestBreath_s(plan, 0.001), 60.0);
    }
    EXPECT_EQ(files, 27);
    EXPECT_EQ(ended_in_zeros, 15);
}

}  // namespace
}  // namespace stylet::patient
