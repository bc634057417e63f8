#include "patient/planning/planning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <optional>

#include "base/smoothstep.h"
#include "base/traversal.h"
#include "tests/support/constants.h"
#include "tests/support/file_text.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

using test::kMm;

constexpr std::uint8_t kUnlabelled = 0;

void expectSoundPlan(const PlanResult& r, const PlanSettings& settings) {
    EXPECT_GE(r.candidates, r.rejected_blocked + r.rejected_long + r.rejected_quality + r.paths.size());
    for (std::size_t i = 0; i < r.paths.size(); ++i) {
        const PlannedPath& p = r.paths[i];
        EXPECT_NEAR(p.length_m, glm::length(p.target_m - p.entry_m), 1e-12);
        EXPECT_LE(p.length_m, settings.max_length_m);
        EXPECT_GE(p.quality, settings.min_quality);
        EXPECT_DOUBLE_EQ(p.quality, 0.5 * (p.clearance_score + p.target_score));
        EXPECT_LE(p.quality, r.paths[i > 0 ? i - 1 : 0].quality);
    }
}

// A torso shaped like a box, with 2 mm voxels. The skin of the right side is the plane x = 0. Air is in
// front of it (x > 0), and in front of and behind the body (|y| > 60 mm). The liver contains a spherical
// duct of 6 mm radius, with its centre 51 mm below the skin.
class BoxTorso {
  public:
    BoxTorso() : package_(test::makeSlabs({{Tissue::soft, 0.002}}, 0.002)) {
        Grid grid;
        grid.dims = {70, 71, 61};
        grid.spacing_m = Vec3(2 * kMm);
        grid.origin_m = Vec3(-99 * kMm, -70 * kMm, -60 * kMm);
        package_.ct = CtVolume(grid, -1000);
        package_.labels = LabelVolume(grid);
        paint(Tissue::soft, {-200, -60, -200}, {0, 60, 200});
        paint(Tissue::liver, {-80, -40, -30}, {-20, 40, 30});
        addDuct();
    }
    // Fills a box, in millimetres, whose borders lie between voxels.
    void paint(Tissue tissue, const Vec3& low_mm, const Vec3& high_mm) {
        fill(low_mm, high_mm, std::uint8_t(tissue), 40);
    }
    void addAir(const Vec3& low_mm, const Vec3& high_mm) { fill(low_mm, high_mm, kUnlabelled, -1000); }
    // Adds a plate of ribs 10 mm below the skin, open between z_low and z_high.
    void addRibs(double z_low_mm, double z_high_mm) {
        paint(Tissue::bone, {-14, -59, z_high_mm}, {-10, 59, 200});
        paint(Tissue::bone, {-14, -59, -200}, {-10, 59, z_low_mm});
    }
    void addDuct() {
        where([](const Vec3& mm) { return glm::length(mm - Vec3(-51, 0, 0)) < 6.5; },
              std::uint8_t(Tissue::duct), 10);
    }
    // Plans with and without skipping pairs and checks that the results are equal.
    PlanResult plan(PlanSettings settings) const {
        const Patient patient(package_);
        const PlanResult skipped = planPaths(patient, settings);
        settings.skip = false;
        const PlanResult all = planPaths(patient, settings);
        EXPECT_EQ(all.skipped, 0u);
        EXPECT_TRUE(skipped.paths == all.paths);
        expectSoundPlan(all, settings);
        return all;
    }
    PlanResult plan() const { return plan(fine()); }
    static PlanSettings fine() {
        PlanSettings settings;
        settings.skin_spacing_m = 2 * kMm;
        return settings;
    }
    Package& package() { return package_; }
    const Package& package() const { return package_; }

