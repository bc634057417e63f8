#include "xr/swapchain.h"

#include <algorithm>
#include <array>

namespace stylet::xr {
namespace {

constexpr XrDuration kImageTimeout_ns = 1'000'000'000;

VkFormat chooseFormat(XrSession session) {
    const char* call = "xrEnumerateSwapchainFormats";
    std::uint32_t count = 0;
    check(xrEnumerateSwapchainFormats(session, 0, &count, nullptr), call,
          "the runtime names no picture formats");
    std::vector<std::int64_t> offered(count);
    check(xrEnumerateSwapchainFormats(session, count, &count, offered.data()), call,
          "the runtime names no picture formats");
    // sRGB, so that the renderer works in linear light and nothing looks washed out.
    for (const VkFormat wanted : {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB})
        if (std::find(offered.begin(), offered.end(), std::int64_t(wanted)) != offered.end()) return wanted;
    throw XrError("xrEnumerateSwapchainFormats: the runtime offers no 8-bit sRGB colour format");
}

}  // namespace

void Swapchain::create(XrInstance instance, XrSystemId system, XrSession session) {
    std::array<XrViewConfigurationView, 2> eyes{};
    eyes.fill({XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, 0, 0, 0, 0, 0, 0});
    std::uint32_t count = 0;
    check(xrEnumerateViewConfigurationViews(instance, system, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 2,
                                            &count, eyes.data()),
          "xrEnumerateViewConfigurationViews", "the headset does not show one picture for each of two eyes");
    auto limits = typed<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    check(xrGetSystemProperties(instance, system, &limits), "xrGetSystemProperties",
          "the headset was lost while it was being asked about");
    width_ = std::min(std::max(eyes[0].recommendedImageRectWidth, eyes[1].recommendedImageRectWidth),
                      limits.graphicsProperties.maxSwapchainImageWidth);
    height_ = std::min(std::max(eyes[0].recommendedImageRectHeight, eyes[1].recommendedImageRectHeight),
                       limits.graphicsProperties.maxSwapchainImageHeight);
    format_ = chooseFormat(session);

    auto info = typed<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT;
    info.format = std::int64_t(format_);
    info.sampleCount = 1;
    info.width = width_;
    info.height = height_;
    info.faceCount = 1;
    info.arraySize = 2;
    info.mipCount = 1;
    check(xrCreateSwapchain(session, &info, handle_.out()), "xrCreateSwapchain",
          "the runtime refuses images with a layer for each eye (" + std::to_string(width_) + " x " +
              std::to_string(height_) + " x 2), which this program draws into");

    const char* call = "xrEnumerateSwapchainImages";
    check(xrEnumerateSwapchainImages(handle_.get(), 0, &count, nullptr), call,
          "the runtime has no images to draw into");
    std::vector<XrSwapchainImageVulkan2KHR> images(
        count, {XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR, nullptr, VK_NULL_HANDLE});
    check(xrEnumerateSwapchainImages(handle_.get(), count, &count,
                                     reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data())),
          call, "the runtime has no images to draw into");
    for (const auto& image : images)
        images_.push_back(image.image);
}

XrResult Swapchain::acquire(bool& ready) {
    ready = false;
    if (!acquired_) {
        const XrSwapchainImageAcquireInfo info{XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO, nullptr};
        const XrResult result = xrAcquireSwapchainImage(handle_.get(), &info, &index_);
        if (XR_FAILED(result)) return result;
        acquired_ = true;
    }
    const XrSwapchainImageWaitInfo wait{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, kImageTimeout_ns};
    const XrResult result = xrWaitSwapchainImage(handle_.get(), &wait);
    ready_ = ready = XR_SUCCEEDED(result) && result != XR_TIMEOUT_EXPIRED;
    return result;
}

XrResult Swapchain::release() {
    const XrSwapchainImageReleaseInfo info{XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO, nullptr};
    acquired_ = ready_ = false;
    return xrReleaseSwapchainImage(handle_.get(), &info);
}

XrSwapchainSubImage Swapchain::subImage(std::uint32_t layer) const {
    return {handle_.get(), {{0, 0}, {std::int32_t(width_), std::int32_t(height_)}}, layer};
}

}  // namespace stylet::xr
