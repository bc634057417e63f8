#include "patient/displacement/tool_displacement.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace stylet::patient {
namespace {

constexpr float kPull =
    // pull of a patch times its squared radius; makes its centre follow the tool by 98 %
    150.0f;
constexpr float kBoneStiffness = 1e5f;  // pull and stiffness of bone
constexpr float kFree = 1e-3f;          // stiffness of outer air and gas, relative to soft tissue
constexpr double kMinDisplacement_m = 2e-5;
constexpr double kBoxMargin_m = 0.024;  // of the box around the contacts
// the breathing motion is evaluated at every fourth node
constexpr int kMotionStride = 4;
// breathing changes below these move tissue by less than a voxel
constexpr double kStale_v = 0.04, kStaleRate_per_s = 0.4;
// limit of the gradient in one integration step; a step with gradient 1 would fold the map
constexpr float kMaxStepGradient = 0.4f;
// limit of the total difference between neighbouring nodes; avoids inverted cells in the table
constexpr float kMaxNodeDifference_m = 0.0045f;
constexpr float kStepsPerNode = 4.0f;

Vec3 springBack(const Vec3& last, const Vec3& target, double decay) {
    const double length_m = glm::length(last);
    if (length_m == 0.0) return target;
    const Vec3 along = last / length_m;
    return target + std::max(0.0, decay * length_m - glm::dot(target, along)) * along;
}

double maxDisplacement_m(const ToolContact& c) {
    return std::max(glm::length(c.begin_moved_m), glm::length(c.end_moved_m));
}

// Trilinear between nodes; `at` is in node units, inside the cube.
Lanes lanesAt(const DiffusionNode* nodes, int side, const glm::vec3& at) {
    const Index3 low = glm::clamp(Index3(at), Index3(0), Index3(side - 2));
    const glm::vec3 f = at - glm::vec3(low);
    const std::size_t row = std::size_t(side), slice = row * row;
    const DiffusionNode* const n =
        nodes + std::size_t(low.z) * slice + std::size_t(low.y) * row + std::size_t(low.x);
    const auto along = [&](const DiffusionNode* a) { return a[0].lanes + f.x * (a[1].lanes - a[0].lanes); };
    const auto face = [&](const DiffusionNode* a) {
        const Lanes near = along(a), far = along(a + row);
        return near + f.y * (far - near);
    };
    const Lanes near = face(n), far = face(n + slice);
    return near + f.z * (far - near);
}

// Stiffness relative to soft tissue; infinite for bone and cartilage.
float relativeStiffness(const Patient& patient, const Vec3& reference_m) {
    const TissueSample x = patient.at(reference_m, {.past_skin = true, .past_fascia = true});
    if (x.tissue == Tissue::air && x.label == 0) return kFree;
    const ElasticityTable& table = patient.package().elasticity;
    const double soft_pa = table[std::size_t(Tissue::soft)].young_pa;
    const double own_pa = table[std::size_t(x.tissue)].young_pa;
    if (!(soft_pa > 0.0) || !(own_pa > 0.0)) return 1.0f;
    return float(own_pa / soft_pa);
}

}  // namespace

Vec3 displacementAt(const DisplacementTable& table, const Vec3& p) noexcept {
    const Vec3 at = table.grid.toVoxels(p);
    const Index3 last = table.grid.dims - 1;
    if (!(at.x >= 0.0 && at.y >= 0.0 && at.z >= 0.0 && at.x <= last.x && at.y <= last.y && at.z <= last.z))
        return Vec3(0.0);
    const Index3 low = glm::min(Index3(at), last - 1);
    const glm::vec3 f(at - Vec3(low));
    const glm::vec4* const n = table.moved_m.data() + table.grid.offset(low);
    const std::size_t row = std::size_t(table.grid.dims.x), slice = row * std::size_t(table.grid.dims.y);
    const auto face = [&](const glm::vec4* a) {
        return glm::mix(glm::mix(a[0], a[1], f.x), glm::mix(a[row], a[row + 1], f.x), f.y);
    };
    return Vec3(glm::mix(face(n), face(n + slice), f.z));
}

ToolDisplacement::ToolDisplacement(const Patient& patient, const ToolDisplacementSettings& settings)
    : patient_(&patient), settings_(settings), diffusion_(settings.nodes) {
    table_.grid.dims = Index3(settings.nodes);
    table_.grid.spacing_m = Vec3(0.0);  // not placed yet
    table_.moved_m.assign(table_.grid.voxelCount(), glm::vec4(0.0f));
    bone_pull_.assign(table_.grid.voxelCount(), 0.0f);
}

