// Label names are for people. The same patient with other names behaves the same, bit for bit.
#include <gtest/gtest.h>

#include "app/study/study.h"
#include "app/training/surroundings.h"
#include "patient/patient.h"
#include "patient/synth/labels.h"
#include "tests/app/study/pairs.h"
#include "tests/support/constants.h"

namespace stylet {
namespace {

using patient::Package;
using patient::synth::Id;

// Every label gets the name of another one.
void swapNames(Package& package) {
    std::vector<std::string> names;
    for (const patient::Label& label : package.label_table)
        names.push_back(label.name);
    for (std::size_t i = 0; i < names.size(); ++i)
        package.label_table[i].name = names[(i + names.size() / 2) % names.size()];
}

// Every label gets all the words by which code once recognised an organ.
void nameAllAlike(Package& package) {
    for (patient::Label& label : package.label_table)
        label.name = "heart portal hepatic vein cava aorta artery small bowel duodenum tumour gas lung";
}

class LabelNames : public testing::TestWithParam<void (*)(Package&)> {
  protected:
    static Package renamed(Package package) {
        GetParam()(package);
        return package;
    }
    const Package& before_ = test::seededTruth();
    const Package after_ = renamed(before_);
    const patient::Patient old_{before_}, new_{after_};
};

TEST_P(LabelNames, DoNotChangeTheDigest) {
    EXPECT_NE(after_.label_table[0].name, before_.label_table[0].name);
    EXPECT_EQ(patient::digest(after_), patient::digest(before_));
}

TEST_P(LabelNames, DoNotChangeTheBloodFlow) {
    const patient::VesselFlow before = patient::makeVesselFlow(old_), after = patient::makeVesselFlow(new_);
    ASSERT_FALSE(before.velocity.empty());
    EXPECT_EQ(after.grid, before.grid);
    EXPECT_EQ(after.velocity, before.velocity);
}

// A middle voxel of a label.
Vec3 voxelOf(const Package& package, Id id) {
    std::vector<Index3> voxels;
    forEachVoxel(package.labels.grid, [&](const Index3& i) {
        if (package.labels[i] == std::uint8_t(id)) voxels.push_back(i);
    });
    return package.labels.grid.centre(voxels.at(voxels.size() / 2));
}

// The flow of contrast medium from a tip in each label.
TEST_P(LabelNames, DoNotChangeTheContrastMedium) {
    for (int id = 1; id < patient::synth::kIdCount; ++id) {
        const Vec3 tip = voxelOf(before_, Id(id));
        patient::Contrast before(old_), after(new_);
        for (int tick = 0; tick < 1500; ++tick) {
            const patient::ContrastInput input{tip, 8e-6, true};
            before.step(input, test::kDt_s), after.step(input, test::kDt_s);
        }
        EXPECT_EQ(after.hash(), before.hash()) << id;
        EXPECT_EQ(after.status().place, before.status().place) << id;
        EXPECT_EQ(after.status().at_blockage, before.status().at_blockage) << id;
        EXPECT_EQ(after.plumes().size(), before.plumes().size()) << id;
        EXPECT_EQ(after.stains().size(), before.stains().size()) << id;
        for (std::size_t i = 0; i < std::min(before.stains().size(), after.stains().size()); ++i)
            EXPECT_EQ(after.stains()[i].kind, before.stains()[i].kind) << id;
    }
}

TEST_P(LabelNames, DoNotChangePathsAndClearances) {
    const patient::PlanResult before = patient::planPaths(old_, {}), after = patient::planPaths(new_, {});
    ASSERT_GT(before.paths.size(), 10u);
    EXPECT_EQ(after.paths, before.paths);
    EXPECT_EQ(after.rejected_blocked, before.rejected_blocked);
    const patient::PlannedPath& path = before.paths.front();
    const training::Surroundings around(old_, path), around_new(new_, path);
    for (const double share : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
        const Vec3 p = path.entry_reference_m + share * (path.target_reference_m - path.entry_reference_m);
        EXPECT_EQ(around_new.distanceToRisk_m(p), around.distanceToRisk_m(p)) << share;
        EXPECT_EQ(around_new.distanceToDuct_m(p), around.distanceToDuct_m(p)) << share;
    }
}

// Forces down planned paths, in the patient and in a partial segmentation of it.
TEST_P(LabelNames, DoNotChangeForces) {
    const study::Pair before = test::seededPair();
    const study::Pair after =
        study::makePair(test::kTestFiles, after_, renamed(test::movedAndCut(before_)), before.labels);
    const study::PreparedPair one(before), other(after);
    study::Steering steer_one(one, {}), steer_other(other, {});
    std::size_t compared = 0;
    for (std::size_t i = 0; i < test::seededPaths().size(); i += 10) {
        const study::SteeringResult *a = steer_one.steer(test::seededPaths()[i]),
                                    *b = steer_other.steer(test::seededPaths()[i]);
        ASSERT_EQ(a == nullptr, b == nullptr);
        if (!a) continue;
        ++compared;
        EXPECT_EQ(b->full.samples_n, a->full.samples_n);
        EXPECT_EQ(b->partial.samples_n, a->partial.samples_n);
    }
    EXPECT_GT(compared, 10u);
}

INSTANTIATE_TEST_SUITE_P(Renamed, LabelNames, testing::Values(swapNames, nameAllAlike));

}  // namespace
}  // namespace stylet
