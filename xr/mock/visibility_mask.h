// XR_KHR_visibility_mask: what an eye's lens shows of its field of view, as triangles and as a line.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "openxr_api.h"
#include "scenario_events.h"

namespace xrmock {

using Corner = std::array<double, 2>;  // on the plane one metre in front of the eye, x right, y up

// The field of view in convex pieces, all counter-clockwise. All empty when the lens has no outline, and the
// mask is not available.
struct VisibilityMask {
    std::vector<Corner> visible;              // also the line loop
    std::vector<std::vector<Corner>> hidden;  // without gaps and overlaps
};

// The outline is convex and counter-clockwise.
VisibilityMask visibilityMask(const LensOutline& lens, const XrFovf& fov);

struct MaskMesh {
    std::vector<XrVector2f> vertices;
    std::vector<std::uint32_t> indices;
};
MaskMesh maskMesh(const VisibilityMask& mask, XrVisibilityMaskTypeKHR type);

}  // namespace xrmock
