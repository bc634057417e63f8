// Swapchains with several samples per pixel or more than 8 bits per channel. The composed picture shows the
// resolved samples, encoded as 8-bit sRGB.
#include "tests/xr/mock/client/pictures.h"

namespace mock_test {
namespace {

class SwapchainKinds : public PictureTest {
  protected:
    void SetUp() override {
        PictureTest::SetUp();
        startFocused();
    }
    void TearDown() override {
        if (pool_ != VK_NULL_HANDLE) vkDestroyCommandPool(vk_device_, pool_, nullptr);
        PictureTest::TearDown();
    }
    // Clears each layer of the next image to its linear colour.
    void fill(const Swapchain& swapchain, const std::vector<VkClearColorValue>& colours) {
        const VkImage image = swapchain.images[acquireAndWait(swapchain.handle)];
        const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0,
                                                vk_queue_family_};
        ASSERT_EQ(vkCreateCommandPool(vk_device_, &pool_info, nullptr, &pool_), VK_SUCCESS);
        const VkCommandBufferAllocateInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool_,
                                               VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        VkCommandBuffer commands = VK_NULL_HANDLE;
        ASSERT_EQ(vkAllocateCommandBuffers(vk_device_, &info, &commands), VK_SUCCESS);
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                             VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, nullptr};
        ASSERT_EQ(vkBeginCommandBuffer(commands, &begin), VK_SUCCESS);
        turn(commands, image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        for (std::uint32_t layer = 0; layer < colours.size(); ++layer) {
            const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, layer, 1};
            vkCmdClearColorImage(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &colours[layer], 1,
                                 &range);
        }
        turn(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
        ASSERT_EQ(vkEndCommandBuffer(commands), VK_SUCCESS);
        VkSubmitInfo submit{};
        submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &commands;
        ASSERT_EQ(vkQueueSubmit(vk_queue_, 1, &submit, VK_NULL_HANDLE), VK_SUCCESS);
        EXPECT_EQ(xrReleaseSwapchainImage(swapchain.handle, nullptr), XR_SUCCESS);
    }
    static void turn(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to) {
        const VkImageMemoryBarrier barrier{
            VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
            nullptr,
            VK_ACCESS_MEMORY_WRITE_BIT,
            VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
            from,
            to,
            VK_QUEUE_FAMILY_IGNORED,
            VK_QUEUE_FAMILY_IGNORED,
            image,
            {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS}};
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                             0, 0, nullptr, 0, nullptr, 1, &barrier);
    }
    VkCommandPool pool_ = VK_NULL_HANDLE;
};

TEST_F(SwapchainKinds, EveryFormatMayBeMultisampled) {
    std::array<XrViewConfigurationView, 2> views{};
    views.fill({XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, 0, 0, 0, 0, 0, 0});
    std::uint32_t count = 0;
    ASSERT_EQ(xrEnumerateViewConfigurationViews(instance_, system_, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                                                2, &count, views.data()),
              XR_SUCCESS);
    EXPECT_EQ(views[0].recommendedSwapchainSampleCount, 1U);
    ASSERT_EQ(views[0].maxSwapchainSampleCount, 4U);
    const std::vector<std::int64_t> formats = swapchainFormats();
    for (const std::int64_t format : formats) {
        XrSwapchainCreateInfo info = swapchainInfo();
        info.format = format;
        info.sampleCount = 4;
        const bool is_colour = format < VK_FORMAT_D16_UNORM;
        info.usageFlags = is_colour ? XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT
                                    : XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
        const Swapchain swapchain = createSwapchain(info);
        for (int i = 0; i < 4; ++i)
            cycle(swapchain.handle);
    }
}

TEST_F(SwapchainKinds, HalfFloatsAreLinear) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.format = VK_FORMAT_R16G16B16A16_SFLOAT;
    const Swapchain swapchain = createSwapchain(info);
    fill(swapchain, {{{0.2140411F, 1.5F, 0, 1}}, {{0, 0, 1, 1}}});  // 127.5 in sRGB is 0.2140411 linear
    label("capture:half");
    projectionFrame(whole(swapchain), whole(swapchain, 1));
    const Picture left = readPicture(file("half_left.png"));
    ASSERT_EQ(left.width, 64);
    EXPECT_NEAR(left.at(3, 3)[0], 127.5, 1);
    EXPECT_EQ(left.at(3, 3)[1], 255);
    EXPECT_EQ(readPicture(file("half_right.png")).at(3, 3), (Rgb{0, 0, 255}));
}

TEST_F(SwapchainKinds, SamplesAreShownResolved) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.sampleCount = 4;
    const Swapchain swapchain = createSwapchain(info);
    fill(swapchain, {{{1, 0, 0, 1}}, {{0, 1, 1, 1}}});
    label("capture:samples");
    projectionFrame(whole(swapchain), whole(swapchain, 1));
    const Picture left = readPicture(file("samples_left.png"));
    const Picture right = readPicture(file("samples_right.png"));
    ASSERT_EQ(left.width, 64);
    ASSERT_EQ(right.height, 48);
    EXPECT_EQ(left.at(20, 30), (Rgb{255, 0, 0}));
    EXPECT_EQ(right.at(63, 47), (Rgb{0, 255, 255}));
    cycle(swapchain.handle);  // the runtime restored the layout
}

}  // namespace
}  // namespace mock_test
