// Time of the first rendered picture, which ends the start-up.
#pragma once

#include "app/trainer/stores/start.h"
#include "render/gpu/gpu.h"

namespace stylet::trainer {

inline FirstPicture firstPicture(const render::Gpu& gpu) {
    const render::PipelineWork work = gpu.pipelineWork();
    return {std::chrono::steady_clock::now(), work.made, work.creation_ms, work.loaded_bytes};
}

}  // namespace stylet::trainer
