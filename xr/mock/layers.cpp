#include "layers.h"

namespace xrmock {

namespace {

constexpr XrCompositionLayerFlags kLayerFlags = XR_COMPOSITION_LAYER_CORRECT_CHROMATIC_ABERRATION_BIT |
                                                XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT |
                                                XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;

SubImage checkSubImage(Call& call, const Session& session, const XrSwapchainSubImage& sub_image) {
    Swapchain& swapchain = call.live<Swapchain>(sub_image.swapchain);
    require(&swapchain.session == &session, XR_ERROR_LAYER_INVALID, "the swapchain is of another session");
    require(swapchain.last_released.has_value(), XR_ERROR_LAYER_INVALID,
            "no image of the swapchain was released yet");
    require(sub_image.imageArrayIndex < swapchain.images.layers, XR_ERROR_VALIDATION_FAILURE,
            "imageArrayIndex is beyond the swapchain's array");
    const XrRect2Di& rect = sub_image.imageRect;
    const auto inside = [](std::int64_t offset, std::int64_t extent, std::int64_t size) {
        return offset >= 0 && extent > 0 && offset + extent <= size;
    };
    require(inside(rect.offset.x, rect.extent.width, swapchain.images.width) &&
                inside(rect.offset.y, rect.extent.height, swapchain.images.height),
            XR_ERROR_SWAPCHAIN_RECT_INVALID, "imageRect is not inside the swapchain's images");
    return {&swapchain, *swapchain.last_released, rect, sub_image.imageArrayIndex};
}

void checkHeader(Call& call, const Session& session, const XrCompositionLayerBaseHeader& layer) {
    require((layer.layerFlags & ~kLayerFlags) == 0, XR_ERROR_VALIDATION_FAILURE,
            "layerFlags has unknown bits");
    require(&call.live<Space>(layer.space).session == &session, XR_ERROR_LAYER_INVALID,
            "the layer's space is of another session");
}

std::vector<SubImage> checkProjection(Call& call, const Session& session,
                                      const XrCompositionLayerProjection& layer) {
    require(layer.viewCount == 2, XR_ERROR_VALIDATION_FAILURE, "a projection layer has two views");
    require(layer.views != nullptr, XR_ERROR_VALIDATION_FAILURE, "views is null");
    std::vector<SubImage> eyes;
    for (std::uint32_t i = 0; i < layer.viewCount; ++i) {
        const XrCompositionLayerProjectionView& view = layer.views[i];
        requireStruct(&view, XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
        require(isValid(view.pose), XR_ERROR_POSE_INVALID,
                "a view's pose is not a unit quaternion and a finite point");
        eyes.push_back(checkSubImage(call, session, view.subImage));
    }
    return eyes;
}

void checkQuad(Call& call, const Session& session, const XrCompositionLayerQuad& quad) {
    require(quad.eyeVisibility >= XR_EYE_VISIBILITY_BOTH && quad.eyeVisibility <= XR_EYE_VISIBILITY_RIGHT,
            XR_ERROR_VALIDATION_FAILURE, "eyeVisibility is no known value");
    require(isValid(quad.pose), XR_ERROR_POSE_INVALID,
            "the quad's pose is not a unit quaternion and a finite point");
    checkSubImage(call, session, quad.subImage);
}

}  // namespace

std::vector<SubImage> checkLayers(Call& call, Session& session, const XrFrameEndInfo& frame) {
    require(frame.layerCount <= kMaxLayers, XR_ERROR_LAYER_LIMIT_EXCEEDED,
            "more layers than the system takes");
    require(frame.layerCount == 0 || frame.layers != nullptr, XR_ERROR_VALIDATION_FAILURE, "layers is null");
    std::vector<SubImage> eyes;
    for (std::uint32_t i = 0; i < frame.layerCount; ++i) {
        const XrCompositionLayerBaseHeader* layer = frame.layers[i];
        require(layer != nullptr, XR_ERROR_LAYER_INVALID, "a layer is null");
        switch (layer->type) {
            case XR_TYPE_COMPOSITION_LAYER_PROJECTION: {
                checkHeader(call, session, *layer);
                auto views = checkProjection(call, session,
                                             *reinterpret_cast<const XrCompositionLayerProjection*>(layer));
                if (eyes.empty()) eyes = std::move(views);
                break;
            }
            case XR_TYPE_COMPOSITION_LAYER_QUAD:
                checkHeader(call, session, *layer);
                checkQuad(call, session, *reinterpret_cast<const XrCompositionLayerQuad*>(layer));
                break;
            default:
                refuse(XR_ERROR_LAYER_INVALID, "a layer is of a type that no enabled extension has");
        }
    }
    return eyes;
}

}  // namespace xrmock
