// Copies one eye of a rendered frame to the host, for viewers without a headset. The GPU scales the image
// down and copies it after the frame. Nothing waits for the copy.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "render/frame/renderer.h"
#include "render/gpu/gpu.h"

namespace stylet::render {

class EyeTap {
  public:
    explicit EyeTap(const Gpu&);
    // Waits for pending copies.
    ~EyeTap();
    EyeTap(const EyeTap&) = delete;
    EyeTap& operator=(const EyeTap&) = delete;

    // Submits a copy of one eye (0 left, 1 right) of a rendered target, scaled down so that neither edge
    // exceeds `max_pixels`. The image needs VK_IMAGE_USAGE_TRANSFER_SRC_BIT. Returns false and does
    // nothing while all copies are pending. read() returns `tag` with the copy. Allocates when the size
    // changes. Throws GpuError.
    bool submitCopy(const StereoTarget&, int eye, std::uint32_t max_pixels, std::uint64_t tag = 0);
    // Reads the newest copy that has finished since the last call and returns its tag, or nothing if there
    // is none.
    std::optional<std::uint64_t> read(Image&);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
