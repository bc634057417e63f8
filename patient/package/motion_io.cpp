#include "patient/package/motion_io.h"

#include <cmath>
#include <string>

#include "patient/package/nifti.h"
#include "patient/package/package.h"

namespace stylet::patient {
namespace {

constexpr double kMaxMotion = 0.1;  // m per unit of v, m per 1/s
constexpr double kMaxStoredLevel_m = 1.0;
constexpr double kNodeTolerance_m = 1e-5;
constexpr double kMaxDrift_m = 1e-5;  // of the last voxel, because of a difference in spacing

bool isZero(const MotionCoefficients& c) {
    return c == MotionCoefficients{};
}

void checkValues(const std::filesystem::path& file, const MotionModel& m) {
    for (const std::vector<MotionCoefficients>* field : {&m.wall, &m.slide})
        for (const MotionCoefficients& c : *field)
            for (std::size_t i = 0; i < 3; ++i)
                if (!(std::abs(c.a1_m[i]) <= kMaxMotion && std::abs(c.a2_m_s[i]) <= kMaxMotion))
                    throw DataError(file, "voxels", "a motion beyond 100 mm, or not a number");
    for (const float level : m.level_m)
        if (!(std::abs(level) <= kMaxStoredLevel_m))
            throw DataError(file, "voxels", "a level beyond 1 m, or not a number");
}

void checkBorder(const std::filesystem::path& file, const MotionModel& m) {
    forEachVoxel(m.grid, [&](const Index3& i) {
        const std::size_t at = m.grid.offset(i);
        if (m.grid.atBorder(i) && !(isZero(m.wall[at]) && isZero(m.slide[at])))
            throw DataError(file, "voxels", "the field does not end within its grid");
    });
}

void checkSteepness(const std::filesystem::path& file, const MotionModel& m) {
    for (const std::vector<MotionCoefficients>* field : {&m.wall, &m.slide})
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t step = m.grid.strides()[std::size_t(axis)], at = step; at < field->size();
                 ++at) {
                // At the end of a row, `a` and `b` are in different rows. Both are outermost nodes, so their
                // fields are zero.
                const MotionCoefficients &a = (*field)[at - step], &b = (*field)[at];
                if (maxNodeDifference(m, a, b) > kMaxFieldGradient * m.grid.spacing_m[axis])
                    throw DataError(file, "voxels", "a field is too steep for the steps of its flow");
            }
}

// Calls visit(number, index) for every number of the fields and the level. `index` is its position in the
// file.
template <typename Model, typename Visit>
void forEachNumber(Model& m, const Visit& visit) {
    const std::size_t nodes = m.level_m.size();
    for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            visit(m.wall[i].a1_m[c], c * nodes + i);
            visit(m.wall[i].a2_m_s[c], (c + 3) * nodes + i);
            visit(m.slide[i].a1_m[c], (c + 6) * nodes + i);
            visit(m.slide[i].a2_m_s[c], (c + 9) * nodes + i);
        }
        visit(m.level_m[i], 12 * nodes + i);
    }
}

void assignFields(const std::filesystem::path& file, const Volume<float>& stored, MotionModel& m) {
    checkStoredGrid(file, stored.grid, m.grid, kNodeTolerance_m);
    m.grid.dims = stored.grid.dims;
    const std::size_t nodes = m.grid.voxelCount();
    m.wall.assign(nodes, {}), m.slide.assign(nodes, {}), m.level_m.assign(nodes, 0.0f);
    forEachNumber(m, [&](float& number, std::size_t at) { number = stored.voxels[at]; });
    checkMotion(file, m);
}

}  // namespace

void checkStoredGrid(const std::filesystem::path& file, const Grid& own, const Grid& exact,
                     double origin_tolerance_m) {
    for (int axis = 0; axis < 3; ++axis) {
        const double drift_m = std::abs(own.spacing_m[axis] - exact.spacing_m[axis]) * own.dims[axis];
        if (!(drift_m <= kMaxDrift_m)) throw DataError(file, "spacing", "differs from patient.toml's");
        if (!(std::abs(own.origin_m[axis] - exact.origin_m[axis]) <= origin_tolerance_m))
            throw DataError(file, "origin", "differs from patient.toml's");
    }
}

void checkMotion(const std::filesystem::path& file, const MotionModel& m) {
    const std::size_t nodes = m.level_m.size();
    if (m.wall.size() != nodes || m.slide.size() != nodes)
        throw DataError(file, "voxels", "the fields differ in size");
    if (m.empty()) return;
    if (m.grid.dims.x < 3 || m.grid.dims.y < 3 || m.grid.dims.z < 3 || m.grid.voxelCount() != nodes)
        throw DataError(file, "dim", "fewer than three nodes along an axis, or not those of the fields");
    checkValues(file, m);
    checkBorder(file, m);
    checkSteepness(file, m);
}

void readMotion(const std::filesystem::path& file, MotionModel& m) {
    assignFields(file, readNiftiVectors(file, kMotionComponents), m);
}

void parseMotion(const std::filesystem::path& file, std::span<const std::byte> bytes, MotionModel& m) {
    assignFields(file, parseNiftiVectors(file, bytes, kMotionComponents), m);
}

void writeMotion(const std::filesystem::path& file, const MotionModel& m) {
    Volume<float> stored;
    stored.grid = m.grid;
    stored.voxels.resize(kMotionComponents * m.grid.voxelCount());
    forEachNumber(m, [&](float number, std::size_t at) { stored.voxels[at] = number; });
    writeNiftiVectors(file, stored, kMotionComponents);
}

}  // namespace stylet::patient