  private:
    void fill(const Vec3& low_mm, const Vec3& high_mm, std::uint8_t id, int ct_hu) {
        const auto inside = [&](const Vec3& mm) {
            return glm::all(glm::greaterThan(mm, low_mm)) && glm::all(glm::lessThan(mm, high_mm));
        };
        where(inside, id, ct_hu);
    }
    void where(const std::function<bool(const Vec3&)>& inside, std::uint8_t id, int ct_hu) {
        const Grid& grid = package_.ct.grid;
        forEachVoxel(grid, [&](const Index3& i) {
            if (!inside(grid.centre(i) / kMm)) return;
            package_.labels[i] = id;
            package_.ct[i] = std::int16_t(ct_hu);
        });
    }
    Package package_;
};

TEST(Planning, ChoosesTheShortestPerfectPath) {
    const BoxTorso torso;
    const PlanResult r = torso.plan();
    ASSERT_FALSE(r.paths.empty());
    const PlannedPath& best = r.paths.front();
    EXPECT_EQ(best.quality, 1.0);
    EXPECT_NEAR(best.length_m, 50 * kMm, 1e-9);  // straight in from the first skin voxel's centre
    EXPECT_LT(glm::length(best.entry_m - Vec3(-1, 0, 0) * kMm), 1e-9);
    EXPECT_LT(glm::length(best.target_m - Vec3(-51, 0, 0) * kMm), 1e-9);
    EXPECT_EQ(best.entry_m, best.entry_reference_m);
}

TEST(Planning, EntriesLieBetweenTheAxillaryLinesAtTheLiversHeight) {
    const PlanResult r = BoxTorso().plan();
    double y_most_mm = 0.0, z_most_mm = 0.0;
    for (const PlannedPath& p : r.paths) {
        EXPECT_NEAR(p.entry_m.x, -1 * kMm, 1e-9);
        y_most_mm = std::max(y_most_mm, std::abs(p.entry_m.y / kMm));
        z_most_mm = std::max(z_most_mm, std::abs(p.entry_m.z / kMm));
    }
    EXPECT_NEAR(y_most_mm, 30.0, 2.5);  // half of the distance from the body's middle to its front
    EXPECT_NEAR(z_most_mm, 29.0, 2.0);
}

// Two ribs 18 mm apart. The distance to the upper one counts half, so the best height z solves (9 - z) / 2 =
// z + 9: z = -3 mm, with 6 mm on both sides.
TEST(Planning, PassesBetweenRibsNearerToTheLowerOne) {
    BoxTorso torso;
    torso.addRibs(-9, 9);
    const PlanResult r = torso.plan();
    ASSERT_FALSE(r.paths.empty());
    EXPECT_NEAR(r.paths.front().clearance_score, 0.6, 0.05);
    EXPECT_EQ(r.paths.front().target_score, 1.0);
    EXPECT_NEAR(r.paths.front().entry_m.z / kMm, -3.0 * 50 / 38, 2.0);  // within one voxel
    EXPECT_GT(r.rejected_blocked, r.candidates / 3);
}

// A single block of bone at the flank is not a rib cage, so no path leads between ribs.
TEST(Planning, AccessIsOnlyBetweenRibs) {
    BoxTorso torso;
    torso.paint(Tissue::bone, {-14, -59, 9}, {-10, 59, 21});
    EXPECT_TRUE(torso.plan().paths.empty());
    torso.paint(Tissue::bone, {-14, -59, -21}, {-10, 59, -9});
    const PlanResult r = torso.plan();
    ASSERT_FALSE(r.paths.empty());
    for (const PlannedPath& path : r.paths)
        EXPECT_LT(std::abs(path.entry_m.z / kMm), 12.0);
}

TEST(Planning, RibsWithoutAGapBlockEverything) {
    BoxTorso torso;
    torso.addRibs(1, 1);
    const PlanResult r = torso.plan();
    EXPECT_GT(r.candidates, 500u);
    EXPECT_EQ(r.rejected_blocked, r.candidates);
}

