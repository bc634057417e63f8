#include "tests/render/volume/march_reference.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "render/volume/march_shared.h"

namespace stylet::test {
namespace {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using namespace render;

// Thresholds and light are part of the look's definition, so the reference uses those of the march.
const dvec3 kKey(gpu::kKeyColour), kSky(gpu::kSkyColour), kGround(gpu::kGroundColour);

// Stored colour at a point between voxels, 0 to 1. Transparent outside the volume.
dvec4 storedAt(const MarchCase& c, const dvec3& v) {
    const dvec3 low = glm::floor(v), f = v - low;
    dvec4 sum(0.0);
    for (int corner = 0; corner < 8; ++corner) {
        const dvec3 side(corner & 1, (corner >> 1) & 1, corner >> 2);
        const Index3 i(low + side);
        if (!c.grid.contains(i)) continue;
        const dvec3 w = side * f + (1.0 - side) * (1.0 - f);
        const std::byte* texel = c.rgba.data() + 4 * c.grid.offset(i);
        for (int k = 0; k < 4; ++k)
            sum[k] += w.x * w.y * w.z * double(std::to_integer<int>(texel[k])) / 255.0;
    }
    return sum;
}

dvec3 slopeAt(const MarchCase& c, const dvec3& v) {
    const double reach = double(c.look.gradient_voxels);
    const dvec3 s = c.grid.spacing_m;
    dvec3 slope;
    for (int axis = 0; axis < 3; ++axis) {
        dvec3 d(0.0);
        d[axis] = reach;
        slope[axis] = (storedAt(c, v + d).a - storedAt(c, v - d).a) / (2.0 * reach) *
                      std::min({s.x, s.y, s.z}) / s[axis];
    }
    return slope;
}

double smooth(double a, double b, double x) {
    const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

dvec3 ambient(double up) {
    return glm::mix(kGround, kSky, 0.5 + 0.5 * up);
}

dvec3 flatLight(const gpu::FrameUniforms& frame) {
    return ambient(0.0) + double(gpu::kWeakKey) * kKey * double(frame.key_patient.w);
}

dvec3 litLight(const MarchCase& c, const gpu::FrameUniforms& frame, const dvec3& albedo, const dvec3& v,
               const dvec3& to_eye) {
    const dvec3 slope = slopeAt(c, v);
    const double steepness = glm::length(slope);
    dvec3 n = -slope / std::max(steepness, 1e-6);
    const double facing = glm::dot(n, to_eye);
    if (facing < double(gpu::kTurnedAway))
        n = -n;
    else if (facing < 0.0)
        n = glm::normalize(n - facing * to_eye);
    const dvec3 key_direction(frame.key_patient), key = kKey * double(frame.key_patient.w);
    const double wrap = double(c.look.wrap), nl = glm::dot(n, key_direction);
    const double lit = std::max((nl + wrap) / (1.0 + wrap), 0.0);
    const dvec3 half = glm::normalize(key_direction + to_eye);
    const double shine = double(c.look.specular) *
                         std::pow(std::max(glm::dot(n, half), 0.0), double(c.look.specular_power)) *
                         std::max(nl, 0.0);
    const double rim = double(c.look.rim) * std::pow(1.0 - std::max(glm::dot(n, to_eye), 0.0), 3.0);
    const dvec3 grazing =
        glm::mix(dvec3(c.look.grazing_tint), dvec3(1.0), smooth(0.0, double(gpu::kGrazingLight), lit));
    const dvec3 full = albedo * (ambient(glm::dot(n, dvec3(frame.up_patient))) + key * lit * grazing) +
                       key * shine + kSky * rim;
    return glm::mix(albedo * flatLight(frame), full, smooth(0.0, double(gpu::kSurface), steepness));
}

dvec4 finished(const ReferenceRay& ray) {
    dvec3 c = ray.light / std::max(ray.opacity, 1e-4);
    for (int i = 0; i < 3; ++i)
        if (c[i] > 0.6) c[i] = 0.6 + 0.4 * (c[i] - 0.6) / (c[i] - 0.6 + 0.4);
    return {c * ray.opacity, ray.opacity};
}

}  // namespace

ReferenceRay referenceRay(const MarchCase& c, const gpu::FrameUniforms& frame, int eye, const dvec2& at,
                          const ReferenceSettings& settings) {
    const gpu::EyeUniforms& e = frame.eyes[eye];
    const dvec4 tangents(e.tangents);
    const dvec3 in_eye(glm::mix(tangents.x, tangents.y, at.x), glm::mix(tangents.z, tangents.w, at.y), -1.0);
    const dmat4 patient_from_eye(e.patient_from_eye);
    const dvec3 origin_m(patient_from_eye[3]), ray_m = glm::dmat3(patient_from_eye) * in_eye;
    const double metres = glm::length(ray_m);
    const dvec3 to_eye = -ray_m / metres, s = c.grid.spacing_m;
    const double finest_m = std::min({s.x, s.y, s.z}), step = settings.step_voxels * finest_m / metres;
    const double full_per_m = c.look.full_extinction_per_m;
    double enter = double(frame.target.z), leave = std::min(double(frame.target.w), settings.mesh_depth_m);
    for (int axis = 0; axis < 3; ++axis) {
        const double low = c.grid.origin_m[axis] - 0.5 * s[axis],
                     high = low + s[axis] * double(c.grid.dims[axis]);
        if (ray_m[axis] == 0.0) continue;
        const double a = (low - origin_m[axis]) / ray_m[axis], b = (high - origin_m[axis]) / ray_m[axis];
        enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
    }
    ReferenceRay ray;
    double clear = 1.0;
    for (double t = enter + 0.5 * step; t < leave; t += step) {
        const dvec3 deformed_m = origin_m + t * ray_m;
        const dvec3 p =
            settings.deformation ? referenceFromTables(*settings.deformation, deformed_m) : deformed_m;
        const dvec3 v = c.grid.toVoxels(p);
        const dvec4 stored = storedAt(c, v);
        if (stored.a <= 0.0) continue;
        const dvec3 root = dvec3(stored) / std::max(stored.a, 1e-4), albedo = root * root;
        const double sigma_per_m = stored.a * stored.a * full_per_m;
        const double weight = clear * -std::expm1(-sigma_per_m * step * metres);
        const bool lit = clear * std::min(sigma_per_m * finest_m, 1.0) > double(gpu::kWeak);
        ray.light += weight * (lit ? litLight(c, frame, albedo, v, to_eye) : albedo * flatLight(frame));
        clear -= weight;
        if (ray.depth_m == 0.0 && clear < 0.5) ray.depth_m = t;
    }
    ray.opacity = 1.0 - clear;
    return ray;
}

Layer referenceLayer(const MarchCase& c, const gpu::FrameUniforms& frame, const ReferenceSettings& settings) {
    Layer layer{std::uint32_t(frame.layer.x), std::uint32_t(frame.layer.y), {}, {}};
    const std::size_t pixels = std::size_t(layer.width) * layer.height;
    layer.colour.resize(2 * pixels);
    layer.depth_m.resize(2 * pixels);
    parallelFor(2, 2 * layer.height, [&](std::size_t line) {
        const std::size_t eye = line / layer.height, y = line % layer.height;
        for (std::size_t x = 0; x < layer.width; ++x) {
            const dvec2 at((double(x) + 0.5) / layer.width, (double(y) + 0.5) / layer.height);
            const ReferenceRay ray = referenceRay(c, frame, int(eye), at, settings);
            layer.colour[line * layer.width + x] = glm::vec4(finished(ray));
            layer.depth_m[line * layer.width + x] = float(ray.depth_m);
        }
    });
    return layer;
}

}  // namespace stylet::test
