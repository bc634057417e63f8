// A swapchain: its images, and which of them is the program's now.
#pragma once

#include <vector>

#include "xr/check.h"

namespace stylet::xr {

struct SwapchainWish {
    VkFormat format = VK_FORMAT_UNDEFINED;
    XrSwapchainUsageFlags usage = 0;
    std::uint32_t width = 0, height = 0, layers = 1;
};

// Of those offered; VK_FORMAT_UNDEFINED for none. Throws XrError where the runtime does not say.
std::vector<VkFormat> offeredFormats(XrSession);
// Throws XrError without a colour format that is encoded as sRGB, so that the renderer works in linear light.
VkFormat colourFormatOf(const std::vector<VkFormat>& offered);

class Swapchain {
  public:
    void create(XrSession, const SwapchainWish&);  // throws XrError

    // False when no image came free in time: the wait is taken up again next time.
    XrResult acquire(bool& ready, XrDuration timeout_ns);
    XrResult release();
    bool exists() const { return handle_.get() != XR_NULL_HANDLE; }
    bool held() const { return ready_; }
    bool shown() const { return released_; }  // an image was handed over at least once
    VkImage image() const { return images_[index_]; }
    // Layer `layer` of the image that was handed over last, whole.
    XrSwapchainSubImage subImage(std::uint32_t layer) const;

    VkFormat format() const { return wish_.format; }
    std::uint32_t width() const { return wish_.width; }
    std::uint32_t height() const { return wish_.height; }

  private:
    Owned<XrSwapchain, xrDestroySwapchain> handle_;
    std::vector<VkImage> images_;
    SwapchainWish wish_;
    std::uint32_t index_ = 0;
    bool acquired_ = false, ready_ = false, released_ = false;
};

}  // namespace stylet::xr