TEST(Planning, RejectsPathsAboveTheMaximumLength) {
    PlanSettings settings = BoxTorso::fine();
    settings.max_length_m = 0.0499;
    const PlanResult r = BoxTorso().plan(settings);
    EXPECT_GT(r.candidates, 500u);
    EXPECT_EQ(r.rejected_long, r.candidates);
    settings.max_length_m = 0.05001;
    EXPECT_EQ(BoxTorso().plan(settings).paths.size(), 1u);
}

// 190 mm outside the skin the hand must be 30 mm above the back, which lies at y = -60 mm.
TEST(Planning, HandStaysAboveTheTable) {
    const PlanResult r = BoxTorso().plan();
    double lowest_mm = 1000.0;
    for (const PlannedPath& p : r.paths)
        lowest_mm =
            std::min(lowest_mm, (p.entry_m.y - 0.190 * (p.target_m.y - p.entry_m.y) / p.length_m) / kMm);
    EXPECT_GT(lowest_mm, -30.0);
    EXPECT_LT(lowest_mm, -20.0);
}

TEST(Planning, AirInTheBodyIsARisk) {
    BoxTorso torso;
    torso.addAir({-18, -55, -60}, {-14, -3, 60});  // unsegmented lung, posterior of y = -3 mm
    const PlanResult r = torso.plan();
    ASSERT_FALSE(r.paths.empty());
    for (const PlannedPath& p : r.paths)
        EXPECT_GT(p.entry_m.y * (51 - 14) / 50 / kMm, -3.0);
    // The best entry has full clearance. It is as far from the air as the axillary lines allow.
    EXPECT_EQ(r.paths.front().clearance_score, 1.0);
    EXPECT_GT(r.paths.front().entry_m.y / kMm, 10.0);
}

// A gap of 6 mm between vessels. Beside the duct's wall it only affects C1. Farther out it also limits the
// clearance to 3 mm.
TEST(Planning, VesselsBesideTheDuctDoNotLimitClearance) {
    const auto withVessels = [](double x_low_mm, double x_high_mm) {
        BoxTorso torso;
        torso.paint(Tissue::vessel, {x_low_mm, -40, 3}, {x_high_mm, 40, 30});
        torso.paint(Tissue::vessel, {x_low_mm, -40, -30}, {x_high_mm, 40, -3});
        torso.addDuct();
        const PlanResult r = torso.plan();
        EXPECT_GT(r.rejected_blocked, r.candidates / 4);
        return r.paths.empty() ? 0.0 : r.paths.front().clearance_score;
    };
    EXPECT_GT(withVessels(-46, -42), 0.75);
    EXPECT_NEAR(withVessels(-30, -26), 0.3, 0.06);
}

// The closest that the planned paths come to a vessel from `low_mm` to `high_mm`, if its border is uncertain.
// Only parts of the paths with x > `deepest_mm` count; the duct's wall is at x = -45 mm.
double closestToVessel(double uncertainty_m, const Vec3& low_mm, const Vec3& high_mm, double deepest_mm) {
    BoxTorso torso;
    torso.paint(Tissue::vessel, low_mm, high_mm);
    torso.addDuct();
    torso.package().label_table[std::size_t(Tissue::vessel) - 1].border_uncertainty_m = uncertainty_m;
    const PlanResult r = torso.plan();
    EXPECT_FALSE(r.paths.empty());
    double closest_mm = 1e3;
    for (const PlannedPath& path : r.paths)
        for (int i = 0; i <= 1000; ++i) {
            const Vec3 mm = glm::mix(path.entry_m, path.target_m, i / 1000.0) / kMm;
            if (mm.x > deepest_mm)
                closest_mm = std::min(closest_mm, glm::length(mm - glm::clamp(mm, low_mm, high_mm)));
        }
    return closest_mm * kMm;
}

