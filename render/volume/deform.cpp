// Each node is traced back on its own: a short path in one midpoint step, a long one in Runge-Kutta steps.
// The wall's flow is smooth, so it is integrated at the model's nodes and interpolated between them. Scaling
// and squaring (Arsigny et al. 2006) was slower and less accurate: it reads the large table repeatedly, and
// interpolates again each time. This method reads only the model's small table. stylet-bench --only
// patient.breathing measures both.
#include "render/volume/deform.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "render/volume/deform_rows.h"

namespace stylet::render {
namespace {

using patient::MotionCoefficients;
using patient::MotionModel;
using patient::Surrogate;

using Table = std::vector<glm::vec4>;

constexpr std::int16_t kMinBodyHu = -700;  // lowest value that a look may show without a label

// Linear between nodes; beyond them the nearest value.
glm::vec4 tableAt(const Grid& grid, const Table& table, const Vec3& p) {
    const glm::vec3 at(glm::clamp(grid.toVoxels(p), Vec3(0.0), Vec3(grid.dims - 1)));
    const Index3 low = glm::min(Index3(at), grid.dims - 2);
    const glm::vec3 f = at - glm::vec3(low);
    const glm::vec4* const n = table.data() + grid.offset(low);
    const std::size_t row = std::size_t(grid.dims.x), slice = row * std::size_t(grid.dims.y);
    const glm::vec4 near = glm::mix(glm::mix(n[0], n[1], f.x), glm::mix(n[row], n[row + 1], f.x), f.y);
    const glm::vec4* const m = n + slice;
    const glm::vec4 far = glm::mix(glm::mix(m[0], m[1], f.x), glm::mix(m[row], m[row + 1], f.x), f.y);
    return glm::mix(near, far, f.z);
}

// Grid over the motion model's box.
Grid motionBox(const MotionModel& model, double spacing_m) {
    Grid grid;
    if (model.empty()) {
        grid.dims = Index3(2);
        grid.spacing_m = Vec3(1.0);
        grid.origin_m = Vec3(-0.5);
        return grid;
    }
    grid.origin_m = model.grid.origin_m;
    for (int axis = 0; axis < 3; ++axis) {
        const double extent_m = model.grid.spacing_m[axis] * (model.grid.dims[axis] - 1);
        const int cells = std::max(1, int(std::ceil(extent_m / spacing_m - 1e-9)));
        grid.dims[axis] = cells + 1;
        grid.spacing_m[axis] = extent_m / cells;
    }
    return grid;
}

// The part of a grid whose nodes surround another box.
Grid cropped(const Grid& grid, const Grid& box) {
    Grid part = grid;
    const Index3 last = grid.dims - 1;
    const Index3 low = glm::clamp(Index3(glm::floor(grid.toVoxels(box.origin_m))) - 1, Index3(0), last - 1);
    const Index3 high =
        glm::clamp(Index3(glm::ceil(grid.toVoxels(box.centre(box.dims - 1)))) + 1, low + 1, last);
    part.origin_m = grid.centre(low);
    part.dims = high - low + 1;
    return part;
}

double vectorLength(const std::array<float, 3>& a) {
    return std::sqrt(double(a[0]) * double(a[0]) + double(a[1]) * double(a[1]) + double(a[2]) * double(a[2]));
}

constexpr double kMaxCreep_v = 1.0;  // drift during a long breath hold, beyond the range of v

// Upper bound of the displacement outside the cavity, over all breaths [m].
double maxOutside(const MotionModel& m) {
    const double v =
        std::max(std::fabs(m.v.low - m.reference.v), std::fabs(m.v.high - m.reference.v)) + kMaxCreep_v;
    const double rate = std::max(std::fabs(m.rate_per_s.low - m.reference.rate_per_s),
                                 std::fabs(m.rate_per_s.high - m.reference.rate_per_s));
    double most_m = 0.0;
    for (const MotionCoefficients& c : m.wall)
        most_m = std::max(most_m, v * vectorLength(c.a1_m) + rate * vectorLength(c.a2_m_s));
    return most_m;
}

}  // namespace

DeformTableBuilder::DeformTableBuilder(const MotionModel& model, const DeformSettings& settings,
                                       const patient::Patient* seen)
    : model_(&model), settings_(settings) {
    const Grid box = motionBox(model, settings.spacing_m);
    Grid& grid = tables_.grid;
    grid = seen && !model.empty() ? cropped(box, seen->grid()) : box;
    // Nodes that are not computed do not move and lie outside the cavity.
    tables_.inside.assign(grid.voxelCount(), glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
    tables_.outside.assign(grid.voxelCount(), glm::vec4(0.0f));
    if (model.empty()) return;
    wall_.resize(model.grid.voxelCount());
    slide_.resize(wall_.size()), wall_displacements_.resize(wall_.size());
    far_m_ = 2.0 * glm::length(grid.spacing_m);
    findRuns(seen);
}

// For each row (y fastest): the range from the first to the last node next to a voxel of the body.
std::vector<DeformTableBuilder::NodeRun> DeformTableBuilder::findBodyRuns(
    const patient::Patient& seen) const {
    const Grid& grid = tables_.grid;
    const CtVolume& ct = seen.package().ct;
    const LabelVolume& labels = seen.package().labels;
    std::vector<NodeRun> body(std::size_t(grid.dims.y) * std::size_t(grid.dims.z), {0, grid.dims.x, 0});
    Index3 i;
    for (i.z = 0; i.z < ct.grid.dims.z; ++i.z)
        for (i.y = 0; i.y < ct.grid.dims.y; ++i.y) {
            const std::size_t at = ct.grid.offset({0, i.y, i.z});
            const auto solid = [&](int x) {
                return ct.voxels[at + std::size_t(x)] > kMinBodyHu || labels.voxels[at + std::size_t(x)] != 0;
            };
            int first = 0, last = ct.grid.dims.x - 1;
            while (first <= last && !solid(first))
                ++first;
            while (last > first && !solid(last))
                --last;
            if (first > last) continue;
            const Index3 low(glm::floor(grid.toVoxels(ct.grid.centre({first, i.y, i.z}))));
            const Index3 high(glm::ceil(grid.toVoxels(ct.grid.centre({last, i.y, i.z}))));
            for (int z = std::max(low.z, 0); z <= std::min(high.z, grid.dims.z - 1); ++z)
                for (int y = std::max(low.y, 0); y <= std::min(high.y, grid.dims.y - 1); ++y) {
                    NodeRun& row = body[std::size_t(z) * std::size_t(grid.dims.y) + std::size_t(y)];
                    row.begin = std::min(row.begin, low.x), row.end = std::max(row.end, high.x + 1);
                }
        }
    return body;
}

// Finds the nodes to compute: those that any breath can move into the cavity, and those that the wall's
// flow can move into the body.
void DeformTableBuilder::findRuns(const patient::Patient* seen) {
    const Grid& grid = tables_.grid;
    const std::vector<NodeRun> body = seen ? findBodyRuns(*seen) : std::vector<NodeRun>{};
    const double wall_m = maxOutside(*model_);
    const double least_m = std::min({grid.spacing_m.x, grid.spacing_m.y, grid.spacing_m.z});
    const int around = int(std::ceil(wall_m / least_m)) + 1;
    const auto bodyNear = [&](int y, int z) {
        if (!seen) return NodeRun{y, 0, grid.dims.x};
        NodeRun all{y, grid.dims.x, 0};
        for (int dz = std::max(0, z - around); dz <= std::min(grid.dims.z - 1, z + around); ++dz)
            for (int dy = std::max(0, y - around); dy <= std::min(grid.dims.y - 1, y + around); ++dy) {
                const NodeRun& row = body[std::size_t(dz) * std::size_t(grid.dims.y) + std::size_t(dy)];
                all.begin = std::min(all.begin, row.begin), all.end = std::max(all.end, row.end);
            }
        return NodeRun{y, all.begin - around, all.end + around};
    };
    // The factor 1.5 is used because the level may grow slightly faster than the distance.
    const double clear_m = far_m_ + 1.5 * wall_m;
    first_of_z_.assign(1, 0);
    for (int z = 0; z < grid.dims.z; ++z) {
        for (int y = 0; y < grid.dims.y; ++y) {
            const NodeRun near_body = bodyNear(y, z);
            NodeRun open{y, 0, 0};
            const auto close = [&](int end) {
                open.end = end;
                if (open.begin < end) runs_.push_back(open), made_ += std::size_t(end - open.begin);
            };
            bool making = false;
            for (int x = 0; x < grid.dims.x; ++x) {
                const bool far = patient::cavityLevel_m(*model_, grid.centre({x, y, z})) > clear_m;
                const bool make = !far || (x >= near_body.begin && x < near_body.end);
                if (making && (!make || far != open.far)) close(x), making = false;
                if (make && !making) open = {y, x, x, far}, making = true;
            }
            if (making) close(grid.dims.x);
        }
        first_of_z_.push_back(runs_.size());
    }
}

// Computes the fields of the current breath, and the bound of their displacement.
void DeformTableBuilder::setFields(const Surrogate& now, Workers& workers) {
    const MotionModel& m = *model_;
    const auto clampTo = [](const patient::SurrogateRange& r, double x) {
        return std::clamp(x, r.low, r.high);
    };
    const double v = clampTo(m.v, now.v) - m.reference.v + (now.creep_v - m.reference.creep_v);
    const double rate = clampTo(m.rate_per_s, now.rate_per_s) - m.reference.rate_per_s;
    const glm::vec3 by_v = glm::vec3(-v / m.grid.spacing_m), by_rate = glm::vec3(-rate / m.grid.spacing_m);
    const std::size_t slice = std::size_t(m.grid.dims.x) * std::size_t(m.grid.dims.y);
    const glm::vec3 metres(m.grid.spacing_m);
    std::atomic<float> max_wall{0.0f}, max_slide{0.0f};
    workers.run(std::size_t(m.grid.dims.z), [&](std::size_t z, int) {
        const auto fill = [&](const std::vector<MotionCoefficients>& from, std::vector<Node>& to,
                              std::atomic<float>& most) {
            float longest = 0.0f;
            for (std::size_t i = z * slice; i < (z + 1) * slice; ++i) {
                const MotionCoefficients& c = from[i];
                Node& n = to[i];
                n = {by_v.x * c.a1_m[0] + by_rate.x * c.a2_m_s[0],
                     by_v.y * c.a1_m[1] + by_rate.y * c.a2_m_s[1],
                     by_v.z * c.a1_m[2] + by_rate.z * c.a2_m_s[2], m.level_m[i]};
                const float x = n.x * metres.x, y = n.y * metres.y, w = n.z * metres.z;
                longest = std::max(longest, x * x + y * y + w * w);
            }
            float known = most.load(std::memory_order_relaxed);
            while (longest > known &&
                   !most.compare_exchange_weak(known, longest, std::memory_order_relaxed)) {
            }
        };
        fill(m.wall, wall_, max_wall);
        fill(m.slide, slide_, max_slide);
    });
    reach_m_ = std::sqrt(double(max_wall.load())) + std::sqrt(double(max_slide.load()));
}

void DeformTableBuilder::compute(const Surrogate& now, Workers& workers) {
    if (model_->empty()) return;
    setFields(now, workers);
    const Grid &grid = tables_.grid, &nodes_grid = model_->grid;
    const FlowNodes nodes{&wall_[0].x,     &wall_displacements_[0].x,       &slide_[0].x,
                          nodes_grid.dims, glm::vec3(nodes_grid.spacing_m), float(settings_.step_m),
                          float(far_m_)};
    const RowKernels rows = settings_.portable ? portableRows() : widestRows();
    // The wall's flow is needed only where the tables are.
    const Index3 low = glm::max(Index3(glm::floor(nodes_grid.toVoxels(grid.origin_m))), Index3(0));
    const Index3 high =
        glm::min(Index3(glm::ceil(nodes_grid.toVoxels(grid.centre(grid.dims - 1)))), nodes_grid.dims - 1);
    workers.run(std::size_t(high.z - low.z + 1), [&](std::size_t slice, int) {
        const int z = low.z + int(slice);
        for (int y = low.y; y <= high.y; ++y)
            rows.wall(nodes, glm::vec3(low.x, y, z), high.x - low.x + 1,
                      &wall_displacements_[nodes_grid.offset({low.x, y, z})].x);
    });
    const float step = float(grid.spacing_m.x / nodes_grid.spacing_m.x);
    workers.run(std::size_t(grid.dims.z), [&](std::size_t z, int) {
        for (std::size_t i = first_of_z_[z]; i < first_of_z_[z + 1]; ++i) {
            const NodeRun& s = runs_[i];
            const Index3 first(s.begin, s.y, int(z));
            const std::size_t at = grid.offset(first);
            rows.table(nodes, glm::vec3(nodes_grid.toVoxels(grid.centre(first))), step, s.end - s.begin,
                       s.far, &tables_.inside[at], &tables_.outside[at]);
        }
    });
}

DeformTables deformTables(const MotionModel& model, const Surrogate& now, const DeformSettings& settings,
                          int threads) {
    DeformTableBuilder maker(model, settings, nullptr);
    Workers workers(threads);
    maker.compute(now, workers);
    return maker.tables();
}

Vec3 referenceFromTables(const DeformTables& tables, const Vec3& deformed_m) {
    const glm::vec4 inside = tableAt(tables.grid, tables.inside, deformed_m);
    if (inside.w < 0.0f) return deformed_m + Vec3(inside);
    return deformed_m + Vec3(tableAt(tables.grid, tables.outside, deformed_m));
}

Vec3 referenceFromTables(const DeformTables& tables, const patient::DisplacementTable& tool,
                         const Vec3& displaced_m) {
    return referenceFromTables(tables, displaced_m - displacementAt(tool, displaced_m));
}

}  // namespace stylet::render