bool ToolDisplacement::update(std::span<const ToolContact> contacts, const Surrogate& breath,
                              double dt_s) noexcept {
    relax(contacts, dt_s);
    active_ = std::any_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.used; });
    if (!active_) return false;
    const bool placed = place();
    const bool breathed =
        std::fabs(breath.v + breath.creep_v - tissue_breath_.v - tissue_breath_.creep_v) > kStale_v ||
        std::fabs(breath.rate_per_s - tissue_breath_.rate_per_s) > kStaleRate_per_s;
    if (placed || breathed) updateStiffness(breath);
    pull();
    // After a reset to zero, more cycles are needed.
    const int cycles = placed ? 4 * settings_.cycles : settings_.cycles;
    for (int i = 0; i < cycles; ++i)
        diffusion_.cycle(settings_.sweeps);
    invert();
    return true;
}

// Pressed tissue follows at once; released tissue springs back.
void ToolDisplacement::relax(std::span<const ToolContact> contacts, double dt_s) noexcept {
    const double decay = std::exp(-std::max(dt_s, 0.0) / settings_.recoil_s);
    std::array<bool, kMaxContacts> pressed{};
    for (const ToolContact& c : contacts) {
        assert(c.id >= 0 && c.id < kMaxContacts);
        Slot& slot = slots_[std::size_t(c.id)];
        ToolContact shown = c;
        if (slot.used) {
            shown.begin_moved_m = springBack(slot.contact.begin_moved_m, c.begin_moved_m, decay);
            shown.end_moved_m = springBack(slot.contact.end_moved_m, c.end_moved_m, decay);
        }
        slot = {shown, true};
        pressed[std::size_t(c.id)] = true;
    }
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = slots_[i];
        if (slot.used && !pressed[i]) slot.contact.begin_moved_m *= decay, slot.contact.end_moved_m *= decay;
        slot.used = slot.used && maxDisplacement_m(slot.contact) > kMinDisplacement_m;
    }
}

// Moves the box to the displaced tissue if that is no longer well inside it. Returns true if the box has
// moved.
bool ToolDisplacement::place() noexcept {
    Vec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const Slot& slot : slots_) {
        if (!slot.used) continue;
        low = glm::min(low, glm::min(slot.contact.begin_m, slot.contact.end_m));
        high = glm::max(high, glm::max(slot.contact.begin_m, slot.contact.end_m));
    }
    const Vec3 extent = high - low;
    const double needed_m = std::max({extent.x, extent.y, extent.z}) + 2.0 * kBoxMargin_m;
    const double usual_m = settings_.spacing_m * (settings_.nodes - 1);
    const double wider = std::max(1.0, std::ceil(4.0 * needed_m / usual_m) / 4.0);
    const double spacing_m = settings_.spacing_m * wider, half_m = 0.5 * usual_m * wider;
    Grid& grid = table_.grid;
    const Vec3 off = 0.5 * (low + high) - (grid.origin_m + half_m);
    const bool same =
        grid.spacing_m.x == spacing_m && std::max({std::fabs(off.x), std::fabs(off.y), std::fabs(off.z)}) <
                                             std::min(0.25 * half_m, 0.5 * kBoxMargin_m);
    if (same) return false;
    grid.spacing_m = Vec3(spacing_m);
    grid.origin_m = 0.5 * (low + high) - half_m;
    diffusion_.clear();
    std::fill(table_.moved_m.begin(), table_.moved_m.end(), glm::vec4(0.0f));
    return true;
}

// Looks up the stiffness at every node. The breathing motion is evaluated at every fourth node, for both
// sides, and interpolated linearly.
void ToolDisplacement::updateStiffness(const Surrogate& breath) noexcept {
    const MotionModel& motion = patient_->package().motion;
    const Grid& grid = table_.grid;
    std::vector<float>& stiffness = diffusion_.stiffness();
    struct Corner {
        Vec3 inside_m, outside_m;
        double level_m;
    };
    const auto cornerAt = [&](const Index3& i) {
        const Vec3 p = grid.centre(i);
        return Corner{referenceFromDeformed(motion, breath, Side::inside, p),
                      referenceFromDeformed(motion, breath, Side::outside, p),
                      cavityLevel_m(motion, breath, p)};
    };
    Index3 cell;
    for (cell.z = 0; cell.z < grid.dims.z - 1; cell.z += kMotionStride)
        for (cell.y = 0; cell.y < grid.dims.y - 1; cell.y += kMotionStride) {
            std::array<Corner, 8> c;
            for (int k = 0; k < 4; ++k)
                c[std::size_t(2 * k + 1)] =
                    cornerAt(cell * Index3(0, 1, 1) + kMotionStride * Index3(0, k & 1, k >> 1));
            for (cell.x = 0; cell.x < grid.dims.x - 1; cell.x += kMotionStride) {
                for (int k = 0; k < 4; ++k) {
                    c[std::size_t(2 * k)] = c[std::size_t(2 * k + 1)];
                    c[std::size_t(2 * k + 1)] = cornerAt(cell + kMotionStride * Index3(1, k & 1, k >> 1));
                }
                // Each cell covers only its near faces; the far faces belong to the next cell. The box's far
                // faces are not used.
                forEachVoxel(Index3(0), Index3(kMotionStride - 1), [&](const Index3& in) {
                    const Vec3 f = Vec3(in) / double(kMotionStride);
                    Vec3 inside_m(0.0), outside_m(0.0);
                    double level_m = 0.0;
                    for (int k = 0; k < 8; ++k) {
                        const Corner& a = c[std::size_t(k)];
                        const double weight =
                            (k & 1 ? f.x : 1.0 - f.x) * (k & 2 ? f.y : 1.0 - f.y) * (k & 4 ? f.z : 1.0 - f.z);
                        inside_m += weight * a.inside_m, outside_m += weight * a.outside_m;
                        level_m += weight * a.level_m;
                    }
                    const float k = relativeStiffness(*patient_, level_m < 0.0 ? inside_m : outside_m);
                    const std::size_t at = grid.offset(cell + in);
                    bone_pull_[at] = std::isinf(k) ? kBoneStiffness : 0.0f;
                    stiffness[at] = std::isinf(k) ? kBoneStiffness : k;
                });
            }
        }
    diffusion_.prepareStiffness();
    tissue_breath_ = breath;
}