// The distance is measured from voxel to voxel, so it may be short by the half diagonal of a voxel.
TEST(Planning, PathsKeepTheUncertaintyOfABorderAsDistance) {
    constexpr double kVoxel_m = 2 * kMm;
    const auto closest = [](double uncertainty_m) {
        return closestToVessel(uncertainty_m, {-26, -40, -30}, {-22, 40, -2}, -34);
    };
    EXPECT_LT(closest(0.0), kVoxel_m);
    for (const double uncertainty_m : {3 * kMm, 5 * kMm}) {
        EXPECT_GT(closest(uncertainty_m), uncertainty_m - kVoxel_m);
        EXPECT_LT(closest(uncertainty_m), uncertainty_m + 2.0 * kVoxel_m);
    }
}

// On the last 10 mm before the duct's wall, 2 mm at most.
TEST(Planning, UncertaintyBesideTheDuctIsLimited) {
    const auto closest = [](double uncertainty_m) {
        return closestToVessel(uncertainty_m, {-44, -40, -30}, {-42, 40, -2}, -45);
    };
    EXPECT_LT(closest(0.0), closest(12 * kMm));
    EXPECT_LT(closest(12 * kMm), 6 * kMm);
}

// Only risk structures and suspects have a margin: a target or the liver may be as uncertain as it is.
TEST(Planning, UncertainBordersOfOtherStructuresChangeNoPath) {
    BoxTorso torso;
    const PlanResult exact = torso.plan();
    for (Label& label : torso.package().label_table)
        if (label.role != Role::risk) label.border_uncertainty_m = 0.01;
    EXPECT_TRUE(torso.plan().paths == exact.paths);
}

// A suspect is avoided, but neither blocks a path that keeps its distance nor lowers its clearance.
TEST(Planning, PathsAvoidSuspects) {
    const auto planned = [](Role role, double uncertainty_m) {
        BoxTorso torso;
        torso.paint(Tissue::vessel, {-26, -40, -30}, {-22, 40, -2});
        torso.addDuct();
        Label& vessel = torso.package().label_table[std::size_t(Tissue::vessel) - 1];
        vessel.role = role, vessel.border_uncertainty_m = uncertainty_m;
        return torso.plan().paths;
    };
    const auto all = planned(Role::pass, 2 * kMm), kept = planned(Role::suspect, 2 * kMm),
               safe = planned(Role::risk, 2 * kMm);
    EXPECT_TRUE(planned(Role::suspect, 0.0) == all);
    ASSERT_FALSE(kept.empty());
    EXPECT_LT(kept.size(), all.size());
    for (const PlannedPath& path : kept)
        for (int i = 0; i <= 1000; ++i) {
            const Vec3 mm = glm::mix(path.entry_m, path.target_m, i / 1000.0) / kMm;
            EXPECT_FALSE(mm.x > -26 && mm.x < -22 && mm.z > -30 && mm.z < -2) << i;
        }
    const auto clearance = [](const std::vector<PlannedPath>& paths) {
        double least = 1.0;
        for (const PlannedPath& path : paths)
            least = std::min(least, path.clearance_score);
        return least;
    };
    EXPECT_EQ(clearance(kept), clearance(all));
    EXPECT_LT(clearance(safe), clearance(kept));
}

TEST(Planning, ChordOfTheDuctIsTheTargetScore) {
    BoxTorso torso;
    torso.paint(Tissue::liver, {-60, -10, -10}, {-40, 10, 10});
    torso.paint(Tissue::duct, {-54, -38, -2.5}, {-48, 38, 2.5});  // a bar along y, 6 mm wide
    PlanSettings settings = BoxTorso::fine();
    settings.min_quality = 0.0;
    const PlanResult r = torso.plan(settings);
    bool straight_seen = false;
    for (const PlannedPath& p : r.paths) {
        const Vec3 d = (p.target_m - p.entry_m) / p.length_m;
        if (std::abs(d.z) > 1e-9 || std::abs(p.target_m.y) > 30 * kMm) continue;
        EXPECT_NEAR(p.target_score, std::min(1.0, 0.006 / std::abs(d.x) / 0.010), 1e-6);
        straight_seen = true;
    }
    EXPECT_TRUE(straight_seen);
}

