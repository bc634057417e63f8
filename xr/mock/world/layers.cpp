#include "world/layers.h"

#include <cmath>
#include <numbers>

#include "world/spaces.h"

namespace xrmock {

namespace {

constexpr XrCompositionLayerFlags kLayerFlags = XR_COMPOSITION_LAYER_CORRECT_CHROMATIC_ABERRATION_BIT |
                                                XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT |
                                                XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;

void requireFinite(float value, const char* reason) {
    requireValid(std::isfinite(value), reason);
}

SubmittedImage checkSubImage(Call& call, const Session& session, const XrSwapchainSubImage& sub_image) {
    const Swapchain& swapchain = call.live<Swapchain>(sub_image.swapchain);
    require(&swapchain.session == &session, XR_ERROR_LAYER_INVALID, "the swapchain is of another session");
    require(swapchain.last_released.has_value(), XR_ERROR_LAYER_INVALID,
            "no image of the swapchain was released yet");
    requireValid(sub_image.imageArrayIndex < swapchain.images.layers,
                 "imageArrayIndex is beyond the swapchain's array");
    const XrRect2Di& rect = sub_image.imageRect;
    // An empty rectangle is useless, but it is not an error.
    const auto inside = [](std::int64_t offset, std::int64_t extent, std::int64_t size) {
        return offset >= 0 && extent >= 0 && offset + extent <= size;
    };
    require(inside(rect.offset.x, rect.extent.width, swapchain.images.width) &&
                inside(rect.offset.y, rect.extent.height, swapchain.images.height),
            XR_ERROR_SWAPCHAIN_RECT_INVALID, "imageRect is not inside the swapchain's images");
    return {&swapchain, *swapchain.last_released, sub_image.imageArrayIndex, rect};
}

SubmittedLayer checkHeader(Call& call, const Session& session, const XrCompositionLayerBaseHeader& header,
                           LayerType type, XrTime display_time) {
    requireValid((header.layerFlags & ~kLayerFlags) == 0, "layerFlags has unknown bits");
    const Space& space = call.live<Space>(header.space);
    require(&space.session == &session, XR_ERROR_LAYER_INVALID, "the layer's space is of another session");
    SubmittedLayer layer;
    layer.type = type;
    layer.flags = header.layerFlags;
    layer.space = &space;
    layer.stage_from_space = stageFromSpace(space, display_time);
    return layer;
}

// Accepts near and far planes at zero: XR_KHR_composition_layer_depth forbids them, but its conformance test
// submits them.
SubmittedDepth checkDepth(Call& call, const Session& session, const XrCompositionLayerDepthInfoKHR& depth) {
    requireValid(depth.minDepth >= 0 && depth.minDepth < depth.maxDepth && depth.maxDepth <= 1,
                 "0 <= minDepth < maxDepth <= 1 does not hold");
    requireValid(depth.nearZ >= 0 && depth.farZ >= 0 && depth.nearZ != depth.farZ,
                 "nearZ and farZ must be two distances");
    return {checkSubImage(call, session, depth.subImage), depth.minDepth, depth.maxDepth, depth.nearZ,
            depth.farZ};
}

void checkProjection(Call& call, const Session& session, const XrCompositionLayerProjection& projection,
                     SubmittedLayer& layer) {
    requireValid(projection.viewCount == layer.views.size(), "a projection layer has two views");
    requireValid(projection.views != nullptr, "views is null");
    const bool with_depth =
        session.instance.extensions.contains(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME);
    for (std::size_t i = 0; i < layer.views.size(); ++i) {
        const XrCompositionLayerProjectionView& given = projection.views[i];
        SubmittedView& view = layer.views[i];
        requireStruct(&given, XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
        require(isValid(given.pose), XR_ERROR_POSE_INVALID,
                "a view's pose is not a unit quaternion and a finite point");
        for (const float angle :
             {given.fov.angleLeft, given.fov.angleRight, given.fov.angleUp, given.fov.angleDown})
            requireFinite(angle, "a view's field of view is not finite");
        view.space_from_eye = fromXr(given.pose);
        view.fov = given.fov;
        view.image = checkSubImage(call, session, given.subImage);
        const auto* depth =
            findInChain<XrCompositionLayerDepthInfoKHR>(given.next, XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR);
        if (with_depth && depth != nullptr) view.depth = checkDepth(call, session, *depth);
    }
}

template <class Surface>  // XrCompositionLayerQuad or XrCompositionLayerCylinderKHR
void checkSurface(Call& call, const Session& session, const Surface& surface, SubmittedLayer& layer) {
    requireValid(
        surface.eyeVisibility >= XR_EYE_VISIBILITY_BOTH && surface.eyeVisibility <= XR_EYE_VISIBILITY_RIGHT,
        "eyeVisibility is no known value");
    require(isValid(surface.pose), XR_ERROR_POSE_INVALID,
            "the layer's pose is not a unit quaternion and a finite point");
    layer.eyes = surface.eyeVisibility;
    layer.space_from_layer = fromXr(surface.pose);
    layer.image = checkSubImage(call, session, surface.subImage);
}

void checkQuad(Call& call, const Session& session, const XrCompositionLayerQuad& quad,
               SubmittedLayer& layer) {
    checkSurface(call, session, quad, layer);
    requireFinite(quad.size.width, "the quad's width is not finite");
    requireFinite(quad.size.height, "the quad's height is not finite");
    layer.quad_size_m = quad.size;
}

void checkCylinder(Call& call, const Session& session, const XrCompositionLayerCylinderKHR& cylinder,
                   SubmittedLayer& layer) {
    checkSurface(call, session, cylinder, layer);
    requireValid(cylinder.radius >= 0, "the radius is negative");
    requireValid(cylinder.centralAngle >= 0 && cylinder.centralAngle < 2 * std::numbers::pi_v<float>,
                 "centralAngle is not from 0 to less than a full turn");
    requireValid(cylinder.aspectRatio > 0 && std::isfinite(cylinder.aspectRatio),
                 "aspectRatio is not greater than zero");
    layer.cylinder_radius_m = cylinder.radius;
    layer.cylinder_angle_rad = cylinder.centralAngle;
    layer.cylinder_aspect_ratio = cylinder.aspectRatio;
}

SubmittedLayer checkLayer(Call& call, const Session& session, const XrCompositionLayerBaseHeader& header,
                          XrTime display_time) {
    const auto checked = [&](LayerType type) {
        return checkHeader(call, session, header, type, display_time);
    };
    const auto& extensions = session.instance.extensions;
    if (header.type == XR_TYPE_COMPOSITION_LAYER_PROJECTION) {
        SubmittedLayer layer = checked(LayerType::projection);
        checkProjection(call, session, reinterpret_cast<const XrCompositionLayerProjection&>(header), layer);
        return layer;
    }
    if (header.type == XR_TYPE_COMPOSITION_LAYER_QUAD) {
        SubmittedLayer layer = checked(LayerType::quad);
        checkQuad(call, session, reinterpret_cast<const XrCompositionLayerQuad&>(header), layer);
        return layer;
    }
    require(header.type == XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR &&
                extensions.contains(XR_KHR_COMPOSITION_LAYER_CYLINDER_EXTENSION_NAME),
            XR_ERROR_LAYER_INVALID, "a layer is of a type that no enabled extension has");
    SubmittedLayer layer = checked(LayerType::cylinder);
    checkCylinder(call, session, reinterpret_cast<const XrCompositionLayerCylinderKHR&>(header), layer);
    return layer;
}

}  // namespace

SubmittedFrame checkFrame(Call& call, Session& session, const XrFrameEndInfo& info) {
    require(info.layerCount <= kMaxLayers, XR_ERROR_LAYER_LIMIT_EXCEEDED,
            "more layers than the system takes");
    requireValid(info.layerCount == 0 || info.layers != nullptr, "layers is null");
    SubmittedFrame frame{session.frames_submitted + 1, info.displayTime, info.environmentBlendMode, {}};
    frame.layers.reserve(info.layerCount);
    for (std::uint32_t i = 0; i < info.layerCount; ++i) {
        require(info.layers[i] != nullptr, XR_ERROR_LAYER_INVALID, "a layer is null");
        frame.layers.push_back(checkLayer(call, session, *info.layers[i], info.displayTime));
    }
    return frame;
}

}  // namespace xrmock
