#include "patient/synth/synth.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <set>

#include "patient/synth/labels.h"

namespace stylet::patient::synth {
namespace {

SynthSettings settings(std::uint64_t seed, double spacing_mm, int threads) {
    SynthSettings s;
    s.seed = seed;
    s.spacing_m = spacing_mm * 0.001;
    s.threads = threads;
    const char* assets = std::getenv("STYLET_ASSETS");
    if (assets) s.defaults = loadTissueDefaults(std::filesystem::path(assets) / "tissue" / "ptcd.toml");
    return s;
}

// Made once for all tests, by two threads.
const Package& sharedPatient(std::uint64_t seed, double spacing_mm) {
    static std::map<std::pair<std::uint64_t, double>, Package> made;
    const auto key = std::pair(seed, spacing_mm);
    if (const auto found = made.find(key); found != made.end()) return found->second;
    return made.emplace(key, makeReferencePatient(settings(seed, spacing_mm, 2))).first->second;
}

TEST(ReferencePatient, SameSeedSameBytesForAnyNumberOfThreads) {
    const Package one = makeReferencePatient(settings(11, 4.0, 1));
    const Package three = makeReferencePatient(settings(11, 4.0, 3));
    EXPECT_EQ(one.labels.voxels, three.labels.voxels);
    EXPECT_EQ(one.ct.voxels, three.ct.voxels);
    EXPECT_EQ(one.motion, three.motion);
    EXPECT_EQ(digest(one), digest(three));
}

TEST(ReferencePatient, WithoutMotionTheVoxelsAreTheSame) {
    SynthSettings still = settings(11, 5.0, 2);
    still.motion = false;
    const Package breathing = makeReferencePatient(settings(11, 5.0, 2)),
                  motionless = makeReferencePatient(still);
    EXPECT_EQ(motionless.ct.voxels, breathing.ct.voxels);
    EXPECT_EQ(motionless.labels.voxels, breathing.labels.voxels);
    EXPECT_TRUE(motionless.motion.empty());
    EXPECT_FALSE(breathing.motion.empty());
}

TEST(ReferencePatient, DifferentSeedsGiveDifferentPatients) {
    std::set<std::uint64_t> digests;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
        digests.insert(digest(makeReferencePatient(settings(seed, 5.0, 2))));
    EXPECT_EQ(digests.size(), 4u);
}

TEST(ReferencePatient, EveryLabelHasARowAndVoxels) {
    const Package& p = sharedPatient(1, 2.5);
    ASSERT_EQ(p.label_table.size(), std::size_t(kIdCount - 1));
    std::array<std::size_t, 256> count{};
    for (const std::uint8_t l : p.labels.voxels)
        ++count[l];
    std::set<std::string> names;
    for (std::size_t i = 0; i < p.label_table.size(); ++i) {
        const Label& l = p.label_table[i];
        EXPECT_EQ(l.id, i + 1);
        EXPECT_GT(count[l.id], 0u) << l.name;
        EXPECT_FALSE(l.provenance.empty()) << l.name;
        names.insert(l.name);
    }
    EXPECT_EQ(names.size(), p.label_table.size());
    EXPECT_EQ(p.label_table[std::size_t(Id::ducts) - 1].role, Role::target);
    EXPECT_EQ(p.label_table[std::size_t(Id::ribsRight) - 1].tissue, Tissue::bone);
    EXPECT_EQ(p.label_table[std::size_t(Id::cartilage) - 1].tissue, Tissue::cartilage);
}

// Only the checks that coarse voxels can pass. `stylet-model check` runs all checks at 1 mm.
TEST(ReferencePatient, CoarsePatientPassesItsChecks) {
    const std::set<std::string> too_fine{"duct branches of 3-8 mm", "duct branches below 3 mm",
                                         "widest duct branch", "duct within 6 mm of a portal branch"};
    for (const std::uint64_t seed : {1, 2}) {
        const Package& p = sharedPatient(seed, 2.5);
        for (const CheckLine& l : checkPatient(p)) {
            if (too_fine.contains(l.name)) continue;
            EXPECT_TRUE(l.ok()) << "seed " << seed << ": " << l.name << " " << l.value << " " << l.unit;
        }
    }
}

// HZ-TEACH-08
TEST(ReferencePatient, CheckFindsDefects) {
    Package p = sharedPatient(3, 3.0);
    const auto value = [&](const std::string& name) {
        for (const CheckLine& l : checkPatient(p))
            if (l.name == name) return l.value;
        ADD_FAILURE() << "no line named " << name;
        return 0.0;
    };
    EXPECT_EQ(value("fascia: outside reached from the liver"), 0.0);
    EXPECT_EQ(value("islands"), 0.0);
    // Adds a hole in the fascia, a drop of liver in the lung, and bile that is too bright.
    std::size_t holes = 0, bile = 0;
    for (std::size_t n = 0; n < p.labels.voxels.size(); ++n) {
        if (p.labels.voxels[n] == std::uint8_t(Id::fascia) && ++holes < 400)
            p.labels.voxels[n] = std::uint8_t(Id::muscle);
        if (p.labels.voxels[n] == std::uint8_t(Id::ducts))
            p.ct.voxels[n] = std::int16_t(p.ct.voxels[n] + 30), ++bile;
    }
    const auto lung = std::find(p.labels.voxels.begin(), p.labels.voxels.end(), std::uint8_t(Id::lungLeft));
    *lung = std::uint8_t(Id::liver);
    EXPECT_GT(value("fascia: outside reached from the liver"), 1000.0);
    EXPECT_EQ(value("islands"), 1.0);
    EXPECT_GT(value("mean of bile ducts"), 33.0);
    EXPECT_GT(bile, 0u);
}

TEST(ReferencePatient, CheckRefusesOtherLabels) {
    Package p = makeReferencePatient(settings(1, 5.0, 1));
    p.label_table.pop_back();
    EXPECT_THROW(checkPatient(p), std::invalid_argument);
}

// The shipped patient over a whole breath.
TEST(ReferencePatient, LiverMovesRibsMoveLittleAndSpineIsFixed) {
    const Package& p = sharedPatient(1, 3.0);
    const Surrogate inhale{1.0, 0.0};
    std::size_t liver = 0, moved = 0, bone_inside = 0;
    double rib_m = 0.0, spine_m = 0.0;
    const Grid& grid = p.labels.grid;
    forEachVoxel(grid, [&](const Index3& i) {
        const Id l = Id(p.labels[i]);
        const Vec3 at = grid.centre(i);
        const Vec3 travel = deformedFromReference(p.motion, inhale, at) - at;
        if (l == Id::liver) ++liver, moved += travel.z < -0.010 ? 1 : 0;
        if (l == Id::spine) spine_m = std::max(spine_m, glm::length(travel));
        if (l != Id::ribsRight && l != Id::ribsLeft) return;
        rib_m = std::max(rib_m, glm::length(travel));
        bone_inside += cavityLevel_m(p.motion, at) < 0.0;
    });
    EXPECT_GT(double(moved), 0.9 * double(liver));
    EXPECT_EQ(bone_inside, 0u);
    EXPECT_LT(rib_m, 0.005);
    EXPECT_EQ(spine_m, 0.0);
}

// With 15 mm of dome travel, the sides slip at the flank's pleura without gaps or folds.
TEST(ReferencePatient, SidesSlipAtTheFlankWithoutGapOrFold) {
    const Package p = makeReferencePatient(settings(1, 2.0, 2));
    const Surrogate inhale{1.0, 0.0};
    const InterfaceError error = worstInterface(p.motion);
    EXPECT_LT(error.worst_gap_m, 0.0005);
    EXPECT_LT(error.worst_overlap_m, 0.0005);
    EXPECT_LT(error.mean_m, 0.0001);

    std::size_t flank = 0;
    double least_m = 1.0;
    for (const SurfacePoint& s : cavitySurface(p.motion)) {
        // Beside the liver, right of the spine.
        if (s.reference_m.x < 0.08 || s.reference_m.z < 0.0 || s.reference_m.z > 0.10) continue;
        const Vec3 in = s.reference_m - 0.005 * s.normal, out = s.reference_m + 0.005 * s.normal;
        const Vec3 slip = deformedFromReference(p.motion, inhale, in) - in -
                          (deformedFromReference(p.motion, inhale, out) - out);
        least_m = std::min(least_m, glm::length(slip));
        ++flank;
    }
    EXPECT_GT(flank, 1000u);
    EXPECT_GE(least_m, 0.008);

    EXPECT_GT(minJacobian(p.motion, 1.0), 0.2);
    EXPECT_GT(minJacobian(p.motion, 3.0), 0.0);
}

#ifdef STYLET_SANITIZED
constexpr std::uint64_t kBreathers = 1;
#else
constexpr std::uint64_t kBreathers = 3;
#endif

// Checks several patients and amplitudes over all breathing states that the model allows.
TEST(ReferencePatient, NoSeedTearsOrFoldsAtAnyAmplitude) {
    const double domes_m[] = {0.025, 0.015, 0.020};
    for (std::uint64_t seed = 1; seed <= kBreathers; ++seed) {
        const Package& p = sharedPatient(seed, 3.0);
        MotionAmplitudes amplitudes;
        amplitudes.dome_m = domes_m[seed - 1];
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", dome " << amplitudes.dome_m);
        const MotionModel m = motionTemplate(p.labels, p.label_table, amplitudes, {});
        const InterfaceError error = worstInterface(m);
        ASSERT_GT(error.points, 20000u);
        EXPECT_LT(error.worst_gap_m, 0.0005);
        EXPECT_LT(error.worst_overlap_m, 0.0005);
        EXPECT_LT(error.p99_m, 0.0002);
        EXPECT_GT(error.max_slip_m, 0.95 * amplitudes.dome_m);
        EXPECT_GT(minJacobian(m, 3.0), 0.0);
    }
}

}  // namespace
}  // namespace stylet::patient::synth
