// Skin, subcutaneous fat, muscles of the wall, and the fascia that lines them.
#include "base/parallel.h"
#include "patient/synth/painters.h"
#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

// Thin layers of fat: around psoas, between the three oblique muscles of the flank, between the ribs and
// the muscles on top of them, around the erector muscles of the spine.
bool fatPlane(const Anatomy& a, const Vec3& p, double d, double muscle_depth) {
    if (d < 0.0) {
        // Fat beside the vertebral bodies, around psoas and the crura.
        const double sway = 3.0 * valueNoise(p / 12.0, a.seed ^ 0x64);
        return a.psoas(p) > 0.0 && p.y > a.vertebra(p.z).y - 11.0 - 0.15 * std::fabs(p.x) + sway;
    }
    const double f = a.front(p), x = std::fabs(p.x);
    const double sway = valueNoise(p / 26.0, a.seed ^ 0x62);
    if (f < -0.55) {
        if (d > 1.0 && std::fabs(x - 57.0 - 0.25 * d - 4.0 * sway) < 0.9) return true;
        return d > 12.0 && std::fabs(x - 27.0 - 0.3 * d - 6.0 * sway) < 0.3 + 0.7 * sway;
    }
    if (p.z > a.costalMargin(f) - 12.0) return muscle_depth > 14.0 && std::fabs(d - 11.4 - 1.2 * sway) < 0.75;
    if (x < 66.0) return false;
    const double share = d / muscle_depth;
    return std::fabs(share - 0.3 - 0.04 * sway) * muscle_depth < 0.65 ||
           std::fabs(share - 0.62) * muscle_depth < 0.65;
}

// Details of fat and muscle: septa between fat lobules, strands of fat between muscle bundles.
std::uint8_t fatDetail(const Anatomy& a, const Vec3& p) {
    const double septum = std::fabs(valueNoise({p.x / 13.0, p.y / 13.0, p.z / 22.0}, a.seed ^ 0x63));
    return detailFrom(ramp(septum, 0.07, 0.0));
}
std::uint8_t muscleDetail(const Anatomy& a, const Vec3& p) {
    const double strands = valueNoise({p.x / 3.5, p.y / 3.5, p.z / 14.0}, a.seed ^ 0x61);
    return detailFrom(0.8 - 0.9 * std::max(strands - 0.35, 0.0) * (p.y < -40.0 ? 2.0 : 1.0));
}

}  // namespace

void paintWall(Canvas& canvas, const Anatomy& a) {
    // A layer thinner than a voxel would have holes.
    const double skin_mm = std::max(2.0, 1.3 * canvas.voxel_mm());
    const auto brush = [&](const Vec3& p, Voxel voxel) {
        const double d = a.cageDistance(p);
        if (d > 75.0) return;
        if (d < 0.0 && a.cavityDistance(p) < 0.0) {
            voxel.label = std::uint8_t(Id::visceralFat);
            return;
        }
        const double skin = a.skinDepth(p);
        const double muscle = std::min(a.muscleDepth(p), skin - skin_mm - 3.0);
        if (d > skin) return;
        if (d > skin - skin_mm) {
            voxel.label = std::uint8_t(Id::skin);
        } else if (d > muscle || fatPlane(a, p, d, muscle)) {
            voxel.set(Id::fat, fatDetail(a, p));
        } else {
            voxel.set(Id::muscle, muscleDetail(a, p));
        }
    };
    canvas.paint(kWholeBody, only(Id::air), brush);
}

void paintFascia(Canvas& canvas) {
    const Grid& grid = canvas.grid();
    const auto inside = std::uint8_t(Id::visceralFat);
    std::vector<std::vector<std::size_t>> found(std::size_t(grid.dims.z));
    const LabelVolume& labels = canvas.labels;
    parallelVoxels(canvas.threads, grid, [&](const Index3& i) {
        if (grid.atSide(i) || labels[i] == inside) return;
        const bool touches = std::any_of(kFaceSteps.begin(), kFaceSteps.end(), [&](const Index3& step) {
            return grid.contains(i + step) && labels[i + step] == inside;
        });
        if (touches) found[std::size_t(i.z)].push_back(grid.offset(i));
    });
    for (const auto& slice : found)
        for (const std::size_t n : slice)
            canvas.labels.voxels[n] = std::uint8_t(Id::fascia), canvas.detail[n] = 0;
}

}  // namespace stylet::patient::synth
