#include <cmath>
#include <cstring>
#include <fstream>

// libstb has the functions; this header only declares them.
#include <stb/stb_image.h>

#include "client.h"

namespace mock_test {
namespace {

struct Picture {
    int width = 0, height = 0;
    std::vector<std::array<std::uint8_t, 3>> pixels;
    std::array<std::uint8_t, 3> at(int x, int y) const {
        return pixels[static_cast<std::size_t>(y * width + x)];
    }
};

Picture readPicture(const std::filesystem::path& path) {
    Picture picture;
    int channels = 0;
    stbi_uc* data = stbi_load(path.c_str(), &picture.width, &picture.height, &channels, 3);
    if (data == nullptr) return {};
    EXPECT_EQ(channels, 3);
    picture.pixels.resize(static_cast<std::size_t>(picture.width * picture.height));
    std::memcpy(picture.pixels.data(), data, picture.pixels.size() * 3);
    stbi_image_free(data);
    return picture;
}

using Colour = std::array<std::uint8_t, 4>;  // as stored

class Capture : public MockTest {
  protected:
    void SetUp() override {
        MockTest::SetUp();
        startFocused();
    }

    // Clears the left half of each layer to one colour and the right half to another.
    void draw(const Swapchain& swapchain, const std::vector<std::array<Colour, 2>>& layers) {
        const VkImage image = swapchain.images[acquireAndWait(swapchain.handle)];
        VkCommandPoolCreateInfo pool_info{};
        pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        pool_info.queueFamilyIndex = vk_queue_family_;
        VkCommandPool pool = VK_NULL_HANDLE;
        ASSERT_EQ(vkCreateCommandPool(vk_device_, &pool_info, nullptr, &pool), VK_SUCCESS);
        VkCommandBufferAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        allocate.commandPool = pool;
        allocate.commandBufferCount = 1;
        VkCommandBuffer commands = VK_NULL_HANDLE;
        ASSERT_EQ(vkAllocateCommandBuffers(vk_device_, &allocate, &commands), VK_SUCCESS);
        VkCommandBufferBeginInfo begin{};
        begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
        vkBeginCommandBuffer(commands, &begin);
        VkImageMemoryBarrier barrier{};
        barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
        barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        barrier.image = image;
        barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
        // Through a layout of our own and back: the runtime must hand images over in
        // COLOR_ATTACHMENT_OPTIMAL.
        move(commands, barrier, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
             VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        copyColours(commands, image, swapchain, layers);
        move(commands, barrier, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        vkEndCommandBuffer(commands);
        VkSubmitInfo submit{};
        submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &commands;
        ASSERT_EQ(vkQueueSubmit(vk_queue_, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
        ASSERT_EQ(xrReleaseSwapchainImage(swapchain.handle, nullptr), XR_SUCCESS);
        pools_.push_back(pool);
    }

    void TearDown() override {
        if (vk_device_ != VK_NULL_HANDLE) vkDeviceWaitIdle(vk_device_);
        for (VkCommandPool pool : pools_)
            vkDestroyCommandPool(vk_device_, pool, nullptr);
        if (staging_ != VK_NULL_HANDLE) {
            vkDestroyBuffer(vk_device_, staging_, nullptr);
            vkFreeMemory(vk_device_, staging_memory_, nullptr);
        }
        MockTest::TearDown();
    }

    // Submits the two given sub-images, each as the eye will see it.
    void submit(const XrSwapchainSubImage& left, const XrSwapchainSubImage& right) {
        auto state = structOf<XrFrameState>(XR_TYPE_FRAME_STATE);
        ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
        ASSERT_EQ(beginFrame(), XR_SUCCESS);
        const std::array<XrView, 2> eyes = locateViews(stage_, state.predictedDisplayTime);
        const std::array<XrCompositionLayerProjectionView, 2> views{
            XrCompositionLayerProjectionView{XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, eyes[0].pose,
                                             eyes[0].fov, left},
            XrCompositionLayerProjectionView{XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, eyes[1].pose,
                                             eyes[1].fov, right}};
        const XrCompositionLayerProjection layer{
            XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, stage_, 2, views.data()};
        ASSERT_EQ(endFrame(state.predictedDisplayTime,
                           {reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer)}),
                  XR_SUCCESS);
    }

    void label(const char* name) {
        const XrDebugUtilsLabelEXT info{XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, name};
        EXPECT_EQ(load<PFN_xrSessionInsertDebugUtilsLabelEXT>(instance_, "xrSessionInsertDebugUtilsLabelEXT")(
                      session_, &info),
                  XR_SUCCESS);
    }

  private:
    static void move(VkCommandBuffer commands, VkImageMemoryBarrier barrier, VkImageLayout from,
                     VkImageLayout to) {
        const bool back = to == VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        barrier.oldLayout = from;
        barrier.newLayout = to;
        barrier.srcAccessMask = back ? VK_ACCESS_TRANSFER_WRITE_BIT : 0;
        barrier.dstAccessMask = back ? 0 : VK_ACCESS_TRANSFER_WRITE_BIT;
        vkCmdPipelineBarrier(commands,
                             back ? VK_PIPELINE_STAGE_TRANSFER_BIT : VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                             back ? VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT : VK_PIPELINE_STAGE_TRANSFER_BIT, 0,
                             0, nullptr, 0, nullptr, 1, &barrier);
    }

    // Bytes go into the image unconverted, from a staging buffer.
    void copyColours(VkCommandBuffer commands, VkImage image, const Swapchain& swapchain,
                     const std::vector<std::array<Colour, 2>>& layers) {
        std::vector<std::uint8_t> bytes;
        for (const auto& halves : layers) {
            for (std::uint32_t i = 0; i < swapchain.width * swapchain.height; ++i) {
                const Colour& colour = halves[i % swapchain.width < swapchain.width / 2 ? 0 : 1];
                for (const float channel : colour)
                    bytes.push_back(static_cast<std::uint8_t>(channel));
            }
        }
        makeStaging(bytes);
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0,
                                   static_cast<std::uint32_t>(layers.size())};
        region.imageExtent = {swapchain.width, swapchain.height, 1};
        vkCmdCopyBufferToImage(commands, staging_, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    }

    void makeStaging(const std::vector<std::uint8_t>& bytes) {
        if (staging_ != VK_NULL_HANDLE) {
            vkDeviceWaitIdle(vk_device_);
            vkDestroyBuffer(vk_device_, staging_, nullptr);
            vkFreeMemory(vk_device_, staging_memory_, nullptr);
        }
        VkBufferCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
        info.size = bytes.size();
        info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
        ASSERT_EQ(vkCreateBuffer(vk_device_, &info, nullptr, &staging_), VK_SUCCESS);
        VkMemoryRequirements needs;
        vkGetBufferMemoryRequirements(vk_device_, staging_, &needs);
        VkPhysicalDeviceMemoryProperties memory;
        vkGetPhysicalDeviceMemoryProperties(vk_physical_device_, &memory);
        VkMemoryAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
        allocate.allocationSize = needs.size;
        constexpr VkMemoryPropertyFlags kHost =
            VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
        while ((memory.memoryTypes[allocate.memoryTypeIndex].propertyFlags & kHost) != kHost ||
               (needs.memoryTypeBits >> allocate.memoryTypeIndex & 1) == 0) {
            ++allocate.memoryTypeIndex;
        }
        ASSERT_EQ(vkAllocateMemory(vk_device_, &allocate, nullptr, &staging_memory_), VK_SUCCESS);
        ASSERT_EQ(vkBindBufferMemory(vk_device_, staging_, staging_memory_, 0), VK_SUCCESS);
        void* mapped = nullptr;
        ASSERT_EQ(vkMapMemory(vk_device_, staging_memory_, 0, VK_WHOLE_SIZE, 0, &mapped), VK_SUCCESS);
        std::memcpy(mapped, bytes.data(), bytes.size());
        vkUnmapMemory(vk_device_, staging_memory_);
    }

    std::vector<VkCommandPool> pools_;
    VkBuffer staging_ = VK_NULL_HANDLE;
    VkDeviceMemory staging_memory_ = VK_NULL_HANDLE;
};

constexpr Colour kA{10, 20, 30, 255}, kB{200, 100, 50, 0}, kC{1, 2, 3, 4}, kD{250, 251, 252, 253};
constexpr std::array<std::uint8_t, 3> kRgbA{10, 20, 30}, kRgbB{200, 100, 50}, kRgbC{1, 2, 3},
    kRgbD{250, 251, 252};

TEST_F(Capture, WritesBothLayersAsTheyAre) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    for (int i = 0; i < 5; ++i) {  // over every image of the swapchain, and one of them twice
        draw(swapchain, {{kA, kB}, {kC, kD}});
        label("capture:skin");
        submit({swapchain.handle, {{0, 0}, {64, 48}}, 0}, {swapchain.handle, {{0, 0}, {64, 48}}, 1});
        const Picture left = readPicture(file("skin_left.png"));
        const Picture right = readPicture(file("skin_right.png"));
        ASSERT_EQ(left.width, 64);
        ASSERT_EQ(left.height, 48);
        ASSERT_EQ(right.width, 64);
        for (int y = 0; y < 48; ++y) {
            for (int x = 0; x < 64; ++x) {
                ASSERT_EQ(left.at(x, y), x < 32 ? kRgbA : kRgbB);
                ASSERT_EQ(right.at(x, y), x < 32 ? kRgbC : kRgbD);
            }
        }
        std::filesystem::remove(file("skin_left.png"));
    }
}

TEST_F(Capture, HonoursTheRectangle) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.arraySize = 1;
    const Swapchain swapchain = createSwapchain(info);
    draw(swapchain, {{kA, kB}});
    label("capture:rect");
    submit({swapchain.handle, {{30, 7}, {4, 9}}, 0}, {swapchain.handle, {{63, 47}, {1, 1}}, 0});
    const Picture left = readPicture(file("rect_left.png"));
    ASSERT_EQ(left.width, 4);
    ASSERT_EQ(left.height, 9);
    EXPECT_EQ(left.at(1, 0), kRgbA);
    EXPECT_EQ(left.at(2, 8), kRgbB);
    const Picture right = readPicture(file("rect_right.png"));
    ASSERT_EQ(right.width, 1);
    EXPECT_EQ(right.at(0, 0), kRgbB);
}

TEST_F(Capture, PutsBlueWhereItBelongs) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.format = VK_FORMAT_B8G8R8A8_SRGB;
    const Swapchain swapchain = createSwapchain(info);
    draw(swapchain, {{kA, kB}, {kC, kD}});
    label("capture:bgr");
    submit({swapchain.handle, {{0, 0}, {64, 48}}, 0}, {swapchain.handle, {{0, 0}, {64, 48}}, 1});
    EXPECT_EQ(readPicture(file("bgr_left.png")).at(0, 0), (std::array<std::uint8_t, 3>{30, 20, 10}));
}

TEST_F(Capture, TakesTheNextFrameWithAProjectionAndOnlyThat) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    label("capture:later");
    frame();
    EXPECT_FALSE(std::filesystem::exists(file("later_left.png")));
    draw(swapchain, {{kA, kA}, {kA, kA}});
    submit(whole, whole);
    EXPECT_EQ(readPicture(file("later_left.png")).at(5, 5), kRgbA);
    draw(swapchain, {{kB, kB}, {kB, kB}});
    submit(whole, whole);
    EXPECT_EQ(readPicture(file("later_left.png")).at(5, 5), kRgbA);
}

TEST_F(Capture, RefusesNamesThatLeaveTheFolder) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    draw(swapchain, {{kA, kA}, {kA, kA}});
    for (const char* name : {"capture:../out", "capture:", "capture:.hidden", "capture:a b", "other:x"}) {
        label(name);
        submit(whole, whole);
    }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(file("")), {}), 0);
}

