// One colour swapchain with a layer per eye.
#pragma once

#include <vector>

#include "xr/check.h"

namespace stylet::xr {

class Swapchain {
  public:
    // Sized as the view configuration recommends, the larger of the two eyes, within the system's limits.
    void create(XrInstance, XrSystemId, XrSession);

    // False when no image came free in time: the frame is then submitted empty and the wait taken up again.
    XrResult acquire(bool& ready);
    XrResult release();
    bool held() const { return ready_; }
    VkImage image() const { return images_[index_]; }
    // Eye `layer` of the image, whole.
    XrSwapchainSubImage subImage(std::uint32_t layer) const;

    VkFormat format() const { return format_; }
    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }

  private:
    Owned<XrSwapchain, xrDestroySwapchain> handle_;
    std::vector<VkImage> images_;
    VkFormat format_ = VK_FORMAT_UNDEFINED;
    std::uint32_t width_ = 0, height_ = 0, index_ = 0;
    bool acquired_ = false, ready_ = false;
};

}  // namespace stylet::xr