TEST(Planning, NeedleReachesTheSkinThroughAir) {
    BoxTorso torso;
    torso.paint(Tissue::soft, {20, 11, -200}, {30, 60, 200});  // an arm beside the flank
    const PlanResult r = torso.plan();
    ASSERT_FALSE(r.paths.empty());
    for (const PlannedPath& p : r.paths) {
        const Vec3 outward = (p.entry_m - p.target_m) / p.length_m;
        const double y_at_arm_mm = (p.entry_m + outward * (0.021 / outward.x)).y / kMm;
        EXPECT_LT(y_at_arm_mm, 12.0);
    }
}

// The path from (-1, 20, 20) mm passes through voxel edges. A vessel that touches it only at an edge blocks
// it, on either side.
TEST(Planning, VesselTouchingAnEdgeOfThePathBlocks) {
    const auto startsThere = [](const PlanResult& r) {
        return std::any_of(r.paths.begin(), r.paths.end(), [](const PlannedPath& p) {
            return glm::length(p.entry_m - Vec3(-1, 20, 20) * kMm) < 1e-6;
        });
    };
    BoxTorso free, left, right;
    EXPECT_TRUE(startsThere(free.plan()));
    left.paint(Tissue::vessel, {-36, 7, 5}, {-30, 9, 7});
    right.paint(Tissue::vessel, {-36, 5, 7}, {-30, 7, 9});
    EXPECT_FALSE(startsThere(left.plan()));
    EXPECT_FALSE(startsThere(right.plan()));
}

// The torso's liver moves by `travel_m` along z; the body wall stays.
MotionModel movingLiver(double travel_m) {
    return test::makeMotion(Vec3(0.3), 0.010, [&](const Vec3& p) {
        test::MotionPoint q;
        q.slide_a1_m.z = travel_m * smoothStep(0.29, 0.2, std::fabs(p.z));
        q.level_m = (std::hypot((p.x + 0.05) / 0.035, p.y / 0.055) - 1.0) * 0.035;
        return q;
    });
}

// The liver moves down by 16 mm under ribs that stay. The usable gap is the one at the liver's new height.
TEST(Planning, RatesPathsInTheRequestedBreath) {
    BoxTorso torso;
    torso.addRibs(-25, -7);
    torso.package().motion = movingLiver(-16 * kMm);
    const MotionModel& m = torso.package().motion;
    PlanSettings settings = BoxTorso::fine();
    settings.breath = {1.0, 0.0};
    const PlanResult r = torso.plan(settings);
    ASSERT_FALSE(r.paths.empty());
    const PlannedPath& best = r.paths.front();
    EXPECT_NEAR(best.clearance_score, 0.6, 0.05);
    EXPECT_NEAR(best.entry_m.z / kMm, -16.0 - 3.0 * 50 / 38, 2.0);
    EXPECT_NEAR(best.target_m.z / kMm, -16.0, 1e-6);
    EXPECT_NEAR(best.target_reference_m.z / kMm, 0.0, 1e-6);
    EXPECT_EQ(best.entry_reference_m, best.entry_m);

    const Patient patient(torso.package());
    for (const PlannedPath& p : r.paths)
        for (double s = 0.0; s <= 1.0; s += 0.001) {
            const Vec3 q =
                referenceFromDeformed(m, settings.breath, p.entry_m + s * (p.target_m - p.entry_m));
            ASSERT_NE(patient.at(q, {true, true}).role, Role::risk);
        }
}

TEST(Planning, ExternalPathsAreRatedLikePlannedOnes) {
    BoxTorso torso;
    const PlannedPath own = torso.plan().paths.front();
    PlannedPath other;
    other.entry_m = own.entry_m, other.target_m = own.target_m;
    const Patient patient(torso.package());
    EXPECT_TRUE(ratePath(patient, BoxTorso::fine(), other));
    EXPECT_EQ(other.length_m, own.length_m);
    EXPECT_EQ(other.clearance_score, own.clearance_score);
    EXPECT_EQ(other.target_score, own.target_score);
    EXPECT_EQ(other.quality, own.quality);
    other.entry_m = own.target_m + (own.entry_m - own.target_m) * (0.095 / own.length_m);
    EXPECT_FALSE(ratePath(patient, BoxTorso::fine(), other)) << "it is too long";
    EXPECT_EQ(other.quality, 0.0);
}

