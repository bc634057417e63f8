#include "patient/synth/variants/scanner.h"

#include <cmath>

#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

// Mean HU at 120 kV in the phases other than the portal one, which is the reference patient's. Sources in
// README.md.
struct PhaseRow {
    Id id;
    double native, arterial, late;
};
constexpr PhaseRow kPhases[] = {
    {Id::heart, 44, 230, 105},       {Id::aorta, 42, 300, 115},     {Id::cava, 42, 62, 118},
    {Id::liver, 58, 66, 90},         {Id::portal, 42, 75, 112},     {Id::hepaticVeins, 42, 48, 110},
    {Id::tumour, 40, 55, 70},        {Id::spleen, 48, 120, 88},     {Id::pancreas, 42, 105, 75},
    {Id::kidneyRight, 32, 150, 160}, {Id::kidneyLeft, 32, 150, 160}};

double inPhase(const PhaseRow& row, Phase phase) {
    switch (phase) {
        case Phase::native:
            return row.native;
        case Phase::arterial:
            return row.arterial;
        case Phase::late:
            return row.late;
        case Phase::portal:
            break;
    }
    return ctRow(row.id).mean_hu;
}

constexpr Id kBones[] = {Id::ribsRight, Id::ribsLeft, Id::spine, Id::sternum};
constexpr Id kFat[] = {Id::fat, Id::visceralFat};

// Adds the share of a thick slice, which lies within `half` of `centre`, to the weights of the thin slices.
void addSlice(std::vector<double>& weights, double centre, double half, double share) {
    const auto overlap = [&](int z) {
        return std::max(0.0, std::min(z + 0.5, centre + half) - std::max(z - 0.5, centre - half));
    };
    const int count = int(weights.size());
    const int low = std::clamp(int(centre - half), 0, count - 1),
              high = std::clamp(int(centre + half) + 1, 0, count - 1);
    double sum = 0.0;
    for (int z = low; z <= high; ++z)
        sum += overlap(z);
    for (int z = low; z <= high; ++z)
        weights[std::size_t(z)] += share * overlap(z) / sum;
}

// How much each thin slice contributes to the slice at `z`, if thick slices are `step` apart.
std::vector<double> thickWeights(int count, int z, double step) {
    std::vector<double> weights(std::size_t(count), 0.0);
    const double below = std::floor(z / step) * step, share = (z - below) / step;
    const bool is_last = below + step > count - 1;
    addSlice(weights, below, 0.5 * step, is_last ? 1.0 : 1.0 - share);
    if (!is_last) addSlice(weights, below + step, 0.5 * step, share);
    return weights;
}

}  // namespace

CtSettings ctSettings(const Scanner& scanner) {
    CtSettings settings;
    settings.noise = scanner.noise * scanner.kernel_noise;
    settings.blur_passes = scanner.blur_passes;
    const auto mean = [&](Id id) -> double& { return settings.mean_hu[std::size_t(id)]; };
    for (const PhaseRow& row : kPhases) {
        const double enhanced = scanner.iodine * (inPhase(row, scanner.phase) - row.native);
        mean(row.id) = row.native + enhanced;
        // Cortex and medulla, blood and heart muscle differ by their enhancement.
        const double usual = ctRow(row.id).mean_hu - row.native;
        settings.contrast[std::size_t(row.id)] =
            scanner.phase == Phase::portal ? scanner.iodine : enhanced / usual;
    }
    mean(Id::liver) += scanner.liver_fat_hu;
    for (const Id id : kBones) {
        mean(id) *= scanner.bone;
        settings.contrast[std::size_t(id)] = scanner.bone;
    }
    for (const Id id : kFat)
        mean(id) += scanner.fat_hu;
    return settings;
}

void thickenSlices(CtVolume& ct, double thickness_m) {
    const CtVolume thin = ct;
    const Grid& grid = ct.grid;
    const std::size_t plane = std::size_t(grid.dims.x) * std::size_t(grid.dims.y);
    for (int z = 0; z < grid.dims.z; ++z) {
        const std::vector<double> weights =
            thickWeights(grid.dims.z, z, std::max(1.0, thickness_m / grid.spacing_m.z));
        std::vector<double> slice(plane, 0.0);
        for (int from = 0; from < grid.dims.z; ++from) {
            const double weight = weights[std::size_t(from)];
            if (weight == 0.0) continue;
            for (std::size_t i = 0; i < plane; ++i)
                slice[i] += weight * thin.voxels[std::size_t(from) * plane + i];
        }
        for (std::size_t i = 0; i < plane; ++i)
            ct.voxels[std::size_t(z) * plane + i] = std::int16_t(std::floor(slice[i] + 0.5));
    }
}

void addStreaks(CtVolume& ct) {
    constexpr std::int16_t kMetal_hu = 2000;
    constexpr double kStreak_hu = 350.0, kReach_mm = 12.0;
    const Grid& grid = ct.grid;
    for (int z = 0; z < grid.dims.z; ++z) {
        Vec3 sum{0.0};
        double count = 0.0;
        forEachVoxel({0, 0, z}, {grid.dims.x - 1, grid.dims.y - 1, z}, [&](const Index3& i) {
            if (ct[i] > kMetal_hu) sum += grid.centre(i), ++count;
        });
        if (count == 0.0) continue;
        const Vec3 metal = sum / count;
        forEachVoxel({0, 0, z}, {grid.dims.x - 1, grid.dims.y - 1, z}, [&](const Index3& i) {
            if (ct[i] > kMetal_hu || ct[i] <= -1000) return;
            const Vec3 beside_mm = 1000.0 * (grid.centre(i) - metal);
            const Vec3 direction = unitOr(beside_mm, Vec3(1.0, 0.0, 0.0));
            const double fade = kReach_mm / (kReach_mm + length(beside_mm));
            const double hu = ct[i] + kStreak_hu * fade * valueNoise(direction * 8.0, std::uint64_t(z));
            ct[i] = std::int16_t(std::floor(std::clamp(hu, -1024.0, 3000.0) + 0.5));
        });
    }
}

}  // namespace stylet::patient::synth
