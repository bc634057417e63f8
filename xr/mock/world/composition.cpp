#include "world/composition.h"

#include <cmath>
#include <optional>

#include "world/spaces.h"

namespace xrmock {

namespace {

struct Eye {
    std::size_t index;
    Pose stage_from_eye;
    XrFovf fov;
};

std::array<float, 4> tangents(const XrFovf& fov) {
    return {std::tan(fov.angleLeft), std::tan(fov.angleRight), std::tan(fov.angleUp),
            std::tan(fov.angleDown)};
}

std::array<std::array<float, 4>, 3> rows(const Pose& a_from_b) {
    const auto& [x, y, z, w] = a_from_b.orientation;
    const double matrix[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                                 {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                                 {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    std::array<std::array<float, 4>, 3> result{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j)
            result[i][j] = static_cast<float>(matrix[i][j]);
        result[i][3] = static_cast<float>(a_from_b.position[i]);
    }
    return result;
}

bool isSeenBy(const SubmittedLayer& layer, std::size_t eye) {
    if (layer.type == LayerType::projection) return true;
    return layer.eyes == XR_EYE_VISIBILITY_BOTH ||
           layer.eyes == (eye == 0 ? XR_EYE_VISIBILITY_LEFT : XR_EYE_VISIBILITY_RIGHT);
}

std::array<float, 4> layerShape(const SubmittedLayer& layer, std::size_t eye) {
    switch (layer.type) {
        case LayerType::projection:
            return tangents(layer.views[eye].fov);
        case LayerType::quad:
            return {layer.quad_size_m.width, layer.quad_size_m.height, 0, 0};
        case LayerType::cylinder:
            break;
    }
    // Angle; height for a cylinder of radius 1; radius, or 0 for an infinite cylinder.
    const float angle_rad = layer.cylinder_angle_rad;
    const float radius_m = std::isinf(layer.cylinder_radius_m) ? 0.0F : layer.cylinder_radius_m;
    return {angle_rad, angle_rad / layer.cylinder_aspect_ratio, radius_m, 0};
}

const SubmittedImage& imageFor(const SubmittedLayer& layer, std::size_t eye) {
    return layer.type == LayerType::projection ? layer.views[eye].image : layer.image;
}

// Returns nullopt if the layer is not visible to this eye. A projection layer is rotated from the submitted
// orientation into the eye's orientation. The difference in position is ignored, because correcting it
// would require depth.
std::optional<PaintConstants> paintConstants(const SubmittedLayer& layer, const Eye& eye,
                                             VkExtent2D picture) {
    const SubmittedImage& image = imageFor(layer, eye.index);
    if (!layer.stage_from_space || !isSeenBy(layer, eye.index)) return std::nullopt;
    if (image.rect.extent.width == 0 || image.rect.extent.height == 0) return std::nullopt;
    const bool is_projection = layer.type == LayerType::projection;
    const Pose& space_from_layer =
        is_projection ? layer.views[eye.index].space_from_eye : layer.space_from_layer;
    const Pose layer_from_eye = inverse(*layer.stage_from_space * space_from_layer) * eye.stage_from_eye;

    PaintConstants constants{};
    constants.layer_from_eye = rows(layer_from_eye);
    constants.eye_tangents = tangents(eye.fov);
    constants.shape = layerShape(layer, eye.index);
    constants.rect = {image.rect.offset.x, image.rect.offset.y, image.rect.extent.width,
                      image.rect.extent.height};
    constants.picture_size = {static_cast<std::int32_t>(picture.width),
                              static_cast<std::int32_t>(picture.height)};
    constants.array_index = static_cast<std::int32_t>(image.array_index);
    if ((layer.flags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT) != 0) {
        constants.blending = kBlendAlpha;
        if ((layer.flags & XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT) != 0)
            constants.blending |= kMultiplyAlpha;
    }
    return constants;
}

VkExtent2D toExtent(const XrRect2Di& rect) {
    return {static_cast<std::uint32_t>(rect.extent.width), static_cast<std::uint32_t>(rect.extent.height)};
}

VkExtent2D pictureSize(const Scenario& scenario, const SubmittedFrame& frame, std::size_t eye) {
    for (const SubmittedLayer& layer : frame.layers) {
        if (layer.type != LayerType::projection) continue;
        const VkExtent2D extent = toExtent(layer.views[eye].image.rect);
        if (extent.width > 0 && extent.height > 0) return extent;
    }
    return {scenario.width, scenario.height};
}

// Blackens the pixels that the lens hides.
void lookThroughLens(Picture& picture, const LensOutline& lens, const XrFovf& fov) {
    const auto [left, right, up, down] = tangents(fov);
    const auto is_hidden = [&](double x, double y) {
        for (std::size_t i = 0; i < lens.size(); ++i) {
            const auto &a = lens[i], &b = lens[(i + 1) % lens.size()];
            if ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) < 0) return true;
        }
        return false;
    };
    for (std::uint32_t row = 0; row < picture.height; ++row) {
        for (std::uint32_t column = 0; column < picture.width; ++column) {
            const double x = left + (right - left) * (column + 0.5) / picture.width;
            const double y = up + (down - up) * (row + 0.5) / picture.height;
            std::uint8_t* pixel = &picture.rgba[(std::size_t{row} * picture.width + column) * 4];
            if (is_hidden(x, y)) pixel[0] = pixel[1] = pixel[2] = 0;
        }
    }
}

}  // namespace

Picture composeEye(Session& session, const SubmittedFrame& frame, std::size_t eye) {
    const Scenario& scenario = session.instance.scenario;
    const VkExtent2D size = pictureSize(scenario, frame, eye);
    const Eye viewer{eye, stageFromEyes(session.instance, frame.display_time)[eye], scenario.eye_fov[eye]};
    std::vector<Paint> paints;
    for (const SubmittedLayer& layer : frame.layers) {
        const SubmittedImage& image = imageFor(layer, eye);
        const SwapchainImages& images = image.swapchain->images;
        const auto constants = paintConstants(layer, viewer, size);
        if (!constants || isDepthFormat(images.format)) continue;
        paints.push_back({layer.type, &images, image.image, *constants});
    }
    Picture picture = session.compositor.paint(session.device, paints, size);
    if (scenario.pictures_through_lens) lookThroughLens(picture, scenario.lens[eye], viewer.fov);
    return picture;
}

}  // namespace xrmock
