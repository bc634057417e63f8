// XR_KHR_visibility_mask: the visible and hidden parts of an eye's field of view, as triangles and as a
// line loop.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scenario/openxr_api.h"
#include "scenario/scenario_events.h"

namespace xrmock {

using Corner = std::array<double, 2>;  // on the plane one metre in front of the eye, x right, y up

// The field of view, divided into convex counter-clockwise pieces. If the lens has no outline, there are no
// pieces, and the mask is unavailable.
struct VisibilityMask {
    std::vector<Corner> visible;              // also the line loop
    std::vector<std::vector<Corner>> hidden;  // without gaps or overlaps
};

// The outline must be convex and counter-clockwise.
VisibilityMask visibilityMask(const LensOutline& lens, const XrFovf& fov);

struct MaskMesh {
    std::vector<XrVector2f> vertices;
    std::vector<std::uint32_t> indices;
};
MaskMesh maskMesh(const VisibilityMask& mask, XrVisibilityMaskTypeKHR type);

}  // namespace xrmock
