#include "app/trainer/guide_panel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/notice.h"
#include "app/trainer/staging.h"

namespace stylet::trainer {
namespace {

using patient::Vec3;
using training::Difficulty;

Seen at(double t_s, double force_n = 0.5) {
    Seen seen;
    seen.tick.tick = std::uint64_t(t_s * 1000.0 + 0.5);
    seen.tick.force_n = force_n;
    return seen;
}

TEST(GuidePanel, IsDrawnTenTimesASecondWhileSomebodyLooks) {
    GuidePanel panel(Difficulty::guided, 0.001);
    for (double t_s = 0.0; t_s < 2.0; t_s += 0.011)
        panel.take(at(t_s), true);
    EXPECT_LE(panel.revision(), 20u);
    EXPECT_GE(panel.revision(), 17u);
    const std::uint64_t before = panel.revision();
    for (double t_s = 2.0; t_s < 4.0; t_s += 0.011)
        panel.take(at(t_s), false);
    EXPECT_EQ(panel.revision(), before) << "nobody looked";
}

TEST(GuidePanel, ShowsWhatWasFeltWhileNobodyLooked) {
    GuidePanel felt(Difficulty::guided, 0.001), flat(Difficulty::guided, 0.001);
    for (double t_s = 0.0; t_s < 5.0; t_s += 0.05) {
        felt.take(at(t_s, 1.0 + std::sin(t_s)), false);
        flat.take(at(t_s), false);
    }
    felt.take(at(5.1), true), flat.take(at(5.1), true);
    EXPECT_NE(felt.rgba(), flat.rgba());
}

TEST(GuidePanel, OnlyTheGuidedAreToldWhatToDo) {
    GuidePanel guided(Difficulty::guided, 0.001), practice(Difficulty::practice, 0.001);
    guided.take(at(0.1), true), practice.take(at(0.1), true);
    EXPECT_NE(guided.rgba(), practice.rgba());
}

TEST(GuidePanel, EveryStepHasItsOwnHint) {
    for (int a = 0; a <= training::kStepCount; ++a)
        for (int b = 0; b < a; ++b)
            EXPECT_NE(hintOf(training::Step(a)), hintOf(training::Step(b)));
}

constexpr Vec3 kEntry{0.0, 1.05, -0.45}, kEyes{0.05, 1.5, -0.1};

TEST(GuidePlace, LettersAreLargeEnough) {
    for (const double px_per_rad : {900.0, 1200.0, 2000.0}) {
        const double letter_rad = letterAngle_rad(px_per_rad);
        const PanelPlace place = guidePlace(kEntry, kEyes, letter_rad);
        const double em_m = place.width_m * GuidePanel::kLetter_px / GuidePanel::kWidth;
        const double seen_rad = std::atan(em_m / glm::length(place.stage_from_panel.position_m - kEyes));
        EXPECT_GE(seen_rad, 0.98 * kLeastText_rad);
        EXPECT_GE(seen_rad * px_per_rad, 0.98 * kLeastText_px);
    }
}

TEST(GuidePlace, StaysInTheRoomHoweverFewThePixels) {
    for (const double px_per_rad : {100.0, 256.0, 320.0}) {
        const PanelPlace place = guidePlace(kEntry, kEyes, letterAngle_rad(px_per_rad));
        EXPECT_LE(place.width_m, 1.2);
        EXPECT_TRUE(inView(place, stageFromEyes(kEyes, kEntry)));
    }
}

TEST(GuidePlace, NeverHidesWhereThePunctureIs) {
    const PanelPlace place = guidePlace(kEntry, kEyes, kLeastText_rad);
    for (double x = -0.5; x <= 0.5; x += 0.1)
        for (double y = 1.2; y <= 1.9; y += 0.1)
            for (double z = -0.4; z <= 0.5; z += 0.1)
                EXPECT_FALSE(covers(place, {x, y, z}, kEntry)) << "who stands at his side of the table";
    // Behind the panel, it would.
    const Vec3 middle = place.stage_from_panel.position_m;
    EXPECT_TRUE(covers(place, middle + 0.5 * (middle - kEntry), kEntry));
}

TEST(GuidePlace, IsSeenFromTheFrontOnly) {
    const PanelPlace place = guidePlace(kEntry, kEyes, kLeastText_rad);
    const Vec3 middle = place.stage_from_panel.position_m;
    EXPECT_TRUE(inView(place, stageFromEyes(kEyes, middle)));
    EXPECT_FALSE(inView(place, stageFromEyes(kEyes, kEyes + (kEyes - middle)))) << "turned away";
    EXPECT_FALSE(inView(place, stageFromEyes(middle + (middle - kEyes), middle))) << "from behind";
}

}  // namespace
}  // namespace stylet::trainer
