#include "app/trainer/pictures.h"

namespace stylet::trainer {

std::optional<Pictures> openPictures(const patient::Patient&, const patient::PlannedPath&,
                                     const PictureSettings&, std::string& why_not) {
    why_not = "this build has no Vulkan and OpenXR (STYLET_GPU=OFF)";
    return std::nullopt;
}

}  // namespace stylet::trainer
