#include "tests/render/phantoms.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/smoothstep.h"
#include "patient/motion/motion_interface.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::test {

using patient::Tissue;

namespace {

struct Material {
    std::uint8_t label = 0;
    double hu = -1000.0;
};

constexpr Material kAir{0, -1000}, kSkin{1, -50}, kFat{0, -100}, kMuscle{0, 50}, kBone{3, 600},
    kLiver{5, 110}, kVessel{6, 170}, kDuct{7, 8}, kLung{0, -800};

// Sets the label at the voxel's centre and the CT value averaged over 2^3 points, so that partial volumes
// look as in a scanner.
void fill(patient::Package& package, const std::function<Material(const Vec3&)>& at) {
    const Grid& grid = package.ct.grid;
    forEachVoxel(grid, [&](const Index3& i) {
        const Vec3 p = grid.centre(i);
        double hu = 0.0;
        for (int k = 0; k < 8; ++k)
            hu += at(p + 0.25 * grid.spacing_m * Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)).hu;
        package.ct[i] = std::int16_t(std::lround(hu / 8.0));
        package.labels[i] = at(p).label;
    });
}

double segmentDistance(const Vec3& p, const Vec3& a, const Vec3& b) {
    const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
    return glm::length(p - (a + t * (b - a)));
}

Material trunkAt(const Vec3& p) {
    const auto ellipse = [&](double rx, double ry) { return std::hypot(p.x / rx, p.y / ry); };
    const double body = ellipse(0.150, 0.100);
    if (body > 1.0) return kAir;
    if (body > 0.975) return kSkin;
    if (body > 0.90) return kFat;
    const double shell = ellipse(0.128, 0.080);
    const double along = std::fmod(p.z + 0.35 * std::fabs(p.y) + 1.0, 0.030);
    if (shell > 0.94 && shell < 1.04 && along < 0.012 && p.z > -0.06) return kBone;
    if (std::hypot(p.x, p.y + 0.058) < 0.020) return kBone;
    const Vec3 q = (p - Vec3(0.045, 0.0, -0.015)) / Vec3(0.070, 0.060, 0.065);
    if (glm::length(q) < 1.0) {
        const Vec3 hilum(0.005, -0.005, -0.03);
        for (const Vec3& tip : {Vec3(0.085, 0.015, 0.0), Vec3(0.07, -0.03, 0.02), Vec3(0.06, 0.03, -0.04)}) {
            if (segmentDistance(p, hilum, tip) < 0.003) return kDuct;
            if (segmentDistance(p, hilum + Vec3(0, -0.010, 0.004), tip + Vec3(0, -0.010, 0.004)) < 0.0045)
                return kVessel;
        }
        return kLiver;
    }
    if (p.z > 0.03 && ellipse(0.115, 0.070) < 1.0 && std::fabs(p.x) > 0.025) return kLung;
    return kMuscle;
}

// 20 mm caudal motion inside a cavity that narrows toward the head. Its front wall moves out by 4 mm.
patient::MotionModel trunkMotion() {
    patient::MotionModel m = makeMotion(Vec3(0.19, 0.14, 0.15), 0.005, [](const Vec3& p) {
        MotionPoint q;
        const double narrow = 1.0 - 0.08 * smoothStep(0.0, 0.12, p.z);
        q.level_m = (std::hypot(p.x / (0.118 * narrow), p.y / (0.071 * narrow)) - 1.0) * 0.071;
        q.slide_a1_m.z = -0.020 * smoothStep(-0.11, -0.04, p.z) * smoothStep(0.11, 0.03, p.z);
        q.wall_a1_m.y = 0.004 * smoothStep(0.0, 0.08, p.y) * smoothStep(0.13, 0.11, p.y) *
                        smoothStep(0.14, 0.05, p.z) * smoothStep(-0.14, -0.05, p.z);
        return q;
    });
    patient::makeTangential(m);
    return m;
}

}  // namespace

patient::Package emptyPackage(const Vec3& half_m, double spacing_m) {
    Grid grid;
    grid.spacing_m = Vec3(spacing_m);
    grid.dims = Index3(glm::ceil(2.0 * half_m / spacing_m - 1e-6));
    grid.origin_m = -0.5 * spacing_m * Vec3(grid.dims - 1);
    patient::Package package;
    package.name = "phantom";
    package.licence = "CC0-1.0";
    package.provenance = "tests/render/phantoms.cpp";
    package.tissues = tissueDefaults().tissues;
    package.elasticity = tissueDefaults().elasticity;
    package.thresholds = tissueDefaults().thresholds;
    package.label_table = tissueLabels();
    package.ct = CtVolume(grid);
    package.labels = LabelVolume(grid);
    return package;
}

patient::Package makeBall(Tissue tissue, double radius_m, double margin_m, double spacing_m) {
    patient::Package package = emptyPackage(Vec3(radius_m + margin_m), spacing_m);
    const Material inside{std::uint8_t(tissue), tissue == Tissue::bone ? 700.0 : 40.0};
    fill(package, [&](const Vec3& p) { return glm::length(p) < radius_m ? inside : kAir; });
    return package;
}

patient::Package makeBlock(Tissue tissue, const Vec3& size_m, double spacing_m) {
    patient::Package package = emptyPackage(glm::round(size_m / spacing_m) * (0.5 * spacing_m), spacing_m);
    fill(package, [&](const Vec3&) { return Material{std::uint8_t(tissue), 40.0}; });
    return package;
}

patient::Package makeTrunk(double spacing_m) {
    patient::Package package = emptyPackage(Vec3(0.160, 0.110, 0.120), spacing_m);
    fill(package, trunkAt);
    package.motion = trunkMotion();
    return package;
}

bool inBody(const patient::Package& package, const patient::Surrogate& now, const Vec3& deformed_m) {
    return package.ct.nearestOr(referenceFromDeformed(package.motion, now, deformed_m), -1000) > -500;
}

patient::ToolContact contactAt(const Vec3& skin_m, const Vec3& moved_m, double radius_m) {
    return {.id = 0,
            .begin_m = skin_m,
            .end_m = skin_m,
            .begin_moved_m = moved_m,
            .end_moved_m = moved_m,
            .radius_m = radius_m};
}

}  // namespace stylet::test