TEST_F(Capture, ThatCannotBeWrittenFailsNoFrame) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    draw(swapchain, {{kA, kA}, {kA, kA}});
    std::filesystem::create_directory(file("taken_left.png"));  // no picture can have this name
    label("capture:taken");
    submit(whole, whole);
    EXPECT_TRUE(std::filesystem::is_directory(file("taken_left.png")));
    label("capture:free");
    submit(whole, whole);
    EXPECT_EQ(readPicture(file("free_left.png")).at(0, 0), kRgbA);
}

TEST_F(Capture, CountsFramesAtTheEnd) {
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    draw(swapchain, {{kA, kA}, {kA, kA}});
    label("capture:one");
    const XrSwapchainSubImage whole{swapchain.handle, {{0, 0}, {64, 48}}, 0};
    submit(whole, whole);
    ASSERT_EQ(waitFrame(), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    ASSERT_EQ(waitFrame(), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_FRAME_DISCARDED);
    vkDeviceWaitIdle(vk_device_);
    ASSERT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
    instance_ = XR_NULL_HANDLE;
    std::stringstream text;
    text << std::ifstream(file("frames.json")).rdbuf();
    EXPECT_NE(text.str().find("\"submitted\": 4,"), std::string::npos) << text.str();
    EXPECT_NE(text.str().find("\"discarded\": 1,"), std::string::npos);
    EXPECT_NE(text.str().find("\"captured\": 1,"), std::string::npos);
}

}  // namespace
}  // namespace mock_test
