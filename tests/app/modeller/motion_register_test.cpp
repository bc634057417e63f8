// Tests that need the programs built on ITK.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "app/modeller/motion/motion_cavity.h"
#include "app/modeller/motion/motion_fit.h"
#include "patient/package/nifti.h"
#include "tests/app/modeller/chest.h"
#include "tests/app/modeller/run_model.h"
#include "tests/support/phantom.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

std::filesystem::path program(const char* name) {
    const char* bin = std::getenv("STYLET_BIN");
    return std::filesystem::path(bin ? bin : ".") / name;
}

RegisterSettings registration(int finest) {
    RegisterSettings settings;
    settings.program = program("stylet-register");
    settings.finest = finest;
    return settings;
}

TEST(Registration, PreservesSlidingAtTheInterface) {
    const test::ChestSettings chest{.spacing_m = 0.003, .travel_m = 0.006, .phases = 2};
    const Phase fixed = test::chestPhase(chest, 0), moving = test::chestPhase(chest, 1);
    Mask inside(fixed.hu.grid);
    forEachVoxel(inside.grid, [&](const Index3& i) {
        const Vec3 p = inside.grid.centre(i);
        inside[i] = std::hypot(p.x, p.y) < 0.068;
    });
    const Mask outside = inverted(inside);
    const VectorField slide = registerPhases(fixed.hu, moving.hu, inside, registration(1));
    const VectorField wall = registerPhases(fixed.hu, moving.hu, outside, registration(1));
    // Around the axis, 5 mm on either side of the interface, and at the centre.
    for (int a = 0; a < 12; ++a) {
        const double phi = a * 0.5236, z_m = -0.012 + 0.004 * (a % 5);
        const Vec3 direction(std::cos(phi), std::sin(phi), 0.0);
        EXPECT_NEAR(vectorAt(slide, 0.063 * direction + Vec3(0, 0, z_m)).z, -0.006, 0.0012) << a;
        EXPECT_NEAR(vectorAt(wall, 0.073 * direction + Vec3(0, 0, z_m)).z, 0.0, 0.0006) << a;
    }
    EXPECT_NEAR(vectorAt(slide, Vec3(0.0)).z, -0.006, 0.0006);
}

TEST(Registration, InvalidPhaseFoldersAreRefused) {
    const test::TempFolder folder;
    FitSettings settings;
    settings.phases.reader.program = program("stylet-image-reader");
    settings.registration = registration(4);
    settings.phases.folder = folder / "none";
    EXPECT_THROW((void)fitMotion(settings), ImportError);
    settings.phases.folder = folder.path();
    EXPECT_THROW((void)fitMotion(settings), ImportError);  // too few phases
    for (int i = 0; i < 4; ++i)
        std::ofstream(folder / ("phase" + std::to_string(i) + ".dcm")) << std::string(400, 'x');
    const std::string why = test::errorText<ImportError>([&] { (void)fitMotion(settings); });
    EXPECT_THAT(why, testing::HasSubstr("phase0.dcm"));
}

// Runs the command that writes the motion of a 4D CT into a package at the same position. Nothing else in the
// package may change.
class MotionPackage : public testing::Test {
  protected:
    static constexpr test::ChestSettings kChest{.spacing_m = 0.003, .travel_m = 0.008, .phases = 4};

    MotionPackage() {
        std::filesystem::create_directory(folder_ / "phases");
        std::ofstream signal(folder_ / "signal.csv");
        signal << "phase,v,rate_per_s\n";
        for (int p = 0; p < kChest.phases; ++p) {
            const Phase phase = test::chestPhase(kChest, p);
            CtVolume stored(phase.hu.grid);
            for (std::size_t i = 0; i < stored.voxels.size(); ++i)
                stored.voxels[i] = std::int16_t(std::lround(phase.hu.voxels[i]));
            if (p == 0) package_.ct = stored;
            patient::writeNifti(folder_ / ("phases/" + phase.name + ".nii.gz"), stored);
            signal << p << ',' << test::breathingState(p, kChest.phases) << ",0\n";
        }
        package_.name = "chest";
        package_.licence = "none";
        package_.provenance = "made";
        package_.labels = LabelVolume(package_.ct.grid);
        package_.label_table = test::tissueLabels();
        for (patient::Label& label : package_.label_table)
            label.provenance = "made";
        for (int z = 0; z < 10; ++z)
            package_.labels[{25, 25, z}] = 4;
        package_.tissues = test::tissueDefaults().tissues;
        package_.elasticity = test::tissueDefaults().elasticity;
        package_.thresholds = test::tissueDefaults().thresholds;
    }
    test::ModelRun fit(const std::filesystem::path& package, int finest) {
        return test::runModel("motion --finest " + std::to_string(finest) + " --phases '" +
                              (folder_ / "phases").string() + "' --signal '" +
                              (folder_ / "signal.csv").string() + "' --package '" + package.string() +
                              "' --out '" + (folder_ / "out").string() + "'");
    }