void ToolDisplacement::pull() noexcept {
    diffusion_.resetPull(bone_pull_);
    for (const Slot& slot : slots_)
        if (slot.used) pull(slot.contact);
    diffusion_.preparePull();
}

// Centres the pull half way along the displacement, because invert() follows the whole displacement.
void ToolDisplacement::pull(const ToolContact& c) noexcept {
    const Grid& grid = table_.grid;
    const double radius_m = std::max({c.radius_m, 1.5 * maxDisplacement_m(c), 1.5 * grid.spacing_m.x});
    const double pull = kPull * grid.spacing_m.x * grid.spacing_m.x / (radius_m * radius_m);
    const Vec3 begin_m = c.begin_m + 0.5 * c.begin_moved_m, end_m = c.end_m + 0.5 * c.end_moved_m;
    const Vec3 along_m = end_m - begin_m;
    const double square = std::max(glm::dot(along_m, along_m), 1e-18);
    const Vec3 low = glm::ceil(grid.toVoxels(glm::min(begin_m, end_m) - radius_m));
    const Vec3 high = glm::floor(grid.toVoxels(glm::max(begin_m, end_m) + radius_m));
    const Index3 first(glm::max(low, Vec3(1.0))), last(glm::min(high, Vec3(grid.dims - 2)));
    forEachVoxel(first, last, [&](const Index3& i) {
        const Vec3 p = grid.centre(i) - begin_m;
        const double share = std::clamp(glm::dot(p, along_m) / square, 0.0, 1.0);
        const Vec3 beside = (p - share * along_m) / radius_m;
        const double inner = 1.0 - glm::dot(beside, beside);
        if (inner > 0.0)
            diffusion_.addPull(grid.offset(i), float(pull * inner * inner),
                               glm::vec3(glm::mix(c.begin_moved_m, c.end_moved_m, share)));
    });
}

// Integrates backwards along the displacement field. So every point has exactly one origin, however steep the
// field is.
void ToolDisplacement::invert() noexcept {
    const Grid& grid = table_.grid;
    const int n = settings_.nodes;
    const DiffusionNode* const u = diffusion_.solution().data();
    const float metres = float(grid.spacing_m.x);
    // The field is steeper than the limit only if a tool is inside bone or cartilage. The displacement is
    // then scaled down.
    const float steepest_m = diffusion_.maxDifference(),
                share = std::min(1.0f, kMaxNodeDifference_m / steepest_m);
    const int max_steps = std::max(1, int(std::ceil(share * steepest_m / (metres * kMaxStepGradient))));
    const auto stepAt = [&](const glm::vec3& at, float per_m) {
        const Lanes by = lanesAt(u, n, at) * per_m;
        return glm::vec3(by[0], by[1], by[2]);
    };
    forEachVoxel(Index3(1), Index3(n - 2), [&](const Index3& i) {
        const glm::vec3 now(i);
        glm::vec3 then = now, by = stepAt(then, share / metres);
        // Displacements that are small relative to the node spacing need few steps.
        const int steps = std::min(max_steps, 1 + int(kStepsPerNode * glm::length(by)));
        const float per_m = share / (metres * float(steps));
        by /= float(steps);
        for (int step = 1;; ++step) {
            then -= stepAt(then - 0.5f * by, per_m);
            if (step == steps) break;
            by = stepAt(then, per_m);
        }
        table_.moved_m[grid.offset(i)] = glm::vec4((now - then) * metres, 0.0f);
    });
}

}  // namespace stylet::patient
