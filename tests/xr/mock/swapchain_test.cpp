#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

bool isDepth(std::int64_t format) {
    return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D16_UNORM ||
           format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
}

class SwapchainRules : public MockTest {
  protected:
    XrResult create(const XrSwapchainCreateInfo& info) {
        XrSwapchain swapchain = XR_NULL_HANDLE;
        const XrResult result = xrCreateSwapchain(session_, &info, &swapchain);
        EXPECT_EQ(swapchain != XR_NULL_HANDLE, result == XR_SUCCESS);
        return result;
    }
    XrResult acquire(XrSwapchain swapchain) {
        std::uint32_t index;
        return xrAcquireSwapchainImage(swapchain, nullptr, &index);
    }
    XrResult wait(XrSwapchain swapchain) {
        const XrSwapchainImageWaitInfo info{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, 0};
        return xrWaitSwapchainImage(swapchain, &info);
    }
};

TEST_F(SwapchainRules, PrefersSrgbAndHasDepth) {
    startSession();
    const std::vector<std::int64_t> formats = swapchainFormats();
    ASSERT_FALSE(formats.empty());
    EXPECT_EQ(formats[0], VK_FORMAT_R8G8B8A8_SRGB);
    for (const std::int64_t format : formats) {
        XrSwapchainCreateInfo info = swapchainInfo();
        info.format = format;
        if (isDepth(format)) info.usageFlags = XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
        cycle(createSwapchain(info).handle);
    }
    EXPECT_NE(std::find(formats.begin(), formats.end(), VK_FORMAT_D32_SFLOAT), formats.end());
}

TEST_F(SwapchainRules, RefusesUnsupportedSettings) {
    startSession();
    const XrSwapchainCreateInfo good = swapchainInfo();
    ASSERT_EQ(create(good), XR_SUCCESS);
    auto bad = good;
    bad.format = VK_FORMAT_R4G4_UNORM_PACK8;
    EXPECT_EQ(create(bad), XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED);
    bad.format = (std::int64_t{1} << 32) + VK_FORMAT_R8G8B8A8_SRGB;
    EXPECT_EQ(create(bad), XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED);
    for (auto member : {&XrSwapchainCreateInfo::width, &XrSwapchainCreateInfo::height,
                        &XrSwapchainCreateInfo::sampleCount, &XrSwapchainCreateInfo::arraySize,
                        &XrSwapchainCreateInfo::mipCount, &XrSwapchainCreateInfo::faceCount}) {
        bad = good;
        bad.*member = 0;
        EXPECT_EQ(create(bad), XR_ERROR_VALIDATION_FAILURE);
    }
    bad = good;
    bad.faceCount = 6;
    EXPECT_EQ(create(bad), XR_ERROR_FEATURE_UNSUPPORTED);
    for (const std::uint32_t samples : {3U, 8U, 1024U}) {
        bad = good;
        bad.sampleCount = samples;
        EXPECT_EQ(create(bad), XR_ERROR_FEATURE_UNSUPPORTED);
    }
    bad.sampleCount = 4;
    bad.mipCount = 2;
    EXPECT_EQ(create(bad), XR_ERROR_FEATURE_UNSUPPORTED);
    bad.mipCount = 1;
    bad.usageFlags |= XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT;
    EXPECT_EQ(create(bad), XR_ERROR_FEATURE_UNSUPPORTED);
    bad = good;
    bad.createFlags = XR_SWAPCHAIN_CREATE_PROTECTED_CONTENT_BIT;
    EXPECT_EQ(create(bad), XR_ERROR_FEATURE_UNSUPPORTED);
    bad = good;
    bad.usageFlags |= XrSwapchainUsageFlags{1} << 40;
    EXPECT_EQ(create(bad), XR_ERROR_VALIDATION_FAILURE);
    bad = good;
    bad.mipCount = 8;  // a 64 x 48 image has seven levels
    EXPECT_EQ(create(bad), XR_ERROR_VALIDATION_FAILURE);
    bad.mipCount = 7;
    EXPECT_EQ(create(bad), XR_SUCCESS);
}

// Tests every combination of format and usage, and acquires each image twice.
TEST_F(SwapchainRules, EveryFormatListsItsUsages) {
    startSession();
    const std::vector<std::int64_t> formats = swapchainFormats();
    constexpr XrSwapchainUsageFlags kColourUses[] = {
        XR_SWAPCHAIN_USAGE_SAMPLED_BIT, XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT,
        XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT, XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT,
        XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT};
    for (const std::int64_t format : formats) {
        const bool depth = isDepth(format);
        for (std::uint32_t mask = 0; mask < (depth ? 16U : 32U); ++mask) {
            XrSwapchainCreateInfo info = swapchainInfo();
            info.format = format;
            info.usageFlags = depth ? XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                    : XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
            for (std::uint32_t bit = 0; bit < 5; ++bit)
                if ((mask >> bit & 1) != 0) info.usageFlags |= kColourUses[bit];
            info.width = info.height = 8;
            info.arraySize = 1 + mask % 2;
            info.mipCount = depth ? 1 : 1 + mask % 2;
            info.createFlags = mask % 3 == 0 ? XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT : 0;
            const Swapchain swapchain = createSwapchain(info);
            const std::size_t turns = info.createFlags == 0 ? 2 * swapchain.images.size() : 1;
            for (std::size_t i = 0; i < turns; ++i)
                cycle(swapchain.handle);
            ASSERT_EQ(xrDestroySwapchain(swapchain.handle), XR_SUCCESS);
        }
    }
}

