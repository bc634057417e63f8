#include "app/trainer/session/alert.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stylet::trainer {
namespace {

using training::RiskStructure;

FrameState seenAt(double t_s) {
    FrameState seen;
    seen.tick.tick = std::uint64_t(t_s * 1000.0 + 0.5);
    return seen;
}

std::uint8_t alphaAt(const AlertPicture& picture, int x, int y) {
    return picture.rgba()[4 * std::size_t(y * AlertPicture::kSize + x) + 3];
}

TEST(AlertWatch, StrikeAlertOutlastsTheContact) {
    AlertWatch watch(0.001);
    EXPECT_FALSE(watch.update(seenAt(0.9)));
    FrameState struck = seenAt(1.0);
    struck.progress.current_risk = RiskStructure::vessel;
    EXPECT_EQ(watch.update(struck), Alert{RiskStructure::vessel});
    EXPECT_EQ(watch.update(seenAt(1.0 + 0.9 * kMinAlert_s)), Alert{RiskStructure::vessel});
    EXPECT_FALSE(watch.update(seenAt(1.0 + 1.1 * kMinAlert_s)));
}

// HZ-TEACH-17
TEST(AlertWatch, TargetAlertComesOnceAndAfterStrikes) {
    AlertWatch watch(0.001);
    FrameState reached = seenAt(2.0);
    reached.progress.success = true;
    EXPECT_EQ(watch.update(reached), Alert{});
    reached.tick.tick += 10, reached.progress.current_risk = RiskStructure::lung;
    EXPECT_EQ(watch.update(reached), Alert{RiskStructure::lung});
    reached.progress.current_risk = RiskStructure::nothing;
    reached.tick.tick = std::uint64_t(1000 * (2.0 + kReached_s));
    EXPECT_FALSE(watch.update(reached));
}

// The red room light fades in and out, no matter how often the needle strikes something. A change takes at
// least a third of a second, so there are at most three flashes per second.
// HZ-USER-01
TEST(GlowWatch, TheRoomNeverFlashes) {
    constexpr double kTick_s = 0.001;
    GlowWatch watch(kTick_s);
    training::Progress progress;
    double most = 0.0, before = 0.0;
    int turns = 0;
    bool rises = false;
    for (std::uint64_t tick = 0; tick < 20'000; ++tick) {
        // A trembling needle strikes repeatedly.
        progress.current_risk = tick % 700 < 3 ? RiskStructure::vessel : RiskStructure::nothing;
        watch.update(tick, progress);
        const double now = double(watch.now().struck);
        most = std::max(most, std::fabs(now - before));
        if (now != before && (now > before) != rises) rises = now > before, ++turns;
        before = now;
    }
    EXPECT_LE(most, kTick_s / 0.3);
    EXPECT_GT(turns, 10) << "it did tremble";
    EXPECT_LE(turns, 2 * 3 * 20) << "three flashes a second are too many";
}

TEST(GlowWatch, IsRedForAStrikeAndGreenAtTheTarget) {
    GlowWatch watch(0.001);
    training::Progress progress;
    std::uint64_t tick = 0;
    const auto pass = [&](double s) {
        for (int i = 0; i < int(1000 * s); ++i)
            watch.update(++tick, progress);
        return shellLight(watch.now());
    };
    EXPECT_EQ(pass(0.5), Vec3(1.0));
    progress.current_risk = RiskStructure::bone;
    const Vec3 red = pass(1.0);
    EXPECT_GT(red.x, 2.0 * red.y);
    EXPECT_GT(red.x, 2.0 * red.z);
    progress.current_risk = RiskStructure::nothing;
    EXPECT_EQ(pass(2.0), Vec3(1.0));
    progress.success = true;
    const Vec3 green = pass(1.0);
    EXPECT_GT(green.y, 1.5 * green.x);
    EXPECT_GT(green.y, 1.5 * green.z);
    EXPECT_EQ(pass(5.0), Vec3(1.0));
}

TEST(AlertPicture, CoversOnlyTheBorder) {
    AlertPicture picture;
    picture.show({RiskStructure::vessel});
    const int middle = AlertPicture::kSize / 2, edge = 3;
    for (const int offset : {-120, -60, 0, 60, 120}) {
        EXPECT_EQ(alphaAt(picture, middle + offset, middle), 0);
        EXPECT_EQ(alphaAt(picture, middle, middle + offset), 0);
        EXPECT_GT(alphaAt(picture, edge, middle + offset), 120);
        EXPECT_GT(alphaAt(picture, middle + offset, edge), 120);
    }
}

// The plate behind the word is more opaque than the border around it.
TEST(AlertPicture, EveryWordFits) {
    constexpr int kPlateRow = 480, kEdge = 8, kPlate = 240;
    for (int risk = 0; risk < training::kRiskStructureCount; ++risk) {
        AlertPicture picture;
        picture.show({RiskStructure(risk)});
        EXPECT_GT(alphaAt(picture, AlertPicture::kSize / 2, kPlateRow), kPlate) << risk;
        for (const int x : {kEdge, AlertPicture::kSize - 1 - kEdge})
            EXPECT_LT(alphaAt(picture, x, kPlateRow), kPlate) << risk;
    }
}

// Counts the changes between light and dark along a column of the border's pattern.
int changesDown(const AlertPicture& picture) {
    constexpr int kColumn = 13;
    const auto bright = [&](int y) {
        const std::size_t at = 4 * std::size_t(y * AlertPicture::kSize + kColumn);
        return int(picture.rgba()[at]) + picture.rgba()[at + 1] + picture.rgba()[at + 2];
    };
    int low = 1000, high = 0, changes = 0;
    for (int y = 0; y < AlertPicture::kSize; ++y)
        low = std::min(low, bright(y)), high = std::max(high, bright(y));
    for (int y = 1; y < AlertPicture::kSize; ++y)
        changes += (2 * bright(y) > low + high) != (2 * bright(y - 1) > low + high);
    return changes;
}

// Stripes and dots distinguish the alerts for users who cannot see the colours.
TEST(AlertPicture, PatternsDifferWithoutTheirColours) {
    AlertPicture struck, reached;
    struck.show({RiskStructure::bone});
    reached.show({});
    EXPECT_NEAR(changesDown(struck), 2 * AlertPicture::kSize / 36, 2);
    EXPECT_NEAR(changesDown(reached), 2 * AlertPicture::kSize / 26, 2);
}

// A strike shorter than a frame is still shown and named.
// HZ-TEACH-17
TEST(AlertWatch, StrikeBetweenTwoFramesIsReported) {
    AlertWatch watch(0.001);
    EXPECT_FALSE(watch.update(seenAt(0.9)));
    FrameState passed = seenAt(1.0);
    passed.progress.risk_hits = 1;
    passed.progress.last_risk = RiskStructure::lung;
    EXPECT_EQ(watch.update(passed), Alert{RiskStructure::lung});
}

TEST(AlertPicture, RedrawsOnlyWhenTheAlertChanges) {
    AlertPicture picture;
    for (int i = 0; i < 5; ++i)
        picture.show({RiskStructure::vessel});
    EXPECT_EQ(picture.revision(), 1u);
    picture.show({RiskStructure::bone});
    EXPECT_EQ(picture.revision(), 2u);
}

}  // namespace
}  // namespace stylet::trainer
