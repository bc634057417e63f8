// For builds without Vulkan and OpenXR.
#include "app/trainer/setup/probe.h"
#include "app/trainer/setup/register_view.h"

namespace stylet::trainer {

void probeRuntime(const ProbeReport& report, std::chrono::milliseconds) {
    report.found({"headset", FindingState::warning, "this build has no OpenXR (STYLET_GPU=OFF)",
                  "build with Vulkan and the OpenXR loader to have pictures"});
}

void probeVulkan(const ProbeReport& report) {
    report.found({"graphics", FindingState::warning, "this build has no Vulkan (STYLET_GPU=OFF)",
                  "build with Vulkan and the OpenXR loader to have pictures"});
}

std::optional<RegisterView> openRegisterView(const RegisterViewSettings&, std::string& why_not) {
    why_not = "this build has no Vulkan and OpenXR (STYLET_GPU=OFF)";
    return std::nullopt;
}

}  // namespace stylet::trainer