TEST_F(SwapchainRules, ImageEnumerationIsValidated) {
    startSession();
    const XrSwapchain swapchain = createSwapchain(swapchainInfo()).handle;
    std::uint32_t count = 0;
    std::vector<XrSwapchainImageVulkan2KHR> images(
        4, makeStruct<XrSwapchainImageVulkan2KHR>(XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR));
    auto* base = reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data());
    EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 1, &count, base), XR_ERROR_SIZE_INSUFFICIENT);
    EXPECT_EQ(count, 3U);
    EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 3, nullptr, base), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 3, &count, nullptr), XR_ERROR_VALIDATION_FAILURE);
    images[2].type = XR_TYPE_UNKNOWN;
    EXPECT_EQ(xrEnumerateSwapchainImages(swapchain, 3, &count, base), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(images[0].image, VkImage{VK_NULL_HANDLE});
    images[2].type = XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR;
    ASSERT_EQ(xrEnumerateSwapchainImages(swapchain, 4, &count, base), XR_SUCCESS);
    EXPECT_EQ(count, 3U);
    EXPECT_EQ(images[3].image, VkImage{VK_NULL_HANDLE});
    const VkImage first = images[0].image;
    ASSERT_EQ(xrEnumerateSwapchainImages(swapchain, 3, &count, base), XR_SUCCESS);
    EXPECT_EQ(images[0].image, first);  // unchanged for the swapchain's lifetime
}

TEST_F(SwapchainRules, ImagesAreAcquiredInTurn) {
    startSession();
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    ASSERT_EQ(swapchain.images.size(), 3U);
    EXPECT_EQ(wait(swapchain.handle), XR_ERROR_CALL_ORDER_INVALID);
    EXPECT_EQ(xrReleaseSwapchainImage(swapchain.handle, nullptr), XR_ERROR_CALL_ORDER_INVALID);
    for (std::size_t i = 0; i < swapchain.images.size(); ++i)
        ASSERT_EQ(acquire(swapchain.handle), XR_SUCCESS);
    EXPECT_EQ(acquire(swapchain.handle), XR_ERROR_CALL_ORDER_INVALID);
    EXPECT_EQ(xrReleaseSwapchainImage(swapchain.handle, nullptr), XR_ERROR_CALL_ORDER_INVALID);
    ASSERT_EQ(wait(swapchain.handle), XR_SUCCESS);
    EXPECT_EQ(wait(swapchain.handle), XR_ERROR_CALL_ORDER_INVALID);
    ASSERT_EQ(xrReleaseSwapchainImage(swapchain.handle, nullptr), XR_SUCCESS);
    ASSERT_EQ(wait(swapchain.handle), XR_SUCCESS);
    std::uint32_t index = 9;
    ASSERT_EQ(xrAcquireSwapchainImage(swapchain.handle, nullptr, &index), XR_SUCCESS);
    EXPECT_EQ(index, 0U);
}

TEST_F(SwapchainRules, AStaticImageIsAcquiredOnce) {
    startSession();
    XrSwapchainCreateInfo info = swapchainInfo();
    info.createFlags = XR_SWAPCHAIN_CREATE_STATIC_IMAGE_BIT;
    const Swapchain swapchain = createSwapchain(info);
    ASSERT_EQ(swapchain.images.size(), 1U);
    cycle(swapchain.handle);
    EXPECT_EQ(acquire(swapchain.handle), XR_ERROR_CALL_ORDER_INVALID);
}

class Layers : public MockTest {
  protected:
    void SetUp() override {
        MockTest::SetUp();
        startFocused();
        swapchain_ = createSwapchain(swapchainInfo());
        for (std::uint32_t eye = 0; eye < 2; ++eye) {
            views_[eye] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW,
                           nullptr,
                           kIdentity,
                           {-1, 1, 1, -1},
                           whole(swapchain_, eye)};
        }
        projection_ = {XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, stage_, 2, views_.data()};
        quad_ = {XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr,           0,         stage_,
                 XR_EYE_VISIBILITY_BOTH,         whole(swapchain_), kIdentity, {1, 1}};
    }
    XrResult submitProjection() { return tryFrame({header(projection_)}); }
    XrResult submitQuad() { return tryFrame({header(quad_)}); }

    Swapchain swapchain_;
    std::array<XrCompositionLayerProjectionView, 2> views_{};
    XrCompositionLayerProjection projection_{};
    XrCompositionLayerQuad quad_{};
};

