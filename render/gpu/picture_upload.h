// Uploads pictures from the host to images that the OpenXR runtime owns: the panels in the headset.
#pragma once

#include <cstdint>

#include "render/gpu/memory.h"

namespace stylet::render {

// Allocates only in its constructor. write() waits for the upload.
class PictureUpload {
  public:
    PictureUpload(const Gpu&, vk::Extent2D);
    // `rgba`: rows from the top, four bytes (R, G, B, A) per pixel. The image's format is R8G8B8A8 or
    // B8G8R8A8. It is in COLOR_ATTACHMENT_OPTIMAL before and after.
    void write(vk::Image, vk::Format, const std::uint8_t* rgba);

  private:
    vk::Extent2D extent_;
    Buffer staging_;
    Commands commands_;
};

}  // namespace stylet::render
