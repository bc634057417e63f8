#include "render/ultrasound/acoustic_volume.h"

#include <algorithm>
#include <cmath>

#include "render/ultrasound/scan_shared.h"

namespace stylet::render {
namespace {

constexpr std::array<double, 5> kBinomial{1.0 / 16, 4.0 / 16, 6.0 / 16, 4.0 / 16, 1.0 / 16};
constexpr double kFlatMoment = 0.08;  // a smaller first moment gives no direction (a thin sheet, a speck)
constexpr double kMinNear = 0.03;

std::uint32_t code(double value, double low, double high, int steps) {
    return std::uint32_t(std::lround(std::clamp((value - low) / (high - low), 0.0, 1.0) * steps));
}

// Distance [voxels] from a point to the border of a half-space. `share`: the half-space's weight in the
// binomial filter around the point. Negative if it is less than half. The filter is approximated by a
// Gaussian of variance 1.
double planeDistance(double share) {
    double low = -3.0, high = 3.0;
    for (int i = 0; i < 20; ++i) {
        const double middle = 0.5 * (low + high);
        (0.5 * std::erfc(-middle * M_SQRT1_2) < share ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

// Mean of a voxel, counted twice, and its six neighbours. Suppresses the scanner's noise.
double smoothedHu(const CtVolume& ct, const Index3& i) {
    const Grid& grid = ct.grid;
    const std::size_t at = grid.offset(i), across = std::size_t(grid.dims.x);
    const std::array<std::size_t, 3> step{1, across, across * std::size_t(grid.dims.y)};
    int sum = 2 * ct.voxels[at];
    for (int axis = 0; axis < 3; ++axis) {
        sum += ct.voxels[i[axis] > 0 ? at - step[std::size_t(axis)] : at];
        sum += ct.voxels[i[axis] + 1 < grid.dims[axis] ? at + step[std::size_t(axis)] : at];
    }
    return sum / 8.0;
}

}  // namespace

std::uint32_t pack(const AcousticVoxel& v) {
    const Vec3 n = v.normal / (std::fabs(v.normal.x) + std::fabs(v.normal.y) + std::fabs(v.normal.z));
    // Octahedral encoding of the normal; sample.glsl decodes it.
    const auto folded = [&](double a, double b) {
        return n.z >= 0.0 ? a : (1.0 - std::fabs(b)) * (a >= 0.0 ? 1.0 : -1.0);
    };
    std::uint32_t bits = std::uint32_t(v.tissue) | std::uint32_t(v.other) << gpu::kOtherAt;
    bits |= std::uint32_t(8 + std::clamp(int(std::lround(7.0 * v.variation)), -7, 7)) << gpu::kVariationAt;
    if (!v.border) return bits;
    bits |= std::max(code(v.near, 0.0, double(gpu::kNearRange), 63), 1u) << gpu::kNearAt;
    bits |= code(folded(n.x, n.y), -1.0, 1.0, 63) << gpu::kNormalXAt;
    return bits | code(folded(n.y, n.x), -1.0, 1.0, 63) << gpu::kNormalYAt;
}

AcousticVoxel unpack(std::uint32_t bits) {
    AcousticVoxel v;
    v.tissue = int(bits & 31u);
    v.other = int(bits >> gpu::kOtherAt & 31u);
    v.variation = (double(bits >> gpu::kVariationAt & 15u) - 8.0) / 7.0;
    const std::uint32_t near = bits >> gpu::kNearAt & 63u;
    v.border = near != 0;
    v.near = near * double(gpu::kNearRange) / 63.0;
    const auto share = [&](int at) { return double(bits >> at & 63u) * (2.0 / 63.0) - 1.0; };
    Vec3 n(share(gpu::kNormalXAt), share(gpu::kNormalYAt), 0.0);
    n.z = 1.0 - std::fabs(n.x) - std::fabs(n.y);
    const double under = std::max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -under : under;
    n.y += n.y >= 0.0 ? -under : under;
    v.normal = glm::normalize(n);
    return v;
}

int acousticAt(const patient::Patient& patient, const AcousticTable& table,
               const std::array<int, 256>& label_rows, const Index3& i) {
    if (!patient.grid().contains(i)) return table.air;
    const int row = label_rows[patient.package().labels[i]];
    return row >= 0 ? row : table.acousticForHu(smoothedHu(patient.package().ct, i));
}

AcousticEncoder::AcousticEncoder(const patient::Patient& patient, const AcousticTable& table,
                                 Workers& workers)
    : patient_(&patient), table_(&table), workers_(&workers), rows_(patient.grid().voxelCount()) {
    const std::array<int, 256> label_rows = acousticsByLabel(table, patient);
    const Grid& grid = patient.grid();
    workers.run(std::size_t(grid.dims.z), [&](std::size_t z, int) {
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x) {
                const Index3 i(x, y, int(z));
                rows_[grid.offset(i)] = std::uint8_t(acousticAt(patient, table, label_rows, i));
            }
    });
}

int AcousticEncoder::at(const Index3& i) const {
    const Grid& grid = patient_->grid();
    return rows_[grid.offset(glm::clamp(i, Index3(0), grid.dims - 1))];
}

void AcousticEncoder::encode(int z0, int z1, std::uint32_t* out) const {
    const Index3 dims = patient_->grid().dims;
    workers_->run(std::size_t(z1 - z0), [&](std::size_t slice, int) {
        std::uint32_t* to = out + slice * std::size_t(dims.x) * std::size_t(dims.y);
        for (int y = 0; y < dims.y; ++y)
            for (int x = 0; x < dims.x; ++x)
                *to++ = pack(voxelAt({x, y, z0 + int(slice)}));
    });
}

AcousticVoxel AcousticEncoder::voxelAt(const Index3& i) const {
    AcousticVoxel v;
    v.tissue = v.other = at(i);
    const Acoustic& a = table_->acoustics[std::size_t(v.tissue)];
    if (a.hu_span > 0.0)
        v.variation =
            std::clamp((smoothedHu(patient_->package().ct, i) - a.hu_centre) / a.hu_span, -1.0, 1.0);
    if (!isSurroundedBySame(i)) findBorder(i, v);
    return v;
}

// True if all voxels that touch a voxel are of its tissue.
bool AcousticEncoder::isSurroundedBySame(const Index3& i) const {
    const Grid& grid = patient_->grid();
    const Index3 low = glm::max(i - 1, Index3(0)), high = glm::min(i + 1, grid.dims - 1);
    const std::uint8_t row = rows_[grid.offset(i)];
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y) {
            const std::uint8_t* begin = &rows_[grid.offset({low.x, y, z})];
            for (const std::uint8_t* r = begin; r <= begin + (high.x - low.x); ++r)
                if (*r != row) return false;
        }
    return true;
}

void AcousticEncoder::findBorder(const Index3& i, AcousticVoxel& v) const {
    double share = 0.0;
    Vec3 moment(0.0);
    std::array<double, kMaxAcoustics> others{};
    forEachVoxel({Index3(5)}, [&](const Index3& n) {
        const double w =
            kBinomial[std::size_t(n.x)] * kBinomial[std::size_t(n.y)] * kBinomial[std::size_t(n.z)];
        const int row = at(i + n - 2);
        if (row == v.tissue) {
            share += w;
            moment += w * Vec3(n - 2);
        } else {
            others[std::size_t(row)] += w;
        }
    });
    const double size = glm::length(moment);
    if (size < kFlatMoment) return;
    v.border = true;
    v.normal = -moment / size;
    v.near = std::clamp(planeDistance(share), kMinNear, double(gpu::kNearRange));
    v.other = int(std::max_element(others.begin(), others.end()) - others.begin());
}

}  // namespace stylet::render