// Computes C1 to C4 directly from their definitions: visits every voxel on the path and measures the distance
// to every risk voxel. Assumes that bone and vessels are labelled and that there are ribs.
class NaiveEvaluator {
  public:
    explicit NaiveEvaluator(const Patient& patient) : patient_(patient) {
        forEachVoxel(patient.grid(), [&](const Index3& i) {
            if (roleAt(i) != Role::risk) return;
            risks_.push_back(i);
            if (isBone(i) && !isBone({i.x, i.y, i.z - 1})) lower_edges_.push_back(i);
        });
    }
    // The quality, or nothing if it is below 0.4 or if C1 or C2 rejects the path.
    std::optional<double> quality(const Vec3& entry_m, const Vec3& target_m) const {
        const double length_m = glm::length(target_m - entry_m);
        if (length_m > 0.090) return std::nullopt;
        const Vec3 end_m = entry_m + (target_m - entry_m) / length_m * (length_m + 0.020);
        double wall_m = length_m, far_m = length_m;
        bool in_duct = false;
        for (VoxelWalk w(patient_.grid(), entry_m, end_m); !w.done(); w.next()) {
            const double begin_m = w.begin() * (length_m + 0.020), end = w.end() * (length_m + 0.020);
            if (begin_m < length_m && roleAt(w.voxel()) == Role::risk) return std::nullopt;
            if (end - begin_m < 1e-9) continue;
            const bool duct = patient_.at(w.voxel(), {}).tissue == Tissue::duct;
            if (duct && !in_duct) wall_m = begin_m;
            if (duct) far_m = end;
            if (!duct && end > length_m) break;
            in_duct = duct;
        }
        double clearance_m = 0.010;
        for (VoxelWalk w(patient_.grid(), entry_m, target_m); !w.done(); w.next())
            if (w.begin() * length_m < wall_m - 0.010)
                clearance_m = std::min(clearance_m, clearance(w.voxel()));
        const double quality =
            0.5 * (std::max(0.0, clearance_m / 0.010) + std::min(1.0, (far_m - wall_m) / 0.010));
        return quality < 0.4 ? std::nullopt : std::optional(quality);
    }

  private:
    Role roleAt(const Index3& i) const { return patient_.at(i, {}).role; }
    bool isBone(const Index3& i) const { return patient_.at(i, {}).tissue == Tissue::bone; }
    double clearance(const Index3& i) const {
        const Vec3 spacing_m = patient_.grid().spacing_m;
        double nearest_m = 1.0;
        for (const Index3& risk : risks_)
            nearest_m = std::min(nearest_m, glm::length(spacing_m * Vec3(risk - i)) - 0.001);
        for (const Index3& edge : lower_edges_)
            if (edge.z >= i.z)
                nearest_m = std::min(nearest_m, 0.5 * (glm::length(spacing_m * Vec3(edge - i)) - 0.001));
        return nearest_m;
    }
    const Patient& patient_;
    std::vector<Index3> risks_, lower_edges_;
};

