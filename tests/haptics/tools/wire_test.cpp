#include "haptics/tools/wire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <utility>

namespace stylet::haptics {
namespace {

using patient::DuctSpace;

constexpr double kFeedStep_m = 0.00002;  // 20 mm/s

// A lumen from a signed distance, on a grid of 1 mm around the origin.
template <typename Level>
DuctSpace makeDucts(const Level& level) {
    const Grid grid{{180, 125, 40}, Vec3(0.001), {-0.040, -0.040, -0.020}};
    DuctSpace ducts;
    ducts.level_m = Volume<float>(grid);
    forEachVoxel(grid, [&](const Index3& i) { ducts.level_m[i] = float(level(grid.centre(i))); });
    return ducts;
}
constexpr double kDuctRadius_m = 0.0025;

DuctSpace straightDuct() {
    return makeDucts([](const Vec3& p) { return std::hypot(p.y, p.z) - kDuctRadius_m; });
}
// A ring in the plane z = 0 through the origin, tangential to +x there.
DuctSpace curvedDuct(double bend_m) {
    return makeDucts([bend_m](const Vec3& p) {
        return std::hypot(std::hypot(p.x, p.y - bend_m) - bend_m, p.z) - kDuctRadius_m;
    });
}
// A duct along x that ends `end_m` behind the origin.
DuctSpace closedDuct(double end_m) {
    return makeDucts(
        [end_m](const Vec3& p) { return std::max(std::hypot(p.y, p.z) - kDuctRadius_m, p.x - end_m); });
}

struct WireBench {
    explicit WireBench(DuctSpace space) : ducts(std::move(space)) {}

