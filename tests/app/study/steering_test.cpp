#include "app/study/steering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/app/study/pairs.h"

namespace stylet::study {
namespace {

using haptics::ExactEvent;

bool nearAnEvent(const std::vector<ExactEvent>& events, double depth_m) {
    return std::any_of(events.begin(), events.end(),
                       [&](const ExactEvent& e) { return std::fabs(e.depth_m - depth_m) < 1e-9; });
}

bool meetsBone(const PatientForces& felt) {
    return std::any_of(felt.segments->begin(), felt.segments->end(),
                       [](const haptics::Segment& s) { return s.tissue == patient::Tissue::bone; });
}

struct NeedleComparison {
    std::size_t walks = 0, unlike = 0;  // `unlike`: walks with a sample that is more than 1 nN off
    std::size_t samples = 0, unequal = 0;
};

// Compares the study's samples with the simulated needle on every `nth` path. Skips samples next to an event,
// because rounding decides on which side of the event they lie.
NeedleComparison compareWithNeedle(const Vec3& offset_m, std::size_t nth) {
    const PreparedPair pair(test::seededPair());
    Steering steering(pair, {});
    NeedleComparison out;
    for (std::size_t p = 0; p < test::seededPaths().size(); p += nth) {
        patient::PlannedPath path = test::seededPaths()[p];
        for (Vec3* end_m : {&path.entry_m, &path.target_m, &path.entry_reference_m, &path.target_reference_m})
            *end_m += offset_m;
        const SteeringResult& s = *steering.steer(path);
        const Vec3 axis = glm::normalize(path.target_m - path.entry_m);
        for (const auto& [felt, patient] :
             {std::pair(&s.full, &pair.full), std::pair(&s.partial, &pair.partial)}) {
            if (meetsBone(*felt)) continue;  // at bone, the study applies the maximum force at once
            haptics::NeedleState needle;
            haptics::NeedleEvents events;
            const auto stepTo = [&](double depth_m) {
                haptics::stepNeedle(needle, {}, {*patient, path.breath},
                                    {path.entry_m + (depth_m - s.entry_m) * axis, axis}, events);
            };
            stepTo(0.0);
            double worst_n = 0.0;
            for (std::size_t i = 0; i < felt->samples_n.size(); ++i) {
                const double depth_m = s.first_m + double(i) * s.step_m;
                stepTo(depth_m);
                if (nearAnEvent(felt->force->events, depth_m)) continue;
                const double error_n = std::fabs(needle.force_n - felt->samples_n[i]);
                ++out.samples;
                out.unequal += error_n > 0.0;
                worst_n = std::max(worst_n, error_n);
            }
            ++out.walks;
            out.unlike += worst_n > 1e-9;
        }
    }
    return out;
}

TEST(StudySteering, MatchesTheSampledNeedle) {
    const NeedleComparison c = compareWithNeedle({0.00031, 0.00017, 0.00023}, 7);
    EXPECT_GT(c.walks, 40u);
    EXPECT_EQ(c.unlike, 0u);
    // The unequal samples differ only in their last bits, and only where the force rises.
    EXPECT_LT(double(c.unequal), 0.2 * double(c.samples));
}

// A path between voxel centres runs through voxel corners. At a corner, rounding decides which voxel the
// simulated needle enters.
TEST(StudySteering, MatchesTheSampledNeedleExceptAtVoxelCorners) {
    const NeedleComparison c = compareWithNeedle({}, 3);
    EXPECT_LT(double(c.unlike), 0.08 * double(c.walks));
}

TEST(StudySteering, SamplesAreDenseBetweenContactAndTarget) {
    const PreparedPair pair(test::seededPair());
    for (const int samples : {100, 1000}) {
        SteeringSettings settings;
        settings.samples = samples;
        Steering steering(pair, settings);
        for (std::size_t p = 0; p < test::seededPaths().size(); p += 20) {
            const SteeringResult& s = *steering.steer(test::seededPaths()[p]);
            EXPECT_GE(s.full.samples_n.size(), std::size_t(samples));
            EXPECT_EQ(s.full.samples_n.size(), s.partial.samples_n.size());
            EXPECT_LE(s.step_m, settings.max_spacing_m);
            EXPECT_NEAR(s.first_m, s.begin_m + 0.5 * s.step_m, 1e-12);
            EXPECT_NEAR(s.first_m + (double(s.full.samples_n.size()) - 0.5) * s.step_m, s.end_m, 1e-9);
            EXPECT_NEAR(s.end_m - s.entry_m, test::seededPaths()[p].length_m, 1e-12);
            EXPECT_LE(s.begin_m, s.entry_m);
            // No force acts before the first contact.
            EXPECT_EQ(s.full.force->at(s.begin_m - 1e-9), 0.0);
            EXPECT_EQ(s.partial.force->at(s.begin_m - 1e-9), 0.0);
        }
    }
}

// With the setting `breathing`, a patient without motion gives the same forces as without the setting. A
// patient with motion gives other forces.
TEST(StudySteering, BreathesOnlyWhenRequested) {
    SteeringSettings still, breathing;
    breathing.breathing = true;
    Pair held = test::seededPair();
    held.reference.motion = {}, held.found.motion = {};
    const PreparedPair at_rest(held), alive(test::seededPair());
    Steering without(at_rest, still), with(at_rest, breathing), moved(alive, breathing);
    bool differs = false;
    for (std::size_t p = 0; p < test::seededPaths().size(); p += 60) {
        patient::PlannedPath path = test::seededPaths()[p];
        const SteeringResult& a = *without.steer(path);
        if (meetsBone(a.full) || meetsBone(a.partial)) continue;
        const SteeringResult& b = *with.steer(path);
        ASSERT_EQ(a.full.samples_n.size(), b.full.samples_n.size());
        EXPECT_TRUE(b.full.force->pieces.empty());
        EXPECT_GT(b.full.force->events.size(), 3u);
        std::size_t unlike = 0;
        for (std::size_t i = 0; i < a.full.samples_n.size(); ++i)
            unlike += std::fabs(a.full.samples_n[i] - b.full.samples_n[i]) > 1e-9;
        EXPECT_LE(unlike, 3u);  // samples next to a puncture
        const SteeringResult& c = *moved.steer(path);
        for (std::size_t i = 0; i < c.full.samples_n.size(); ++i)
            differs = differs || std::fabs(c.full.samples_n[i] - b.full.samples_n[i]) > 0.05;
    }
    EXPECT_TRUE(differs);
}

TEST(StudySteering, PathThroughAirHasNoResult) {
    const PreparedPair pair(test::seededPair());
    Steering steering(pair, {});
    patient::PlannedPath path = test::seededPaths().front();
    EXPECT_NE(steering.steer(path), nullptr);
    path.entry_reference_m = {0.5, 0.0, 0.0}, path.target_reference_m = {0.55, 0.0, 0.0};
    EXPECT_EQ(steering.steer(path), nullptr);
    path.target_reference_m = path.entry_reference_m;
    EXPECT_EQ(steering.steer(path), nullptr);
}

}  // namespace
}  // namespace stylet::study
