// If the device is lost, out of memory or too small, there must be a clear message and, where possible, a way
// to continue. A Vulkan layer between the loader and the real driver (tests/support/vulkan_faults) injects
// the faults.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"

namespace stylet::render {
namespace {

// Sets and restores the environment for one test's Vulkan instances.
class FaultsTest : public test::GpuFixture<> {
  protected:
    void TearDown() override {
        for (const auto& [name, before] : before_)
            before ? setenv(name.c_str(), before->c_str(), 1) : unsetenv(name.c_str());
    }
    void fail(const char* what, std::uint64_t number) {
        set("VK_LAYER_PATH", STYLET_FAULTS_FOLDER);
        set("VK_INSTANCE_LAYERS", "VK_LAYER_STYLET_faults");
        set(what, std::to_string(number));
    }

    // 166 voxels per edge, 18 MB classified.
    const patient::Package package = test::makeBall(patient::Tissue::bone, 0.07, 0.013, 0.001);
    const patient::Patient patient{package};
    const std::array<View, 2> eyes =
        test::stereo(test::lookAt(Vec3(0.2, 0.4, 0.6), Vec3(0, 0, 0), 0.4f), 0.063);

  private:
    void set(const char* name, const std::string& value) {
        const char* now = std::getenv(name);
        before_.try_emplace(name, now ? std::optional<std::string>(now) : std::nullopt);
        setenv(name, value.c_str(), 1);
    }
    std::map<std::string, std::optional<std::string>> before_;
};

TEST_F(FaultsTest, LostDeviceIsReported) {
    constexpr std::uint64_t kSubmissions = 12;
    fail("STYLET_FAULT_LOST_AFTER", kSubmissions);
    try {
        Gpu gpu({});
        Renderer renderer(gpu, {}, test::assetsFolder());
        renderer.setPatient(patient);
        for (std::uint64_t i = 0; i < 4 * kSubmissions; ++i)
            renderer.drawToImages({}, eyes, 32, 32);
        FAIL() << "nothing was thrown";
    } catch (const GpuError& e) {
        EXPECT_NE(std::string(e.what()).find("DeviceLost"), std::string::npos) << e.what();
    }
}

// HZ-TEACH-21
TEST_F(FaultsTest, VolumeAboveTheImageSizeLimitIsDownsampled) {
    RenderScene scene;
    scene.table = false;
    Gpu whole({});
    Renderer reference(whole, {.volume_path = VolumePath::gpu}, test::assetsFolder());
    reference.setPatient(patient);
    const Image fine = reference.drawToImages(scene, eyes, 128, 128)[0];
    EXPECT_TRUE(reference.notes().empty());

    fail("STYLET_FAULT_IMAGE_3D", 100);
    Gpu gpu({});
    Renderer renderer(gpu, {.volume_path = VolumePath::gpu}, test::assetsFolder());
    renderer.setPatient(patient);
    const Image coarse = renderer.drawToImages(scene, eyes, 128, 128)[0];
    ASSERT_EQ(renderer.notes().size(), 1u);
    EXPECT_NE(renderer.notes()[0].find("100"), std::string::npos) << renderer.notes()[0];
    EXPECT_GT(test::psnr(fine, coarse), 22.0);
    EXPECT_LT(test::psnr(fine, coarse), 60.0) << "the limit was not felt";
}

TEST_F(FaultsTest, VolumeThatDoesNotFitInMemoryIsDownsampled) {
    fail("STYLET_FAULT_MEMORY", 12'000'000);
    Gpu gpu({});
    Renderer renderer(gpu, {.volume_path = VolumePath::gpu}, test::assetsFolder());
    renderer.setPatient(patient);
    RenderStats stats;
    renderer.drawToImages({}, eyes, 32, 32, &stats);
    ASSERT_EQ(renderer.notes().size(), 1u);
    EXPECT_NE(renderer.notes()[0].find("memory"), std::string::npos) << renderer.notes()[0];
}

// HZ-TEACH-21
TEST_F(FaultsTest, OutOfMemoryIsReported) {
    fail("STYLET_FAULT_MEMORY", 1000);
    try {
        Gpu gpu({});
        Renderer renderer(gpu, {}, test::assetsFolder());
        renderer.setPatient(patient);
        renderer.drawToImages({}, eyes, 32, 32);
        FAIL() << "nothing was thrown";
    } catch (const GpuError& e) {
        EXPECT_NE(std::string(e.what()).find("OutOfDeviceMemory"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace stylet::render