    DuctSpace ducts;
    WireBase base{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
    WireSettings settings;
    WireState wire;
    double force_n = 0.0, peak_n = 0.0;

    void push(double travel_m, double step_m = kFeedStep_m) {
        const auto ticks = std::lround(std::fabs(travel_m) / step_m);
        for (long i = 0; i < ticks; ++i) {
            force_n = stepWire(wire, settings, ducts, base, std::copysign(step_m, travel_m));
            peak_n = std::max(peak_n, force_n);
        }
    }
    Vec3 tip() const { return wireTip(wire, base); }
    double highestLevel_m() const {
        double highest_m = -1.0;
        for (int i = 0; i < wire.count; ++i)
            highest_m = std::max(highest_m, patient::ductWallAt(ducts, wire.nodes_m[std::size_t(i)]).level_m);
        return highest_m;
    }
};

TEST(Wire, FeedingMovesTheTipOfAFreeWireByTheSameLength) {
    WireBench b{straightDuct()};
    b.push(0.020);
    for (int i = 0; i < 5; ++i) {
        const double before_m = b.tip().x, fed_m = b.wire.fed_m;
        b.push(0.020);
        EXPECT_NEAR(b.tip().x - before_m, b.wire.fed_m - fed_m, 1e-6);
        EXPECT_GT(b.wire.fed_m - fed_m, 0.0198);
    }
    EXPECT_TRUE(b.wire.in_lumen);
    EXPECT_FALSE(b.wire.buckled);
}

TEST(Wire, FrictionIsProportionalToTheLengthInAStraightDuct) {
    WireBench b{straightDuct()};
    for (const double length_m : {0.03, 0.06, 0.09, 0.12}) {
        b.push(length_m - b.wire.fed_m);
        EXPECT_NEAR(b.force_n, b.settings.bore_friction_n + b.settings.drag_n_per_m * b.wire.fed_m, 1e-3);
    }
    EXPECT_NEAR(b.wire.turn_rad, 0.0, 1e-6);
}

// The capstan equation, and the force for moving the shaft's stiffness into a bend: E I / 2 R^2.
TEST(Wire, ACurvedDuctBendsTheWire) {
    for (const double bend_m : {0.030, 0.050}) {
        WireBench b(curvedDuct(bend_m));
        b.push(0.080);
        EXPECT_GT(b.wire.fed_m, 0.078);
        EXPECT_LE(b.highestLevel_m(), -0.5 * b.settings.radius_m());
        // The wire lies somewhere between the inner and the outer wall.
        EXPECT_NEAR(b.wire.turn_rad, b.wire.fed_m / bend_m, 0.25 * b.wire.fed_m / bend_m);
        const double bend_n = 0.5 * b.settings.shaft_stiffness_n_m2 / (bend_m * bend_m);
        EXPECT_NEAR(b.wire.bend_n, bend_n, 0.4 * bend_n);
        EXPECT_NEAR(b.force_n, wireFriction_n(b.settings, b.wire.fed_m, b.wire.turn_rad) + b.wire.bend_n,
                    0.02);
    }
}

// The tip meets the end of the duct. Euler's load of the column is the most that the hand feels beyond the
// friction.
TEST(Wire, ABlockedWireBucklesAtEulersLoad) {
    for (const double end_m : {0.012, 0.025, 0.060}) {
        WireBench b(closedDuct(end_m));
        b.push(end_m + 0.030);
        EXPECT_TRUE(b.wire.buckled) << end_m;
        EXPECT_LT(b.tip().x, end_m);
        const double column_m = std::min(b.wire.fed_m, b.settings.tip_length_m);
        const double euler_n =
            3.14159265 * 3.14159265 * b.settings.tip_stiffness_n_m2 / (0.7 * 0.7 * column_m * column_m);
        const double friction_n = wireFriction_n(b.settings, b.wire.fed_m, b.wire.turn_rad) + b.wire.bend_n;
        EXPECT_NEAR(b.force_n, friction_n + euler_n, 1e-3 * euler_n + 1e-6) << end_m;
        EXPECT_LE(b.highestLevel_m(), 0.0);
    }
}

// A short column carries the force that pierces the wall; a long one does not.
TEST(Wire, OnlyAShortColumnPiercesTheWall) {
    WireBench near(closedDuct(0.004)), far(closedDuct(0.030));
    near.push(0.030);
    far.push(0.060);
    EXPECT_GE(near.wire.fed_m, near.wire.pierced_m);
    EXPECT_GT(near.tip().x, 0.004);
    EXPECT_GT(near.peak_n, near.settings.blunt_n);
    EXPECT_LT(far.wire.fed_m, far.wire.pierced_m);
    EXPECT_LT(far.peak_n, near.settings.blunt_n);
}

// In solid tissue the wire advances until Euler's load is below the force of its blunt tip.
TEST(Wire, HardlyAdvancesInParenchyma) {
    WireBench b(DuctSpace{});
    b.push(0.060);
    const double furthest_m =
        3.14159265 / 0.7 * std::sqrt(b.settings.tip_stiffness_n_m2 / b.settings.blunt_n);
    EXPECT_NEAR(b.wire.fed_m, furthest_m, 0.0005);
    EXPECT_GT(b.peak_n, b.settings.blunt_n);
    EXPECT_TRUE(b.wire.buckled);
    EXPECT_FALSE(b.wire.in_lumen);
}

// A needle just short of a duct: the wire pushes through the wall into the lumen and then down the duct.
TEST(Wire, EntersTheLumenThroughAThinWall) {
    WireBench b{straightDuct()};
    b.base.at_m = {0.0, -kDuctRadius_m - 0.0008, 0.0};
    b.base.axis = glm::normalize(Vec3(1.0, 0.7, 0.0));
    b.push(0.060);
    EXPECT_TRUE(b.wire.in_lumen);
    EXPECT_GT(b.wire.solid_m, 0.0008);
    EXPECT_GT(b.tip().x, 0.040);
}

double fedAtAngle(double degrees) {
    WireBench b{straightDuct()};
    const double rad = degrees * 0.017453292519943295;
    b.base.axis = {std::cos(rad), std::sin(rad), 0.0};
    b.push(0.080);
    EXPECT_LE(b.highestLevel_m(), b.wire.fed_m < b.wire.pierced_m ? 0.0 : 1.0) << degrees;
    return b.tip().x;
}

TEST(Wire, GoesDownTheDuctAtAnAngleAndNotHeadOn) {
    EXPECT_GT(fedAtAngle(20.0), 0.070);
    EXPECT_GT(fedAtAngle(45.0), 0.065);
    EXPECT_LT(fedAtAngle(88.0), 0.010);
}

TEST(Wire, ReversedMotionReturnsTheWire) {
    WireBench b(curvedDuct(0.040));
    b.push(0.080);
    b.push(-0.090);
    EXPECT_LT(b.wire.fed_m, 0.0);
    EXPECT_EQ(b.wire.count, 0);
    EXPECT_FALSE(b.wire.in_lumen);
    EXPECT_NEAR(b.force_n, -b.settings.bore_friction_n, 1e-3);
    b.push(0.090);
    EXPECT_GT(b.wire.fed_m, 0.077);
    EXPECT_LE(b.highestLevel_m(), 0.0);
}

// The hand never receives more than it has put in, whatever it does.
TEST(Wire, IsPassiveUnderRandomMotion) {
    std::mt19937 random(7);
    const std::array<DuctSpace, 3> lumens{curvedDuct(0.030), closedDuct(0.015), DuctSpace{}};
    for (const DuctSpace& ducts : lumens) {
        WireBench b(ducts);
        double work_j = 0.0, drift = 0.00005;
        for (int i = 0; i < 20000; ++i) {
            if (i % 500 == 0) drift = 0.00002 * (int(random() % 11) - 4);
            const double moved_m = drift + 1e-6 * (int(random() % 201) - 100);
            const double before_n = b.force_n;
            b.force_n = stepWire(b.wire, b.settings, b.ducts, b.base, moved_m);
            // The force between two ticks lies between both of them, up to the spring's own step.
            work_j += std::max(before_n, b.force_n) * moved_m * (moved_m > 0.0) +
                      std::min(before_n, b.force_n) * moved_m * (moved_m < 0.0);
            const double energy_j = wireEnergy_j(b.wire, b.settings);
            ASSERT_GE(energy_j, 0.0);
            ASSERT_GE(work_j + 1e-9, energy_j) << i;
            ASSERT_LE(b.highestLevel_m(), b.wire.fed_m < b.wire.pierced_m && b.wire.in_lumen ? 0.0 : 1.0);
        }
    }
}

TEST(Wire, IgnoresWhatIsNotANumber) {
    WireBench b{straightDuct()};
    b.push(0.010);
    const WireState before = b.wire;
    b.force_n = stepWire(b.wire, b.settings, b.ducts, b.base, std::nan(""));
    EXPECT_EQ(b.wire.fed_m, before.fed_m);
    EXPECT_EQ(b.wire.extension_m, before.extension_m);
    EXPECT_TRUE(std::isfinite(b.force_n));
    stepWire(b.wire, b.settings, b.ducts, b.base, 1e300);
    EXPECT_LT(b.wire.fed_m, before.fed_m + 0.001);
    EXPECT_LT(wireEnergy_j(b.wire, b.settings), 0.1);
}

TEST(Wire, EqualInputGivesAnEqualHash) {
    const auto run = [] {
        WireBench b(curvedDuct(0.030));
        b.push(0.070), b.push(-0.020), b.push(0.010);
        StateHash hash;
        hashWire(hash, b.wire);
        return hash.value();
    };
    EXPECT_EQ(run(), run());
}

TEST(Wire, EndsAtItsLength) {
    WireBench b(makeDucts([](const Vec3&) { return -0.010; }));
    b.push(0.300, 0.0002);
    EXPECT_LE(b.wire.fed_m, kMaxWire_m);
    EXPECT_LE(b.wire.count, kMaxWireNodes);
}

}  // namespace
}  // namespace stylet::haptics
