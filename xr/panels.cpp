#include "xr/panels.h"

#include "xr/pose.h"

namespace stylet::xr {

int Panels::add(XrSession session, VkFormat format, std::uint32_t width, std::uint32_t height) {
    Swapchain made;
    made.create(session, {format,
                          XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT |
                              XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT,
                          width, height, 1});
    panels_.push_back(std::move(made));
    return int(panels_.size()) - 1;
}

Swapchain* Panels::find(int id) {
    return id >= 0 && std::size_t(id) < panels_.size() ? &panels_[std::size_t(id)] : nullptr;
}

void Panels::writeQuads(std::span<const ShownPanel> shown, bool behind, XrSpace stage, XrSpace head,
                        std::vector<XrCompositionLayerQuad>& out) const {
    out.clear();
    for (const ShownPanel& panel : shown) {
        if (panel.behind != behind || panel.id < 0 || std::size_t(panel.id) >= panels_.size()) continue;
        const Swapchain& pictures = panels_[std::size_t(panel.id)];
        // The runtime would refuse the whole frame because of a layer without an image.
        if (!pictures.hasReleasedImage()) continue;
        auto quad = makeStruct<XrCompositionLayerQuad>(XR_TYPE_COMPOSITION_LAYER_QUAD);
        quad.layerFlags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT |
                          XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
        quad.space = panel.head_locked ? head : stage;
        quad.eyeVisibility = XR_EYE_VISIBILITY_BOTH;
        quad.subImage = pictures.subImage(0);
        quad.pose = toXrPose(panel.stage_from_panel);
        quad.size = {float(panel.width_m), float(panel.height_m)};
        out.push_back(quad);
    }
}

}  // namespace stylet::xr
