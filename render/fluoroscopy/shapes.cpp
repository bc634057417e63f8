#include "render/fluoroscopy/shapes.h"

namespace stylet::render {
namespace {

// Dimensions as in assets/generate/instruments.py and hand.py.
constexpr double kHubRadius_m = 0.0045, kHubLength_m = 0.019;
// Piezoceramic, matching layers and backing under the lens, as one material.
constexpr double kTransducerPerM = 150.0;
constexpr double kBonePerM = 45.0;

void add(const Pose& pose, const Vec3& begin, const Vec3& end, XrayShape shape, std::vector<XrayShape>& to) {
    shape.begin_m = pose * begin;
    shape.end_m = pose * end;
    to.push_back(shape);
}

}  // namespace

void addNeedle(const Pose& pose, const NeedleShape& needle, bool stylet_in, std::vector<XrayShape>& shapes) {
    const bool solid = needle.inner_m == 0.0 || (needle.has_stylet && stylet_in);
    // The round end of a solid shaft stands for the ground tip and ends at the tip.
    add(pose, {0, 0, solid ? needle.radius_m() : 0.0}, {0, 0, needle.length_m},
        {.radius_m = needle.radius_m(),
         .bore_m = solid ? 0.0 : 0.5 * needle.inner_m,
         .per_m = needle.attenuation_per_m,
         .round = solid},
        shapes);
    add(pose, {0, 0, needle.length_m}, {0, 0, needle.length_m + kHubLength_m},
        {.radius_m = kHubRadius_m, .bore_m = 0.002, .per_m = kPlasticPerM, .round = false}, shapes);
}

void addTube(const CurvedTube& tube, std::vector<XrayShape>& shapes) {
    const double bore = tube.bore_m / tube.radius_m;
    for (std::size_t i = 1; i < tube.points_m.size(); ++i)
        shapes.push_back({.begin_m = tube.points_m[i - 1],
                          .end_m = tube.points_m[i],
                          .radius_m = tube.radius_m,
                          .per_m = tube.attenuation_per_m * (1.0 - bore * bore),
                          .chained = i > 1});
}

void addProbe(const Pose& pose, double face_m, std::vector<XrayShape>& shapes) {
    const double half_m = 0.5 * face_m - 0.006, head_m = 0.008 + 0.5 * half_m + 0.002;
    add(pose, {-half_m, 0, 0.008}, {half_m, 0, 0.008}, {.radius_m = 0.0075, .per_m = kTransducerPerM},
        shapes);
    add(pose, {0, 0, 0.018}, {0, 0, 0.060},
        {.radius_m = head_m, .bore_m = head_m - 0.0025, .per_m = kPlasticPerM}, shapes);
    add(pose, {0, 0, 0.060}, {0, 0, 0.145},
        {.radius_m = 0.0165, .bore_m = 0.0140, .per_m = kPlasticPerM, .chained = true}, shapes);
    add(pose, {0, 0, 0.030}, {0, 0, 0.180}, {.radius_m = 0.0030, .per_m = 120.0}, shapes);  // wires
}

void addScalpel(const Pose& pose, std::vector<XrayShape>& shapes) {
    add(pose, {0, 0, 0.002}, {0, 0, 0.030}, {.radius_m = 0.0008}, shapes);
    add(pose, {0, 0, 0.030}, {0, 0, 0.150}, {.radius_m = 0.0024, .chained = true}, shapes);
}

void addFinger(const Pose& pose, std::vector<XrayShape>& shapes) {
    add(pose, {0, 0, 0.008}, {0, 0, 0.090}, {.radius_m = 0.008, .per_m = kFleshPerM}, shapes);
    for (const double begin_m : {0.006, 0.029, 0.055})
        add(pose, {0, 0, begin_m}, {0, 0, begin_m + 0.020}, {.radius_m = 0.0038, .per_m = kBonePerM}, shapes);
}

}  // namespace stylet::render
