#include "patient/package/motion_io.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "patient/package/nifti.h"
#include "patient/package/package.h"

namespace stylet::patient {
namespace {

constexpr double kMostMotion = 0.1;  // m per unit of v, m per 1/s
constexpr double kMostStoredLevel_m = 1.0;
constexpr double kNodeTolerance_m = 1e-5;

bool isZero(const MotionCoefficients& c) {
    return c == MotionCoefficients{};
}

void checkValues(const std::filesystem::path& file, const MotionModel& m) {
    for (const std::vector<MotionCoefficients>* field : {&m.wall, &m.slide})
        for (const MotionCoefficients& c : *field)
            for (std::size_t i = 0; i < 3; ++i)
                if (!(std::abs(c.a1_m[i]) <= kMostMotion && std::abs(c.a2_m_s[i]) <= kMostMotion))
                    throw DataError(file, "voxels", "a motion beyond 100 mm, or not a number");
    for (const float level : m.level_m)
        if (!(std::abs(level) <= kMostStoredLevel_m))
            throw DataError(file, "voxels", "a level beyond 1 m, or not a number");
}

void checkBorder(const std::filesystem::path& file, const MotionModel& m) {
    Index3 i;
    for (i.z = 0; i.z < m.grid.dims.z; ++i.z)
        for (i.y = 0; i.y < m.grid.dims.y; ++i.y)
            for (i.x = 0; i.x < m.grid.dims.x; ++i.x) {
                const bool inner = m.grid.contains(i - 1) && m.grid.contains(i + 1);
                const std::size_t at = m.grid.offset(i);
                if (!inner && !(isZero(m.wall[at]) && isZero(m.slide[at])))
                    throw DataError(file, "voxels", "the field does not end within its grid");
            }
}

void checkSteepness(const std::filesystem::path& file, const MotionModel& m) {
    const std::size_t strides[3] = {1, std::size_t(m.grid.dims.x),
                                    std::size_t(m.grid.dims.x) * std::size_t(m.grid.dims.y)};
    for (const std::vector<MotionCoefficients>* field : {&m.wall, &m.slide})
        for (int axis = 0; axis < 3; ++axis)
            for (std::size_t at = strides[axis]; at < field->size(); ++at) {
                // Across the end of a row both nodes are zero.
                const MotionCoefficients &a = (*field)[at - strides[axis]], &b = (*field)[at];
                if (maxNodeDifference(m, a, b) > kSteepestField * m.grid.spacing_m[axis])
                    throw DataError(file, "voxels", "a field is too steep for the steps of its flow");
            }
}

}  // namespace

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

namespace {

void take(const std::filesystem::path& file, const Volume<float>& stored, MotionModel& m) {
    for (int axis = 0; axis < 3; ++axis) {
        const double extent_m = stored.grid.spacing_m[axis] * stored.grid.dims[axis];
        if (!(std::abs(stored.grid.spacing_m[axis] / m.grid.spacing_m[axis] - 1.0) * extent_m <=
              kNodeTolerance_m))
            throw DataError(file, "spacing", "differs from patient.toml's");
        if (!(std::abs(stored.grid.origin_m[axis] - m.grid.origin_m[axis]) <= kNodeTolerance_m))
            throw DataError(file, "origin", "differs from patient.toml's");
    }
    m.grid.dims = stored.grid.dims;
    const std::size_t nodes = m.grid.voxelCount();
    m.wall.assign(nodes, {});
    m.slide.assign(nodes, {});
    const float* const values = stored.voxels.data();
    for (std::size_t i = 0; i < nodes; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            m.wall[i].a1_m[c] = values[c * nodes + i];
            m.wall[i].a2_m_s[c] = values[(c + 3) * nodes + i];
            m.slide[i].a1_m[c] = values[(c + 6) * nodes + i];
            m.slide[i].a2_m_s[c] = values[(c + 9) * nodes + i];
        }
    m.level_m.assign(values + 12 * nodes, values + 13 * nodes);
    checkMotion(file, m);
}

}  // namespace

void readMotion(const std::filesystem::path& file, MotionModel& m) {
    take(file, readNiftiVectors(file, kMotionComponents), m);
}

void parseMotion(const std::filesystem::path& file, std::span<const std::byte> bytes, MotionModel& m) {
    take(file, parseNiftiVectors(file, bytes, kMotionComponents), m);
}

void writeMotion(const std::filesystem::path& file, const MotionModel& m) {
    const std::size_t nodes = m.grid.voxelCount();
    Volume<float> stored;
    stored.grid = m.grid;
    stored.voxels.resize(kMotionComponents * nodes);
    float* const values = stored.voxels.data();
    for (std::size_t i = 0; i < nodes; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            values[c * nodes + i] = m.wall[i].a1_m[c];
            values[(c + 3) * nodes + i] = m.wall[i].a2_m_s[c];
            values[(c + 6) * nodes + i] = m.slide[i].a1_m[c];
            values[(c + 9) * nodes + i] = m.slide[i].a2_m_s[c];
        }
    std::copy(m.level_m.begin(), m.level_m.end(), values + 12 * nodes);
    writeNiftiVectors(file, stored, kMotionComponents);
}

}  // namespace stylet::patient
