// A validated frame as submitted to xrEndFrame, for the log, the assertions and the compositor. Pointers
// are valid during the call only.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "world/objects.h"

namespace xrmock {

// A part of the swapchain's last released image. Format and size are in `swapchain->images`.
struct SubmittedImage {
    const Swapchain* swapchain = nullptr;
    std::uint32_t image = 0;        // index into swapchain->images.images
    std::uint32_t array_index = 0;  // layer of the image
    XrRect2Di rect{};               // pixels, from the top left
};

// XR_KHR_composition_layer_depth. Depth is reversed if near_z is greater than far_z; either may be
// infinite.
struct SubmittedDepth {
    SubmittedImage image;
    float min_depth = 0, max_depth = 1;  // range of the values in the image
    float near_z_m = 0, far_z_m = 0;
};

// One eye of a projection layer.
struct SubmittedView {
    Pose space_from_eye;
    XrFovf fov{};  // radians
    SubmittedImage image;
    std::optional<SubmittedDepth> depth;
};

struct SubmittedLayer {
    LayerType type = LayerType::projection;
    XrCompositionLayerFlags flags = 0;
    const Space* space = nullptr;
    std::optional<Pose> stage_from_space;  // at the display time; nullopt: cannot be located, layer not shown

    std::array<SubmittedView, 2> views;  // projection: left, right

    // Quad and cylinder only. A field named after one of the types belongs to this type only.
    XrEyeVisibility eyes = XR_EYE_VISIBILITY_BOTH;
    SubmittedImage image;
    Pose space_from_layer;
    XrExtent2Df quad_size_m{};
    float cylinder_radius_m = 0;  // 0 or infinity: an infinite cylinder, where only directions matter
    float cylinder_angle_rad = 0;
    float cylinder_aspect_ratio = 0;  // width along the arc / height
};

struct SubmittedFrame {
    std::uint64_t number = 0;  // within the session, starting at 1
    XrTime display_time = 0;
    XrEnvironmentBlendMode blend_mode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    std::vector<SubmittedLayer> layers;  // in painting order
};

}  // namespace xrmock
