// Converts line integrals to grey values on the GPU with screen.comp. The picture lies in host-visible
// memory.
#pragma once

#include <vector>

#include "render/fluoroscopy/fluoroscopy.h"
#include "render/gpu/descriptors.h"

namespace stylet::render {

class ScreenPass {
  public:
    explicit ScreenPass(const Gpu&);

    // Prepares for a picture of this size, computed from these line integrals.
    void prepare(const Buffer& paths, int pixels);
    // Sets the smoothed line integrals with which screen.comp evens out bright and dark parts of the picture.
    // `meter`: line integrals on a lattice of `side` x `side` cells (rows kMeter apart), < 0 behind the
    // blades.
    void setTone(std::span<const float> meter, int side);
    void record(const vk::raii::CommandBuffer&, const Exposure&, const Collimation&,
                const FluoroscopySettings&, std::int64_t pulse);
    void showBlack(int pixels);

    int pixels() const { return pixels_; }
    ScreenPicture picture() const;

  private:
    void reserve(int pixels);

    const Gpu* gpu_;
    Descriptors descriptors_;
    vk::raii::Pipeline pipeline_;
    Buffer uniforms_, slow_, picture_;
    vk::Buffer paths_;  // bound in the descriptors
    std::vector<float> smoothed_, scratch_;
    int pixels_ = 0, tone_side_ = 1;
    std::uint64_t revision_ = 0;
};

}  // namespace stylet::render