TEST(Planning, PairsAreRatedByTheDefinition) {
    BoxTorso torso;
    torso.addRibs(-13, 13);
    torso.paint(Tissue::vessel, {-36, 7, 1}, {-28, 40, 5});
    torso.paint(Tissue::vessel, {-36, -40, -7}, {-28, -9, -3});
    PlanSettings settings;
    settings.target_spacing_m = 0.0;
    const PlanResult r = torso.plan(settings);
    ASSERT_GT(r.paths.size(), 5u);
    const Patient patient(torso.package());
    const NaiveEvaluator naive(patient);
    for (const PlannedPath& path : r.paths) {
        const std::optional<double> quality = naive.quality(path.entry_m, path.target_m);
        ASSERT_TRUE(quality);
        EXPECT_NEAR(path.quality, *quality, 1e-6);  // stored distances have single precision
    }
    int rejected = 0;
    for (int y_mm = 0; y_mm <= 28; y_mm += 4)  // entries where the hand is above the table
        for (int z_mm = -12; z_mm <= 12; z_mm += 6) {
            PlannedPath path;
            path.entry_m = Vec3(-1, y_mm, z_mm) * kMm, path.target_m = Vec3(-51, 0.7, 0.4) * kMm;
            const bool kept = ratePath(patient, settings, path);
            const std::optional<double> quality = naive.quality(path.entry_m, path.target_m);
            EXPECT_EQ(kept, quality.has_value()) << y_mm << ", " << z_mm;
            rejected += !kept;
            EXPECT_NEAR(kept ? path.quality : 0.0, quality.value_or(0.0), 1e-6);
        }
    EXPECT_GT(rejected, 4);
    EXPECT_LT(rejected, 36);
}

TEST(Planning, SkippedPairsAreCounted) {
    BoxTorso torso;
    torso.addRibs(-9, 9);
    PlanSettings settings = BoxTorso::fine();
    settings.target_spacing_m = 0.0;
    const Patient patient(torso.package());
    const PlanResult r = planPaths(patient, settings);
    EXPECT_GT(r.skipped, r.candidates / 4);
    EXPECT_LE(r.skipped + r.rejected_blocked + r.rejected_long + r.rejected_quality + r.paths.size(),
              r.candidates);
}

// The liver moves by 8 mm under ribs that stay. So the gap is in front of the duct only part of the time.
TEST(Planning, WorstQualityIsTheMinimumOverBreaths) {
    BoxTorso torso;
    torso.addRibs(-13, 13);
    torso.package().motion = movingLiver(-8 * kMm);
    PlanSettings settings = BoxTorso::fine();
    settings.skin_spacing_m = 0.006;
    const Patient patient(torso.package());
    std::vector<PlannedPath> paths = planPaths(patient, settings).paths;
    ASSERT_GT(paths.size(), 3u);
    paths.resize(4);
    const Surrogate still = torso.package().motion.reference, deep{1.0, 0.0};
    const std::vector<double> alone = worstQualities(patient, settings, paths, {still});
    const std::vector<double> worst = worstQualities(patient, settings, paths, {still, deep});
    for (std::size_t i = 0; i < paths.size(); ++i) {
        EXPECT_EQ(alone[i], paths[i].quality);
        PlannedPath moved = paths[i];
        moved.breath = deep;
        moved.target_m = deformedFromReference(torso.package().motion, deep, moved.target_reference_m);
        const double then = ratePath(patient, settings, moved) ? moved.quality : 0.0;
        EXPECT_EQ(worst[i], std::min(then, paths[i].quality));
    }
    EXPECT_LT(*std::min_element(worst.begin(), worst.end()), paths.front().quality);
}

TEST(Planning, PatientWithoutTargetHasNoPaths) {
    BoxTorso no_duct;
    no_duct.paint(Tissue::liver, {-60, -10, -10}, {-40, 10, 10});
    EXPECT_EQ(no_duct.plan().candidates, 0u);
    BoxTorso outside_liver;
    outside_liver.paint(Tissue::soft, {-80, -40, -30}, {-20, 40, 30});
    outside_liver.addDuct();
    EXPECT_EQ(outside_liver.plan().candidates, 0u);
}

TEST(Planning, IsIndependentOfThreadsAndProgressAscends) {
    BoxTorso torso;
    torso.addRibs(-9, 9);
    PlanSettings one = BoxTorso::fine(), three = one;
    one.threads = 1, three.threads = 3;
    double last = 0.0;
    const PlanResult a = planPaths(Patient(torso.package()), one, [&](double fraction) {
        EXPECT_GE(fraction, last);
        last = fraction;
    });
    EXPECT_EQ(last, 1.0);
    const PlanResult b = torso.plan(three);
    EXPECT_TRUE(a.paths == b.paths);
}

