#include "xr/swapchain.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace stylet::xr {

std::vector<VkFormat> offeredFormats(XrSession session) {
    const auto offered =
        enumerate<std::int64_t>("xrEnumerateSwapchainFormats", "the runtime reports no image formats",
                                [&](auto... out) { return xrEnumerateSwapchainFormats(session, out...); });
    std::vector<VkFormat> formats;
    for (const std::int64_t format : offered)
        formats.push_back(VkFormat(format));
    return formats;
}

VkFormat chooseColourFormat(const std::vector<VkFormat>& offered) {
    for (const VkFormat wanted : {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_B8G8R8A8_SRGB})
        if (std::find(offered.begin(), offered.end(), wanted) != offered.end()) return wanted;
    throw XrError("xrEnumerateSwapchainFormats: the runtime offers no 8-bit sRGB colour format");
}

void Swapchain::create(XrSession session, const SwapchainSettings& settings) {
    auto info = makeStruct<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    info.usageFlags = settings.usage;
    info.format = std::int64_t(settings.format);
    info.sampleCount = 1;
    info.width = settings.width;
    info.height = settings.height;
    info.faceCount = 1;
    info.arraySize = settings.layers;
    info.mipCount = 1;
    Owned<XrSwapchain, xrDestroySwapchain> handle;
    check(xrCreateSwapchain(session, &info, handle.out()), "xrCreateSwapchain",
          fmt::format("the runtime refuses the images that this program draws into ({} x {} x {})",
                      settings.width, settings.height, settings.layers));

    const auto images = enumerate<XrSwapchainImageVulkan2KHR>(
        "xrEnumerateSwapchainImages", "the runtime has no images to draw into",
        [&](std::uint32_t capacity, std::uint32_t* count, XrSwapchainImageVulkan2KHR* out) {
            return xrEnumerateSwapchainImages(handle.get(), capacity, count,
                                              reinterpret_cast<XrSwapchainImageBaseHeader*>(out));
        },
        {XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR, nullptr, VK_NULL_HANDLE});
    handle_ = std::move(handle);
    images_.clear();
    for (const auto& image : images)
        images_.push_back(image.image);
    settings_ = settings;
    acquired_ = ready_ = released_ = false;
}

XrResult Swapchain::acquire(bool& ready, XrDuration timeout_ns) {
    ready = false;
    if (!acquired_) {
        const XrSwapchainImageAcquireInfo info{XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO, nullptr};
        const XrResult result = xrAcquireSwapchainImage(handle_.get(), &info, &index_);
        if (XR_FAILED(result)) return result;
        acquired_ = true;
    }
    const XrSwapchainImageWaitInfo wait{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, timeout_ns};
    const XrResult result = xrWaitSwapchainImage(handle_.get(), &wait);
    ready_ = ready = XR_SUCCEEDED(result) && result != XR_TIMEOUT_EXPIRED;
    return result;
}

XrResult Swapchain::release() {
    const XrSwapchainImageReleaseInfo info{XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO, nullptr};
    acquired_ = ready_ = false;
    const XrResult result = xrReleaseSwapchainImage(handle_.get(), &info);
    released_ = released_ || XR_SUCCEEDED(result);
    return result;
}

XrSwapchainSubImage Swapchain::subImage(std::uint32_t layer) const {
    return {handle_.get(), {{0, 0}, {std::int32_t(settings_.width), std::int32_t(settings_.height)}}, layer};
}

}  // namespace stylet::xr
