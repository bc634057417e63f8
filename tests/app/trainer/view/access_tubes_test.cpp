#include "app/trainer/view/access_tubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace stylet::trainer {
namespace {

using haptics::DrainState;
using haptics::Tool;

// A straight path along -x: 50 mm of track, 40 mm of wire in the duct.
haptics::TickOutput makeTick() {
    haptics::TickOutput tick;
    haptics::AccessOutput& access = tick.access;
    access.open = access.wire_in = true;
    access.base_m = {-0.050, 0.0, 0.0};
    access.wire_m = 0.040;
    access.node_count = 20;
    for (int i = 0; i < 20; ++i)
        access.nodes_m[std::size_t(i)] = {-0.090f + 0.002f * float(i), 0.0f, 0.0f};
    access.path_count = 3;
    access.path_m[1] = {-0.050f, 0.0f, 0.0f}, access.path_m[2] = {-0.090f, 0.0f, 0.0f};
    return tick;
}
double highest(const CurvedTube& tube, int axis) {
    double most_m = -1.0;
    for (const Vec3& p : tube.points_m)
        most_m = std::max(most_m, std::fabs(p[axis]));
    return most_m;
}

TEST(AccessTubes, NothingIsShownBeforeTheFirstWire) {
    EXPECT_TRUE(accessTubes({}, {}, {}, 0.15).empty());
}

TEST(AccessTubes, TheWireReachesFromOutsideTheHubToItsTip) {
    haptics::TickOutput tick = makeTick();
    tick.access.needle_in = true;
    const std::vector<CurvedTube> tubes = accessTubes(tick, {}, {}, 0.15);
    ASSERT_EQ(tubes.size(), 1u);
    EXPECT_EQ(tubes[0].points_m.size(), 2u) << "straight";
    EXPECT_GT(tubes[0].points_m.front().x, 0.100) << "beyond the hub";
    EXPECT_NEAR(tubes[0].points_m.back().x, -0.090, 1e-6);
    EXPECT_EQ(tubes[0].radius_m, haptics::WireSettings().radius_m());
    tick.access.wire_m = -0.010, tick.access.node_count = 0;
    EXPECT_NEAR(accessTubes(tick, {}, {}, 0.15)[0].points_m.back().x, -0.040, 1e-6);
}

TEST(AccessTubes, ThePigtailCurlsOnceTheDrainIsInPlace) {
    haptics::TickOutput tick = makeTick();
    tick.access.drain = DrainState::over_wire;
    tick.access.drain_m = 0.085;
    std::vector<CurvedTube> tubes = accessTubes(tick, {}, {}, 0.15);
    ASSERT_EQ(tubes.size(), 2u);
    EXPECT_NEAR(tubes[1].points_m.back().x, -0.085, 1e-6);
    EXPECT_LT(highest(tubes[1], 2), 1e-6);
    tick.access.drain = DrainState::in_place;
    tick.access.wire_in = tick.access.open = false;
    tubes = accessTubes(tick, {}, {}, 0.15);
    ASSERT_EQ(tubes.size(), 1u);
    const haptics::TubeSettings drain = haptics::AccessSettings().drain;
    EXPECT_NEAR(highest(tubes[0], 2), drain.pigtail_m, 0.0005) << "the loop lies in the coronal plane";
    EXPECT_LT(highest(tubes[0], 1), 1e-6);
    EXPECT_EQ(tubes[0].attenuation_per_m, drain.attenuation_per_m);
}

TEST(AccessTubes, TheTipOfTheToolInHandLiesAtTheTubesEnd) {
    haptics::TickOutput tick = makeTick();
    tick.tool = Tool::needle;
    EXPECT_FALSE(tipOnTrack_m(tick, {}));
    tick.tool = Tool::wire;
    EXPECT_NEAR(tipOnTrack_m(tick, {})->x, -0.090, 1e-6);
    tick.tool = Tool::drain;
    EXPECT_FALSE(tipOnTrack_m(tick, {})) << "still outside";
    tick.access.drain_m = 0.060;
    EXPECT_NEAR(tipOnTrack_m(tick, {})->x, -0.060, 1e-6);
    tick.tool = Tool::dilator;
    tick.access.dilator_m = 0.020;
    EXPECT_NEAR(tipOnTrack_m(tick, {})->x, -0.020, 1e-6);
}

TEST(AccessTubes, SimplifiedCurvesKeepToTheirTolerance) {
    std::vector<Vec3> arc;
    for (int i = 0; i <= 100; ++i)
        arc.emplace_back(0.02 * std::cos(0.03 * i), 0.02 * std::sin(0.03 * i), 0.0);
    const std::vector<Vec3> kept = simplifyCurve(arc, 0.0002);
    EXPECT_LT(kept.size(), 30u);
    EXPECT_EQ(kept.front(), arc.front());
    EXPECT_EQ(kept.back(), arc.back());
    for (std::size_t i = 1; i < kept.size(); ++i)
        EXPECT_GT(glm::length(0.5 * (kept[i] + kept[i - 1])), 0.02 - 0.0003);
}

}  // namespace
}  // namespace stylet::trainer
