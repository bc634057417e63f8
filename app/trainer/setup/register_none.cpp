#include "app/trainer/setup/register_view.h"

namespace stylet::trainer {

std::optional<RegisterView> openRegisterView(const RegisterViewSettings&, std::string& why_not) {
    why_not = "this build has no Vulkan and OpenXR (STYLET_GPU=OFF)";
    return std::nullopt;
}

}  // namespace stylet::trainer