// ---- paths.json

class SavedPaths : public ::testing::Test {
  protected:
    SavedPaths() {
        paths_ = BoxTorso().plan().paths;
        paths_.resize(3);
        paths_[1].breath = {0.1, -1.0 / 3.0};
        savePaths({kDigest, kPlannerVersion, paths_}, file_);
        text_ = test::readText(file_);
    }
    void expectRefusedAs(const std::string& text, const std::string& field) {
        std::ofstream(file_) << text;
        test::expectRefused([&] { loadPaths(file_); }, "paths.json", field);
    }
    void expectRefusedWith(const std::string& from, const std::string& to, const std::string& field) {
        const std::size_t at = text_.find(from);
        ASSERT_NE(at, std::string::npos);
        expectRefusedAs(std::string(text_).replace(at, from.size(), to), field);
    }

    static constexpr std::uint64_t kDigest = 0x00f1e2d3c4b5a697;
    test::TempFolder temp_;
    std::filesystem::path file_ = temp_ / "paths.json";
    std::vector<PlannedPath> paths_;
    std::string text_;
};

TEST_F(SavedPaths, RoundTripBitEqual) {
    const StoredPaths stored = loadPaths(file_);
    EXPECT_EQ(stored.patient_digest, kDigest);
    EXPECT_EQ(stored.planner_version, kPlannerVersion);
    EXPECT_EQ(stored.paths.size(), 3u);
    EXPECT_TRUE(stored.paths == paths_);
}

// HZ-RECORD-14
TEST_F(SavedPaths, HostileFilesAreRefused) {
    expectRefusedAs("", "json");
    expectRefusedAs(text_ + "x", "json");
    expectRefusedAs(std::string(100000, '['), "json");
    expectRefusedAs("[]", "json");
    expectRefusedWith("stylet paths 2", "stylet paths 1", "format");
    expectRefusedWith("\"patient_digest\"", "\"patient\"", "patient_digest");
    expectRefusedWith("00f1e2d3", "f1e2d3", "patient_digest");
    expectRefusedWith("00f1e2d3", "0x00f1e2", "patient_digest");
    expectRefusedWith("\"00f1e2d3c4b5a697\"", "7", "patient_digest");
    expectRefusedWith("\"planner_version\": ", "\"planner_version\": 0.5", "planner_version");
    expectRefusedWith("\"planner_version\": ", "\"planner_version\": -", "planner_version");
    expectRefusedWith("\"paths\": [", "\"paths\": {}, \"rest\": [", "paths: not an array");
    expectRefusedWith("\"quality\"", "\"beauty\"", "paths[0].quality: missing");
    expectRefusedWith("\"quality\"", "\"beauty\": 1, \"quality\"", "paths[0].beauty: unknown key");
    expectRefusedWith("\"breath_v\": 0.0", "\"breath_v\": 1e999", "");
    expectRefusedWith("\"breath_v\": 0.0", "\"breath_v\": null", "paths[0].breath_v");
    expectRefusedWith("\"breath_v\": 0.0", "\"breath_v\": 7", "paths[0].breath_v");
    expectRefusedWith("\"entry_m\": [", "\"entry_m\": [1,", "paths[0].entry_m");
    expectRefusedWith("\"entry_m\": [", "\"entry_m\": 3, \"x\": [", "paths[0].entry_m");
    for (std::size_t n = 0; n + 2 < text_.size(); n += 7) {
        std::ofstream(file_) << text_.substr(0, n);
        EXPECT_THROW(loadPaths(file_), DataError) << n;
    }
    std::filesystem::remove(file_);
    test::expectRefused([&] { loadPaths(file_); }, "paths.json", "file");
}

}  // namespace
}  // namespace stylet::patient
