// Counts allocations per frame after the first frames, with a replaced operator new. There must be none.
#include <gtest/gtest.h>

#include "render/gpu/memory.h"
#include "render/volume/deformed_patient.h"
#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/support/counted_allocations.h"

namespace stylet::render {
namespace {

class AllocationTest : public test::GpuFixture<testing::TestWithParam<VolumePath>> {};

TEST_P(AllocationTest, FramesAllocateNothing) {
    const patient::Package package = test::makeTrunk(0.004);
    const patient::Patient patient(package);
    Gpu gpu({});
    const GpuImage image(gpu, vk::Format::eR8G8B8A8Srgb, {96, 96, 1}, 2,
                         vk::ImageUsageFlagBits::eColorAttachment);
    const StereoTarget target{*image.handle, VK_FORMAT_R8G8B8A8_SRGB, 96, 96};
    Renderer renderer(gpu, {.volume_path = GetParam(), .count = true}, test::assetsFolder());
    renderer.setPatient(patient);
    RenderScene scene;
    scene.stage_from_patient.position_m = {0.0, 1.0, 0.0};
    scene.room = wholeRoom();
    scene.field_m = Vec3(0.14, 0.03, 0.0);
    scene.drape = true;
    scene.look = Look::closed;
    const Vec3 flank(0.125, 0.05, 0.0);
    scene.marks = {{MarkKind::iodine, flank, 0.06}, {MarkKind::puncture, flank, 0.002}};
    patient::ToolDisplacement tool(patient);
    const auto eyes = test::stereo(test::lookAt(Vec3(0.3, 1.4, 0.3), Vec3(0, 1, 0), 0.4f), 0.063);
    const auto frames = [&](int count) {
        for (int i = 0; i < count; ++i) {
            scene.breath.v = 0.1 * (i % 7);
            scene.patient_from_needle = Pose{{1, 0, 0, 0}, Vec3(0.05 + 0.001 * (i % 5), 0.06, 0.0)};
            const auto contact = test::contactAt(flank, {-0.001 * (i % 7), 0.0, 0.0}, 0.010);
            scene.tool =
                tool.update({&contact, i % 7 > 0 ? 1u : 0u}, scene.breath, 0.5) ? &tool.table() : nullptr;
            renderer.draw(scene, eyes, target);
        }
    };
    frames(14);
    const std::uint64_t before = test::allocations();
    frames(14);
    EXPECT_EQ(test::allocations() - before, 0u);
}

// The probe slides, the needle moves and the patient breathes. None of this may allocate.
TEST(UltrasoundAllocationTest, PicturesAllocateNothing) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    const patient::Package package = test::makeTrunk(0.004);
    const patient::Patient patient(package);
    const Gpu gpu({});
    DeformedPatient deformed(gpu, patient);
    Ultrasound machine(gpu, deformed, loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml"));
    UltrasoundSettings settings;
    settings.lines = 64;
    settings.samples = 128;
    settings.width = settings.height = 128;
    const Transducer probe;
    const auto pictures = [&](int count) {
        for (int i = 0; i < count; ++i) {
            UltrasoundInput input;
            const Vec3 face(0.144, 0.001 * (i % 3), -0.015);
            input.patient_from_probe = Pose{glm::angleAxis(-1.5707963, Vec3(0, 1, 0)), face};
            input.patient_from_needle = Pose{{1, 0, 0, 0}, Vec3(0.10, 0.0, 0.001 * (i % 5))};
            deformed.breathe({0.1 * (i % 7), 0.0}, false);
            settings.gain_db = i % 4;
            settings.freeze = i % 5 == 4;
            EXPECT_EQ(machine.image(input, settings, probe).reason, "");
        }
    };
    pictures(16);
    const std::uint64_t before = test::allocations();
    pictures(16);
    EXPECT_EQ(test::allocations() - before, 0u);
}

INSTANTIATE_TEST_SUITE_P(GpuAndProcessor, AllocationTest,
                         testing::Values(VolumePath::gpu, VolumePath::processor));

}  // namespace
}  // namespace stylet::render
