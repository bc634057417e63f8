// Flat pictures in the room: a swapchain each, shown as quad layers.
#pragma once

#include <deque>
#include <span>
#include <vector>

#include "xr/swapchain.h"

namespace stylet::xr {

class Panels {
  public:
    // The panel's id. Throws XrError.
    int add(XrSession, VkFormat, std::uint32_t width, std::uint32_t height);
    // Null for an id that add() did not give.
    Swapchain* find(int id);

    // Those of `shown` that are behind, or not, and have a picture. Their colours are straight: alpha is
    // multiplied in by the runtime.
    void quadsOf(std::span<const ShownPanel> shown, bool behind, XrSpace stage, XrSpace head,
                 std::vector<XrCompositionLayerQuad>& out) const;

  private:
    std::deque<Swapchain> panels_;
};

}  // namespace stylet::xr
