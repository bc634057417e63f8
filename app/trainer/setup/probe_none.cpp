#include "app/trainer/setup/probe.h"

namespace stylet::trainer {

void probeRuntime(const ProbeReport& report, std::chrono::milliseconds) {
    report.found({"headset", FindingState::warning, "this build has no OpenXR (STYLET_GPU=OFF)",
                  "build with Vulkan and the OpenXR loader to have pictures"});
}

void probeVulkan(const ProbeReport& report) {
    report.found({"graphics", FindingState::warning, "this build has no Vulkan (STYLET_GPU=OFF)",
                  "build with Vulkan and the OpenXR loader to have pictures"});
}

}  // namespace stylet::trainer
