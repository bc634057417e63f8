#include "world/visibility_mask.h"

#include <cmath>

namespace xrmock {

namespace {

using Polygon = std::vector<Corner>;

// Twice the signed area of the triangle; positive if c is to the left of the line from a to b.
double turn(const Corner& a, const Corner& b, const Corner& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double twiceArea(const Polygon& polygon) {
    double sum = 0;
    for (std::size_t i = 2; i < polygon.size(); ++i)
        sum += turn(polygon[0], polygon[i - 1], polygon[i]);
    return sum;
}

// Returns the part of a convex polygon to the left (side 1) or right (side -1) of a line.
Polygon cutPolygon(const Polygon& polygon, const Corner& from, const Corner& to, double side) {
    Polygon part;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double at_a = side * turn(from, to, a), at_b = side * turn(from, to, b);
        if (at_a >= 0) part.push_back(a);
        if ((at_a > 0 && at_b < 0) || (at_a < 0 && at_b > 0)) {
            const double share = at_a / (at_a - at_b);
            part.push_back({a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])});
        }
    }
    return part;
}

void addFan(const Polygon& polygon, MaskMesh& mesh) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Corner& corner : polygon)
        mesh.vertices.push_back({static_cast<float>(corner[0]), static_cast<float>(corner[1])});
    for (std::uint32_t i = 2; i < polygon.size(); ++i)
        mesh.indices.insert(mesh.indices.end(), {first, first + i - 1, first + i});
}

}  // namespace

VisibilityMask visibilityMask(const LensOutline& lens, const XrFovf& fov) {
    if (lens.empty()) return {};
    constexpr double kNothing = 1e-9;  // area, in squared tangents
    const double left = std::tan(double{fov.angleLeft}), right = std::tan(double{fov.angleRight});
    const double up = std::tan(double{fov.angleUp}), down = std::tan(double{fov.angleDown});
    VisibilityMask mask{{{left, down}, {right, down}, {right, up}, {left, up}}, {}};
    // Each edge of the lens cuts a piece off the part still visible.
    for (std::size_t i = 0; i < lens.size(); ++i) {
        const Corner &from = lens[i], &to = lens[(i + 1) % lens.size()];
        Polygon off = cutPolygon(mask.visible, from, to, -1);
        if (twiceArea(off) < kNothing) continue;
        mask.hidden.push_back(std::move(off));
        mask.visible = cutPolygon(mask.visible, from, to, 1);
    }
    return mask;
}

MaskMesh maskMesh(const VisibilityMask& mask, XrVisibilityMaskTypeKHR type) {
    MaskMesh mesh;
    if (type == XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR) {
        for (const Polygon& piece : mask.hidden)
            addFan(piece, mesh);
        return mesh;
    }
    addFan(mask.visible, mesh);
    if (type == XR_VISIBILITY_MASK_TYPE_LINE_LOOP_KHR) {
        mesh.indices.clear();
        for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i)
            mesh.indices.push_back(i);
    }
    return mesh;
}

}  // namespace xrmock
