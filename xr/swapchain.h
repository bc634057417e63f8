// A swapchain, its images, and the image that is currently acquired.
#pragma once

#include <vector>

#include "xr/check.h"

namespace stylet::xr {

struct SwapchainSettings {
    VkFormat format = VK_FORMAT_UNDEFINED;
    XrSwapchainUsageFlags usage = 0;
    std::uint32_t width = 0, height = 0, layers = 1;
};

// Image formats that the runtime offers. Throws XrError if the runtime does not report them.
std::vector<VkFormat> offeredFormats(XrSession);
// Returns an 8-bit sRGB format, so that the renderer can work in linear light. Throws XrError if none is
// offered.
VkFormat chooseColourFormat(const std::vector<VkFormat>& offered);

class Swapchain {
  public:
    void create(XrSession, const SwapchainSettings&);  // throws XrError

    // `ready` is false if no image became free in time. The next call then continues to wait for the same
    // image.
    XrResult acquire(bool& ready, XrDuration timeout_ns);
    XrResult release();
    bool exists() const { return handle_.get() != XR_NULL_HANDLE; }
    bool isReady() const { return ready_; }
    bool hasReleasedImage() const { return released_; }  // an image has been released at least once
    VkImage image() const { return images_[index_]; }
    // The full area of array layer `layer`, in the image released last.
    XrSwapchainSubImage subImage(std::uint32_t layer) const;

    VkFormat format() const { return settings_.format; }

  private:
    Owned<XrSwapchain, xrDestroySwapchain> handle_;
    std::vector<VkImage> images_;
    SwapchainSettings settings_;
    std::uint32_t index_ = 0;
    bool acquired_ = false, ready_ = false, released_ = false;
};

}  // namespace stylet::xr
