// Internal: converts Vulkan's exceptions to GpuError.
#pragma once

#include <utility>

#include "render/gpu/gpu.h"

namespace stylet::render {

template <typename F>
auto guarded(F&& f) {
    try {
        return std::forward<F>(f)();
    } catch (const vk::Error& e) {
        throw GpuError(e.what());
    }
}

}  // namespace stylet::render
