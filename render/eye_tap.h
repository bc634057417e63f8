// One eye of what was drawn, on its way to somebody without a headset: scaled down by the GPU and copied to
// the host behind the frame. Nobody waits for it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "render/gpu.h"
#include "render/renderer.h"

namespace stylet::render {

class EyeTap {
  public:
    explicit EyeTap(const Gpu&);
    // Waits for copies under way.
    ~EyeTap();
    EyeTap(const EyeTap&) = delete;
    EyeTap& operator=(const EyeTap&) = delete;

    // Submits the copy of an eye (0 left, 1 right) of a target that was drawn: no longer than `most_pixels`
    // along either edge. The image needs VK_IMAGE_USAGE_TRANSFER_SRC_BIT. False, and nothing happens, while
    // all copies are under way. `tag` comes back with the copy. Allocates when the size changes. Throws
    // GpuError.
    bool take(const StereoTarget&, int eye, std::uint32_t most_pixels, std::uint64_t tag = 0);
    // The newest copy that has come since the last call, with its tag; nothing: none has.
    std::optional<std::uint64_t> read(Image&);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
