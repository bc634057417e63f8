#include "render/frame/eye_tap.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/gpu/memory.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kSide = 64;
constexpr auto kColour = vk::ImageAspectFlagBits::eColor;

// An image with one colour per eye, in the state of a swapchain image after drawing.
struct TwoEyes {
    explicit TwoEyes(const Gpu& gpu)
        : image(gpu, vk::Format::eR8G8B8A8Srgb, {kSide, kSide, 1}, 2,
                vk::ImageUsageFlagBits::eColorAttachment | vk::ImageUsageFlagBits::eTransferDst |
                    vk::ImageUsageFlagBits::eTransferSrc) {
        submitAndWait(gpu, [&](const vk::raii::CommandBuffer& commands) {
            const ImageState fresh{vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eNone, {}};
            const ImageState filling{vk::ImageLayout::eTransferDstOptimal,
                                     vk::PipelineStageFlagBits2::eTransfer,
                                     vk::AccessFlagBits2::eTransferWrite};
            const ImageState drawn{vk::ImageLayout::eColorAttachmentOptimal,
                                   vk::PipelineStageFlagBits2::eColorAttachmentOutput,
                                   vk::AccessFlagBits2::eColorAttachmentWrite};
            transition(commands, *image.handle, kColour, fresh, filling);
            const std::array<vk::ClearColorValue, 2> eyes{
                vk::ClearColorValue(std::array{1.0f, 0.0f, 0.0f, 1.0f}),
                vk::ClearColorValue(std::array{0.0f, 0.0f, 1.0f, 1.0f})};
            for (std::uint32_t eye = 0; eye < 2; ++eye)
                commands.clearColorImage(*image.handle, filling.layout, eyes[eye],
                                         vk::ImageSubresourceRange{kColour, 0, 1, eye, 1});
            transition(commands, *image.handle, kColour, filling, drawn);
        });
    }
    StereoTarget target() const { return {*image.handle, VK_FORMAT_R8G8B8A8_SRGB, kSide, kSide}; }
    GpuImage image;
};

// Waits until the GPU is idle, then reads.
std::optional<std::uint64_t> readOne(EyeTap& tap, Image& image, const Gpu& gpu) {
    gpu.device().waitIdle();
    return tap.read(image);
}

TEST(EyeTap, CopiesTheRequestedEyeScaledDownWithItsTag) {
    Gpu gpu{GpuSettings{.validation = true}};
    const TwoEyes eyes(gpu);
    EyeTap tap(gpu);
    Image image;
    EXPECT_FALSE(tap.read(image)) << "no copy was submitted";
    ASSERT_TRUE(tap.submitCopy(eyes.target(), 1, 32, 7));
    EXPECT_EQ(readOne(tap, image, gpu), 7u);
    ASSERT_EQ(image.width, 32u);
    ASSERT_EQ(image.height, 32u);
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        ASSERT_EQ(image.rgba[i], 0);
        ASSERT_EQ(image.rgba[i + 2], 255);
    }
    EXPECT_FALSE(tap.read(image)) << "the copy was already read";
    ASSERT_TRUE(tap.submitCopy(eyes.target(), 0, 1000, 8));
    EXPECT_EQ(readOne(tap, image, gpu), 8u);
    EXPECT_EQ(image.width, kSide) << "never enlarged";
    EXPECT_EQ(image.rgba[0], 255);
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

TEST(EyeTap, ReturnsTheNewestCopyAndDropsOlderOnes) {
    Gpu gpu{GpuSettings{.validation = true}};
    const TwoEyes eyes(gpu);
    EyeTap tap(gpu);
    Image image;
    for (std::uint64_t tag = 1; tag <= 6; ++tag) {
        ASSERT_TRUE(tap.submitCopy(eyes.target(), int(tag % 2), 16, tag));
        gpu.device().waitIdle();
    }
    EXPECT_EQ(tap.read(image), 6u);
    EXPECT_EQ(image.rgba[0], 255) << "the left eye";
    EXPECT_FALSE(tap.read(image));
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

// Requests more copies than fit. Some are dropped, the last accepted one arrives, and no error occurs.
TEST(EyeTap, DropsCopiesWhenAllArePending) {
    Gpu gpu{GpuSettings{.validation = true}};
    const TwoEyes eyes(gpu);
    EyeTap tap(gpu);
    int taken = 0;
    Image image;
    for (int i = 0; i < 200; ++i)
        taken += tap.submitCopy(eyes.target(), 0, kSide);
    EXPECT_GE(taken, 2);
    EXPECT_TRUE(readOne(tap, image, gpu));
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

}  // namespace
}  // namespace stylet::render