    const test::TempFolder folder_;
    patient::Package package_;
};

TEST_F(MotionPackage, GainsTheFittedMotionAndIsOtherwiseUnchanged) {
    patient::savePackage(package_, folder_ / "in");
    const test::ModelRun run = fit(folder_ / "in", 2);
    ASSERT_EQ(run.status, 1) << run.err;  // written, but refused: a chest without skin
    EXPECT_THAT(run.out, testing::HasSubstr("REFUSED  skin"));
    const patient::Package out = patient::loadPackage(folder_ / "out");
    EXPECT_EQ(out.name, package_.name);
    EXPECT_EQ(out.ct.voxels, package_.ct.voxels);
    EXPECT_EQ(out.labels.voxels, package_.labels.voxels);
    EXPECT_EQ(out.reference_phase, "exhale");
    EXPECT_EQ(out.motion.reference.v, 0.0);
    // The dome moves down 8 mm at end-inhale. The ribs around it do not move.
    EXPECT_NEAR(out.motion.dome_travel_m, 0.008, 0.0015);
    EXPECT_NEAR(deformedFromReference(out.motion, {1.0, 0.0}, Vec3(0.0)).z, -0.008, 0.0015);
    EXPECT_NEAR(deformedFromReference(out.motion, {1.0, 0.0}, Vec3(0.078, 0.0, 0.0)).z, 0.0, 0.001);
    EXPECT_THAT(run.out, testing::HasSubstr("the frame of the model"));
}

TEST_F(MotionPackage, OutsideThePhasesIsRefused) {
    package_.ct.grid.origin_m.z += 1.0;
    package_.labels.grid = package_.ct.grid;
    patient::savePackage(package_, folder_ / "in");
    const test::ModelRun run = fit(folder_ / "in", 4);
    EXPECT_EQ(run.status, 2);
    EXPECT_THAT(run.err, testing::HasSubstr("lies elsewhere"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST(RealMotion, LeftOutPhaseIsPredictedWithinAVoxel) {
    const char* data = std::getenv("STYLET_DATA");
    if (!data) GTEST_SKIP() << "STYLET_DATA is not set: no 4D CT";
    FitSettings settings;
    settings.phases.folder = std::filesystem::path(data) / "4dct_118";
    settings.phases.reader.program = program("stylet-image-reader");
    settings.registration = registration(4);
    const FittedMotion fitted = fitMotion(settings);
    ASSERT_EQ(fitted.phases.size(), 10u);
    EXPECT_EQ(fitted.reference, 3u);  // file 4 is end-exhale
    EXPECT_EQ(fitted.phases[7].surrogate.v, 1.0);
    EXPECT_GT(fitted.columns, 2000u);
    for (std::size_t p = 0; p < 10; ++p) {
        if (p == fitted.reference) continue;
        const PhaseReport& r = fitted.phases[p];
        EXPECT_LT(r.left_out.mean_abs_m, fitted.voxel_m.z) << r.name;
        EXPECT_LT(r.left_out.slice_mean_abs_m, fitted.voxel_m.z) << r.name;
        EXPECT_LT(r.left_out.mean_abs_m, 0.6 * r.no_motion.mean_abs_m) << r.name;
    }
    EXPECT_LT(fitted.phases[7].dome_m, -0.006);
}

}  // namespace
}  // namespace stylet::modeller
