#include "app/trainer/view/pictures.h"

namespace stylet::trainer {

namespace {

constexpr const char* kWhyNot = "this build has no Vulkan and OpenXR (STYLET_GPU=OFF)";

}  // namespace

std::unique_ptr<Display> openPictures(const patient::Patient&, const patient::PlannedPath&,
                                      const PictureSettings&, std::string& why_not) {
    why_not = kWhyNot;
    return nullptr;
}

std::unique_ptr<Display> openDesktop(const patient::Patient&, const patient::PlannedPath&,
                                     const PictureSettings&, std::string& why_not) {
    why_not = kWhyNot;
    return nullptr;
}

std::optional<StereoView> openStereo(const patient::Patient&, const patient::PlannedPath&,
                                     const std::filesystem::path&, std::string& why_not) {
    why_not = kWhyNot;
    return std::nullopt;
}

std::optional<EquipmentView> openEquipment(const patient::Patient&, const std::filesystem::path&,
                                           std::string& why_not) {
    why_not = kWhyNot;
    return std::nullopt;
}

}  // namespace stylet::trainer
