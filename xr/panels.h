// Flat images in the room. Each has its own swapchain and is shown as a quad layer.
#pragma once

#include <deque>
#include <span>
#include <vector>

#include "xr/swapchain.h"

namespace stylet::xr {

class Panels {
  public:
    // Returns the panel's id. Throws XrError.
    int add(XrSession, VkFormat, std::uint32_t width, std::uint32_t height);
    // Null for an id that add() did not return.
    Swapchain* find(int id);

    // Writes to `out` the quad layers of the panels in `shown` whose flag equals `behind` and that have an
    // image. Panel colours have straight alpha; the runtime multiplies it in.
    void writeQuads(std::span<const ShownPanel> shown, bool behind, XrSpace stage, XrSpace head,
                    std::vector<XrCompositionLayerQuad>& out) const;

  private:
    std::deque<Swapchain> panels_;
};

}  // namespace stylet::xr
