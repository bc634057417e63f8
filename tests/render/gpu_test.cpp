#include "render/gpu/gpu.h"

#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "render/gpu/pipeline_cache_file.h"
#include "tests/render/gpu_fixture.h"
#include "tests/render/pictures.h"
#include "tests/support/temp_folder.h"

namespace stylet::render {
namespace {

class GpuTest : public test::GpuFixture<> {};

TEST_F(GpuTest, NamesTheDeviceAndChoosesAPath) {
    const Gpu gpu({});
    EXPECT_FALSE(gpu.name().empty());
    EXPECT_NE(gpu.stereoPath(), StereoPath::best);
    EXPECT_EQ(gpu.stereoPath() == StereoPath::multiview, gpu.multiviewWorks());
}

TEST_F(GpuTest, RejectsAStereoPathThatDoesNotWork) {
    if (Gpu({}).multiviewWorks()) {
        EXPECT_EQ(Gpu({.stereo = StereoPath::multiview}).stereoPath(), StereoPath::multiview);
    } else {
        EXPECT_THROW(Gpu({.stereo = StereoPath::multiview}), GpuError);
    }
}

TEST_F(GpuTest, CallsTheHooks) {
    int instances = 0, picks = 0, devices = 0;
    GpuHooks hooks;
    hooks.createInstance = [&](PFN_vkGetInstanceProcAddr get, const VkInstanceCreateInfo* info,
                               VkInstance* out) {
        ++instances;
        return reinterpret_cast<PFN_vkCreateInstance>(get(nullptr, "vkCreateInstance"))(info, nullptr, out);
    };
    hooks.pickDevice = [&](VkInstance instance) {
        ++picks;
        std::uint32_t count = 1;
        VkPhysicalDevice device = VK_NULL_HANDLE;
        vkEnumeratePhysicalDevices(instance, &count, &device);
        return device;
    };
    hooks.createDevice = [&](PFN_vkGetInstanceProcAddr, VkPhysicalDevice physical,
                             const VkDeviceCreateInfo* info, VkDevice* out) {
        ++devices;
        return vkCreateDevice(physical, info, nullptr, out);
    };
    const Gpu gpu({}, hooks);
    EXPECT_EQ(instances, 1);
    EXPECT_EQ(picks, 1);
    EXPECT_EQ(devices, 1);
}

// Monado's xrCreateVulkanDeviceKHR appends this structure to the application's chain.
TEST_F(GpuTest, RuntimeMayAppendTimelineSemaphoreFeatures) {
    GpuHooks hooks;
    hooks.createDevice = [](PFN_vkGetInstanceProcAddr, VkPhysicalDevice physical,
                            const VkDeviceCreateInfo* info, VkDevice* out) {
        VkPhysicalDeviceTimelineSemaphoreFeatures appended{
            .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES,
            .pNext = const_cast<void*>(info->pNext),
            .timelineSemaphore = VK_TRUE};
        VkDeviceCreateInfo with = *info;
        with.pNext = &appended;
        return vkCreateDevice(physical, &with, nullptr, out);
    };
    const Gpu gpu({.validation = true}, hooks);
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

TEST_F(GpuTest, FailingHookIsNamedInTheError) {
    GpuHooks hooks;
    hooks.createInstance = [](PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*) {
        return VK_ERROR_INITIALIZATION_FAILED;
    };
    try {
        const Gpu gpu({}, hooks);
        FAIL() << "no exception";
    } catch (const GpuError& e) {
        EXPECT_NE(std::string(e.what()).find("vkCreateInstance"), std::string::npos) << e.what();
    }
}

TEST_F(GpuTest, ValidationCountsMessages) {
    const Gpu gpu({.validation = true});
    EXPECT_EQ(gpu.validationMessages(), 0u);
    // A buffer of zero bytes is invalid usage. If the validation layer did not report it, the layer would
    // be inactive and every test would pass.
    const VkBufferCreateInfo empty{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                   .pNext = nullptr,
                                   .flags = 0,
                                   .size = 0,
                                   .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                                   .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                   .queueFamilyIndexCount = 0,
                                   .pQueueFamilyIndices = nullptr};
    VkBuffer buffer = VK_NULL_HANDLE;
    vkCreateBuffer(*gpu.device(), &empty, nullptr, &buffer);
    EXPECT_GT(gpu.validationMessages(), 0u);
    vkDestroyBuffer(*gpu.device(), buffer, nullptr);
}

TEST_F(GpuTest, ReloadsThePipelineCacheFile) {
    const test::TempFolder folder;
    const std::string file = (folder / "pipelines").string();
    EXPECT_EQ(Gpu({.pipeline_cache = file}).pipelineWork().loaded_bytes, 0u);
    EXPECT_GT(std::filesystem::file_size(file), 0u);
    EXPECT_GT(Gpu({.pipeline_cache = file}).pipelineWork().loaded_bytes, 0u);
    std::ofstream(file, std::ios::binary) << "not a cache";
    EXPECT_EQ(Gpu({.pipeline_cache = file}).pipelineWork().loaded_bytes, 0u);
}

TEST_F(GpuTest, DeletesTemporaryCacheFilesOfKilledProcesses) {
    const test::TempFolder folder;
    const auto left = [&](const std::string& name) {
        std::ofstream(folder / name) << "half";
        std::filesystem::last_write_time(
            folder / name, std::filesystem::file_time_type::clock::now() - std::chrono::hours(2));
        return folder / name;
    };
    const auto old = left("pipelines.bin.1234567890"), other = left("window-pipelines.bin.1234567890");
    const Gpu gpu({.pipeline_cache = (folder / "pipelines.bin").string()});
    EXPECT_FALSE(std::filesystem::exists(old));
    EXPECT_TRUE(std::filesystem::exists(other));
}

// HZ-RECORD-14
TEST(PipelineCacheFile, DamagedFilesAreRejected) {
    const std::vector<std::uint8_t> driver{1, 2, 3, 4, 5};
    const std::vector<std::uint8_t> file = encodeCacheFile(driver);
    const auto found = decodeCacheFile(file);
    EXPECT_EQ(std::vector<std::uint8_t>(found.begin(), found.end()), driver);
    for (std::size_t size = 0; size < file.size(); ++size)
        EXPECT_TRUE(decodeCacheFile(std::span(file).first(size)).empty()) << size;
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
        std::vector<std::uint8_t> flipped = file;
        flipped[bit / 8] ^= std::uint8_t(1u << bit % 8);
        EXPECT_TRUE(decodeCacheFile(flipped).empty()) << bit;
    }
}

}  // namespace
}  // namespace stylet::render