TEST_F(Layers, NeedAReleasedImage) {
    EXPECT_EQ(submitProjection(), XR_ERROR_LAYER_INVALID);
    acquireAndWait(swapchain_.handle);
    EXPECT_EQ(submitProjection(), XR_ERROR_LAYER_INVALID);
    ASSERT_EQ(xrReleaseSwapchainImage(swapchain_.handle, nullptr), XR_SUCCESS);
    EXPECT_EQ(submitProjection(), XR_SUCCESS);
    EXPECT_EQ(submitQuad(), XR_SUCCESS);
}

TEST_F(Layers, AreCheckedOneByOne) {
    cycle(swapchain_.handle);
    const auto* quad = header(quad_);
    EXPECT_EQ(tryFrame(std::vector(16, quad)), XR_SUCCESS);
    EXPECT_EQ(tryFrame(std::vector(17, quad)), XR_ERROR_LAYER_LIMIT_EXCEEDED);
    EXPECT_EQ(tryFrame({nullptr}), XR_ERROR_LAYER_INVALID);
    quad_.type = XR_TYPE_COMPOSITION_LAYER_CUBE_KHR;
    EXPECT_EQ(submitQuad(), XR_ERROR_LAYER_INVALID);
    quad_.type = XR_TYPE_COMPOSITION_LAYER_QUAD;
    quad_.space = XR_NULL_HANDLE;
    EXPECT_EQ(submitQuad(), XR_ERROR_HANDLE_INVALID);
    quad_.space = stage_;
    quad_.eyeVisibility = static_cast<XrEyeVisibility>(5);
    EXPECT_EQ(submitQuad(), XR_ERROR_VALIDATION_FAILURE);
    quad_.eyeVisibility = XR_EYE_VISIBILITY_LEFT;
    quad_.pose.orientation.w = 0;
    EXPECT_EQ(submitQuad(), XR_ERROR_POSE_INVALID);
}

TEST_F(Layers, ProjectionViewsAreChecked) {
    cycle(swapchain_.handle);
    projection_.viewCount = 1;
    EXPECT_EQ(submitProjection(), XR_ERROR_VALIDATION_FAILURE);
    projection_.viewCount = 2;
    views_[1].pose.position.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(submitProjection(), XR_ERROR_POSE_INVALID);
    views_[1].pose = kIdentity;
    views_[1].subImage.imageArrayIndex = 2;
    EXPECT_EQ(submitProjection(), XR_ERROR_VALIDATION_FAILURE);
    views_[1].subImage = whole(swapchain_, 1);
    views_[1].subImage.swapchain = XR_NULL_HANDLE;
    EXPECT_EQ(submitProjection(), XR_ERROR_HANDLE_INVALID);
    views_[1].subImage = whole(swapchain_, 1);
    const XrRect2Di bad_rects[] = {{{-1, 0}, {10, 10}}, {{0, 0}, {65, 48}},
                                   {{1, 0}, {64, 48}},  {{0, 0}, {-1, 10}},
                                   {{0, 0}, {10, -1}},  {{2147483647, 0}, {2147483647, 1}}};
    for (const XrRect2Di& rect : bad_rects) {
        views_[1].subImage.imageRect = rect;
        EXPECT_EQ(submitProjection(), XR_ERROR_SWAPCHAIN_RECT_INVALID);
    }
    views_[1].subImage = whole(swapchain_, 1);
    EXPECT_EQ(submitProjection(), XR_SUCCESS);
}

// sRGB images do not support storage usage. The compositor's views must not inherit it.
TEST_F(Layers, ImagesWithEveryUseAreComposed) {
    XrSwapchainCreateInfo info = swapchainInfo();
    info.usageFlags |= XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT |
                       XR_SWAPCHAIN_USAGE_MUTABLE_FORMAT_BIT;
    swapchain_ = createSwapchain(info);
    cycle(swapchain_.handle);
    views_[0].subImage = whole(swapchain_);
    views_[1].subImage = whole(swapchain_, 1);
    const XrDebugUtilsLabelEXT label{XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, "capture:uses"};
    ASSERT_EQ(load<PFN_xrSessionInsertDebugUtilsLabelEXT>(instance_, "xrSessionInsertDebugUtilsLabelEXT")(
                  session_, &label),
              XR_SUCCESS);
    ASSERT_EQ(submitProjection(), XR_SUCCESS);
    EXPECT_TRUE(std::filesystem::exists(file("uses_left.png")));
    EXPECT_TRUE(std::filesystem::exists(file("uses_right.png")));
}

TEST_F(Layers, BlendModesAreChecked) {
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    XrFrameEndInfo info{XR_TYPE_FRAME_END_INFO,
                        nullptr,
                        state.predictedDisplayTime,
                        XR_ENVIRONMENT_BLEND_MODE_ADDITIVE,
                        0,
                        nullptr};
    EXPECT_EQ(xrEndFrame(session_, &info), XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED);
    info.environmentBlendMode = static_cast<XrEnvironmentBlendMode>(0);
    EXPECT_EQ(xrEndFrame(session_, &info), XR_ERROR_VALIDATION_FAILURE);
    info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    info.layerCount = 1;
    EXPECT_EQ(xrEndFrame(session_, &info), XR_ERROR_VALIDATION_FAILURE);
}

}  // namespace
}  // namespace mock_test
