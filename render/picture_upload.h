// Pictures on their way to images that somebody else made: the panels of a headset.
#pragma once

#include <cstdint>

#include "render/memory.h"

namespace stylet::render {

// Pictures on their way to images of four bytes a texel that somebody else made. Allocates nothing after it
// is made; waits for each.
class PictureUpload {
  public:
    PictureUpload(const Gpu&, vk::Extent2D);
    // Rows of R, G, B, A from the top; the image is in COLOR_ATTACHMENT_OPTIMAL before and after. Its format
    // is R8G8B8A8 or B8G8R8A8.
    void write(vk::Image, vk::Format, const std::uint8_t* rgba);

  private:
    vk::Extent2D extent_;
    Buffer staging_;
    Commands commands_;
};

}  // namespace stylet::render
