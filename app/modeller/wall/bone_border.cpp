#include "app/modeller/wall/bone_border.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/image/morphology.h"
#include "base/parallel.h"

namespace stylet::modeller {

namespace {

// Undoes most of the scan's blur: steps of P. H. van Cittert, "Zum Einfluss der Spaltbreite auf die
// Intensitaetsverteilung in Spektrallinien II", Z. Physik 69, 1931. The blur along each axis is taken to be
// that of some passes of [share, 1 - 2 share, share]: one pass for up to .71 voxels, three for 1.22 and more.
// Between .71 and .87 and from 1.0 to 1.12 voxels it is taken to be narrower, because a further pass raises
// the noise.
FloatVolume sharpened(const CtVolume& ct, const ScanBlur& blur) {
    constexpr double kPassVariance = 0.5;  // of [1 2 1]/4, the widest pass
    constexpr int kMaxPasses = 3;
    std::array<int, 3> passes{};
    std::array<float, 3> share{};
    double sum = 0.0;
    for (const int axis : {0, 1, 2}) {
        const double voxels = (axis == 2 ? blur.across_m : blur.within_m) / ct.grid.spacing_m.x;
        const double variance = voxels * voxels;
        int& n = passes[std::size_t(axis)];
        n = std::clamp(int(std::lround(variance / kPassVariance)), 1, kMaxPasses);
        share[std::size_t(axis)] = float(std::min(variance / n, kPassVariance) / 2.0);
        sum += n;
    }
    // Wider blur needs more steps, but each raises the noise. In slices of 3 mm, with one pass within slices
    // and three across, two steps miss 4 % of the ribs' voxels and five miss 14 % (seed 421).
    const int steps = int(std::lround(2.0 * sum / 3.0)) - 1;
    FloatVolume sharp = toFloat(ct);
    for (int step = 0; step < steps; ++step) {
        FloatVolume blurred = sharp;
        for (const int axis : {0, 1, 2}) {
            const auto pass = [part = share[std::size_t(axis)]](float* first, std::size_t stride,
                                                                std::size_t count) {
                float before = first[0];
                for (std::size_t i = 0; i < count; ++i) {
                    float& at = first[i * stride];
                    const float here = at, after = first[std::min(i + 1, count - 1) * stride];
                    at += part * (before - 2.0f * here + after);
                    before = here;
                }
            };
            for (int n = 0; n < passes[std::size_t(axis)]; ++n)
                parallelLines(processorCount(), ct.grid.dims, axis, blurred.voxels.data(), pass);
        }
        for (std::size_t i = 0; i < sharp.voxels.size(); ++i)
            sharp.voxels[i] += float(ct.voxels[i]) - blurred.voxels[i];
    }
    return sharp;
}

// Mean HU of the muscle beside the bones, measured around each voxel. Fat is not counted: in a mean with fat,
// the blurred edge of muscle would be above half maximum.
FloatVolume muscleBeside(const CtVolume& ct, const Mask& body, const Mask& bone) {
    constexpr float kClear_m = 0.002f, kBeside_m = 0.006f;  // where muscle is measured: from, to
    constexpr std::int16_t kDarkestMuscle_hu = 0;           // fat is darker
    constexpr float kUsual_hu = 55.0f, kMinMeasured = 0.001f;
    FloatVolume distance = distanceTo(bone), sum(ct.grid), count(ct.grid);
    for (std::size_t i = 0; i < sum.voxels.size(); ++i)
        if (body.voxels[i] && ct.voxels[i] > kDarkestMuscle_hu && distance.voxels[i] > kClear_m &&
            distance.voxels[i] < kBeside_m)
            sum.voxels[i] = float(ct.voxels[i]), count.voxels[i] = 1.0f;
    distance = {};  // the memory is needed
    const int reach = std::max(1, int(std::lround(double(kBeside_m) / ct.grid.spacing_m.x)));
    sum = boxMean(sum, reach), count = boxMean(count, reach);
    for (std::size_t i = 0; i < sum.voxels.size(); ++i)
        sum.voxels[i] = count.voxels[i] > kMinMeasured ? sum.voxels[i] / count.voxels[i] : kUsual_hu;
    return sum;
}

}  // namespace

bool hidesBoneBorders(const Grid& g, const ScanBlur& blur) {
    constexpr double kSoft_m = 0.001;
    return std::max(blur.within_m, blur.across_m) > std::max(kSoft_m, g.spacing_m.x);
}

BoneScan::BoneScan(const CtVolume& scan, const Mask& in_body, const ScanBlur& scan_blur)
    : ct(scan), body(in_body), blur(scan_blur), sharp(sharpened(scan, scan_blur)) {}

Mask withoutBlurredRim(const BoneScan& scan, const Mask& bone, const Mask& canal) {
    constexpr double kRim_m = 0.002;  // at most so much is removed
    // Almost half a rib's thickness. With 2.5 mm no path of seeds 61, 71 and 81 meets a false rib either.
    constexpr double kPeak_m = 0.003;
    // Minimum height above muscle of a thin, dark part of the cortex, as a share of its highest neighbour. In
    // a blurred rim the neighbour inside the bone is higher. From 0.55 on no path of seeds 61, 71 and 81
    // meets a false rib; a higher share loses more of a thin cortex.
    constexpr float kRidge = 0.6f;
    constexpr float kBrightestBone_hu = 1300.0f;  // brighter is metal
    const Grid& g = bone.grid;
    const FloatVolume& sharp = scan.sharp;
    const FloatVolume muscle = muscleBeside(scan.ct, scan.body, bone);
    const auto voxels = [&](double m) { return std::max(1, int(std::lround(m / g.spacing_m.x))); };
    Mask dark(g);
    parallelVoxels(g, [&](const Index3& i) {
        if (!bone[i]) return;
        const auto peakHeight = [&](int reach) {
            float peak_hu = sharp[i];
            forEachVoxel(boxAround(g, i, reach), [&](const Index3& n) {
                if (bone[n]) peak_hu = std::max(peak_hu, sharp[n]);
            });
            return std::min(peak_hu, kBrightestBone_hu) - muscle[i];
        };
        const float height = sharp[i] - muscle[i];
        dark[i] = height < 0.5f * peakHeight(voxels(kPeak_m)) && height < kRidge * peakHeight(1);
    });
    return subtract(bone, growSeeds(inverted(unite(bone, canal)), dark, voxels(kRim_m)));
}

}  // namespace stylet::modeller
