#include "patient/contrast/vessel_flow.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/parallel.h"
#include "base/transcendental.h"

namespace stylet::patient {

namespace {

constexpr double kTau = 6.283185307179586;
constexpr double kVesselMargin_m = 0.04;  // length of the great vessels around the liver that is included
constexpr double kLiverFilter_m = 0.01;

bool isLiver(const Label* label) {
    return label && (label->tissue == Tissue::liver || label->tissue == Tissue::duct);
}

std::size_t findWidest(const VesselTree& tree, const auto& eligible) {
    std::size_t widest = tree.piece.size();
    for (std::size_t m = 0; m < tree.piece.size(); ++m)
        if (eligible(m) && (widest == tree.piece.size() || tree.radius_m[m] > tree.radius_m[widest]))
            widest = m;
    return widest;
}

// The eligible members within one lumen radius of the widest one: the cross-section where orient() starts.
std::vector<PathStart> findCrossSection(const VesselTree& tree, const auto& eligible) {
    const std::size_t widest = findWidest(tree, eligible);
    std::vector<PathStart> section;
    if (widest == tree.piece.size()) return section;
    const Vec3 middle = tree.piece.centre(widest);
    for (std::size_t m = 0; m < tree.piece.size(); ++m)
        if (eligible(m) && glm::distance(tree.piece.centre(m), middle) <= 1.5 * tree.radius_m[widest])
            section.push_back({m, 0.0});
    return section;
}

// Box filter of a mask. Returns the mask's share of each voxel's surroundings.
Volume<float> averaged(Volume<float> values, double window_m) {
    std::vector<double> sums;
    for (int axis = 0; axis < 3; ++axis) {
        const int reach = std::max(1, int(window_m / values.grid.spacing_m[axis]));
        parallelLines(1, values.grid.dims, axis, values.voxels.data(),
                      [&](float* first, std::size_t stride, std::size_t count) {
                          sums.assign(count + 1, 0.0);
                          for (std::size_t i = 0; i < count; ++i)
                              sums[i + 1] = sums[i] + double(first[i * stride]);
                          for (std::size_t i = 0; i < count; ++i) {
                              const std::size_t low = i - std::min(i, std::size_t(reach));
                              const std::size_t high = std::min(count, i + std::size_t(reach) + 1);
                              first[i * stride] = float((sums[high] - sums[low]) / double(high - low));
                          }
                      });
    }
    return values;
}

// Marks the members outside the liver: less than half of their surroundings is liver. Vessel voxels are not
// counted.
std::vector<bool> outsideLiver(const Patient& patient, const VesselTree& tree) {
    const Grid& grid = patient.grid();
    Volume<float> liver(tree.piece.box, 0.0f), counted(tree.piece.box, 0.0f);
    forEachVoxel(tree.piece.box, [&](const Index3& in_box) {
        const Index3 i = tree.piece.low + in_box;
        if (!grid.contains(i)) return;
        const Label* label = patient.label(patient.package().labels[i]);
        if (label && label->tissue == Tissue::vessel) return;
        counted[in_box] = 1.0f;
        liver[in_box] = isLiver(label) ? 1.0f : 0.0f;
    });
    liver = averaged(std::move(liver), kLiverFilter_m);
    counted = averaged(std::move(counted), kLiverFilter_m);
    std::vector<bool> outside(tree.piece.size());
    for (std::size_t m = 0; m < tree.piece.size(); ++m) {
        const std::uint32_t offset = tree.piece.offsets[m];
        outside[m] = liver.voxels[offset] < 0.5f * counted.voxels[offset];
    }
    return outside;
}

// The connected parts of the members marked in `in`, largest first.
std::vector<std::vector<std::size_t>> connectedParts(const VoxelPiece& piece, const std::vector<bool>& in) {
    const std::vector<std::int32_t>& member = piece.member.voxels;
    const auto connects = [&](std::size_t offset) {
        return member[offset] != VoxelPiece::kNone && in[std::size_t(member[offset])];
    };
    std::vector<std::vector<std::size_t>> parts;
    std::vector<bool> seen(member.size());
    for (const std::uint32_t seed : piece.offsets) {
        if (!connects(seed) || seen[seed]) continue;
        for (std::size_t& m : parts.emplace_back(connectedVoxels(piece.box, seed, connects, seen)))
            m = std::size_t(member[m]);
    }
    std::sort(parts.begin(), parts.end(), [](const auto& one, const auto& two) {
        return one.size() > two.size() || (one.size() == two.size() && one.front() < two.front());
    });
    return parts;
}

// Marks the members of the largest of these parts.
std::vector<bool> largestPart(const VoxelPiece& piece, const std::vector<bool>& in) {
    std::vector<bool> largest(piece.size());
    if (const auto parts = connectedParts(piece, in); !parts.empty())
        for (const std::size_t m : parts.front())
            largest[m] = true;
    return largest;
}

// Finds the hilum, where the portal trunk enters the liver. Updates `outside`: true for members upstream of
// the hilum, whose blood flows toward it. Returns nothing if the whole vein is inside the liver.
std::vector<PathStart> findHilum(const VesselTree& tree, std::vector<bool>& outside) {
    const VoxelPiece& piece = tree.piece;
    const std::vector<Neighbour> around = neighbours(piece.box);
    const std::vector<bool> trunk = largestPart(piece, outside);
    std::vector<bool> rest(piece.size());
    for (std::size_t m = 0; m < piece.size(); ++m)
        rest[m] = !outside[m];
    const std::vector<bool> branches = largestPart(piece, rest);
    const std::vector<PathStart> hilum = findCrossSection(tree, [&](std::size_t m) {
        return trunk[m] && std::any_of(around.begin(), around.end(), [&](const Neighbour& n) {
                   const std::int32_t other = piece.neighbour(m, n);
                   return other != VoxelPiece::kNone && branches[std::size_t(other)];
               });
    });
    // Below, a cut at the hilum divides the vein into parts. Each part counts as outside or inside as a
    // whole.
    if (hilum.empty()) return outside.assign(piece.size(), false), hilum;
    Vec3 middle(0.0);
    double radius_m = 0.0;
    for (const PathStart& start : hilum) {
        middle += piece.centre(start.member) / double(hilum.size());
        radius_m = std::max(radius_m, tree.radius_m[start.member]);
    }
    const auto beyond = [&](const std::vector<std::size_t>& part) {
        return std::size_t(
            std::count_if(part.begin(), part.end(), [&](std::size_t m) { return outside[m]; }));
    };
    std::vector<bool> toward = trunk;
    for (const double cut : {1.5, 2.0, 2.5, 3.0}) {
        for (std::size_t m = 0; m < piece.size(); ++m)
            rest[m] = glm::distance(piece.centre(m), middle) > cut * radius_m;
        const std::vector<std::vector<std::size_t>> parts = connectedParts(piece, rest);
        // If the largest part still contains both trunk and branches, remove more around the hilum.
        const std::size_t whole = parts.empty() ? 0 : beyond(parts.front());
        if (parts.empty() || std::min(whole, parts.front().size() - whole) * 4 > parts.front().size())
            continue;
        for (const std::vector<std::size_t>& part : parts) {
            const bool lies_outside = 2 * beyond(part) > part.size();
            for (const std::size_t m : part)
                toward[m] = lies_outside;
        }
        break;
    }
    outside = std::move(toward);
    return hilum;
}

// The end toward the heart: the highest slice in which the vessel is wide.
std::vector<PathStart> findHeartEnd(const VesselTree& tree) {
    int top = 0;
    double widest_m = 0.0;
    for (std::size_t m = 0; m < tree.piece.size(); ++m) {
        top = std::max(top, tree.piece.voxel(m).z);
        widest_m = std::max(widest_m, tree.radius_m[m]);
    }
    return findCrossSection(tree, [&](std::size_t m) {
        return tree.piece.voxel(m).z == top && tree.radius_m[m] >= 0.5 * widest_m;
    });
}

// Fills along_m with the distance from the root's cross-section. It is negative where blood flows toward the
// root.
void orient(const Patient& patient, VesselTree& tree) {
    std::vector<PathStart> root;
    std::vector<bool> toward_root(tree.piece.size(), false);
    if (tree.kind == BloodKind::portal) {
        toward_root = outsideLiver(patient, tree);
        root = findHilum(tree, toward_root);
    } else if (tree.kind == BloodKind::hepatic) {
        root = findCrossSection(tree, [&](std::size_t m) {
            return touches(patient, tree.piece.voxel(m),
                           [](const Label& l) { return l.blood == BloodKind::cava; });
        });
        toward_root.assign(tree.piece.size(), true);
    } else if (tree.kind == BloodKind::cava || tree.kind == BloodKind::artery) {
        root = findHeartEnd(tree);
        toward_root.assign(tree.piece.size(), tree.kind == BloodKind::cava);
    }
    if (root.empty()) root = findCrossSection(tree, [](std::size_t) { return true; });
    for (const PathStart& start : root)
        tree.root_m += tree.piece.centre(start.member) / double(root.size());
    tree.along_m = geodesic_m(tree.piece, root);
    for (std::size_t m = 0; m < tree.piece.size(); ++m)
        if (toward_root[m]) tree.along_m[m] = -tree.along_m[m];
}

// Computes the box that makeVesselFlow() covers: the liver and its vessels. Returns false if it is empty.
bool computeFlowBox(const Patient& patient, const std::vector<VesselTree>& trees, Index3& low, Index3& high) {
    const Grid& grid = patient.grid();
    Index3 liver_low(std::numeric_limits<int>::max()), liver_high(std::numeric_limits<int>::min());
    forEachVoxel(grid, [&](const Index3& i) {
        if (isLiver(patient.label(patient.package().labels[i])))
            liver_low = glm::min(liver_low, i), liver_high = glm::max(liver_high, i);
    });
    low = Index3(std::numeric_limits<int>::max()), high = Index3(std::numeric_limits<int>::min());
    for (const VesselTree& tree : trees) {
        low = glm::min(low, tree.piece.low);
        high = glm::max(high, tree.piece.low + tree.piece.box.dims - 1);
    }
    if (liver_low.x <= liver_high.x) {
        const Index3 margin(Vec3(kVesselMargin_m) / grid.spacing_m);
        low = glm::max(low, liver_low - margin), high = glm::min(high, liver_high + margin);
    }
    low = glm::max(low, Index3(0)), high = glm::min(high, grid.dims - 1);
    return low.x <= high.x && low.y <= high.y && low.z <= high.z;
}

void write(const VesselTree& tree, const Index3& low, VesselFlow& flow) {
    for (std::size_t m = 0; m < tree.piece.size(); ++m) {
        const Index3 i = tree.piece.voxel(m) - low;
        if (!flow.grid.contains(i)) continue;
        // 0 at the wall, 1 in the middle, where the speed is twice the mean (Poiseuille).
        const double toward_middle = std::clamp(tree.wall_m[m] / tree.radius_m[m], 0.0, 1.0);
        const double from_middle = 1.0 - toward_middle;
        const double speed_m_per_s = 2.0 * tree.mean_m_per_s[m] * (1.0 - from_middle * from_middle);
        const Vec3 velocity = bloodDirection(tree, m) * (speed_m_per_s / flow.scale_m_per_s * 32767.0);
        std::array<std::int16_t, 4>& voxel = flow.velocity[flow.grid.offset(i)];
        for (int axis = 0; axis < 3; ++axis)
            voxel[std::size_t(axis)] = std::int16_t(std::floor(velocity[axis] + 0.5));
        voxel[3] = std::int16_t(kBloodKindStep * int(tree.kind));
    }
}

// Raised cosine: 1 at `middle`, 0 at a distance of `half` or more. Its mean over the beat is `half`.
double bump(double phase, double middle, double half) noexcept {
    const double away = std::fabs(phase - middle);
    if (away >= half) return 0.0;
    return 0.5 + 0.5 * detCos(0.5 * kTau * away / half);
}

}  // namespace

bool touches(const Patient& patient, const Index3& voxel, const std::function<bool(const Label&)>& wanted) {
    bool found = false;
    forEachVoxel(voxel - 1, voxel + 1, [&](const Index3& i) {
        if (found || !patient.grid().contains(i)) return;
        const Label* label = patient.label(patient.package().labels[i]);
        found = label && wanted(*label);
    });
    return found;
}

VesselTree makeVesselTree(const Patient& patient, BloodKind kind, VoxelPiece piece,
                          const VesselFlowSettings& settings) {
    VesselTree tree;
    tree.kind = kind;
    tree.piece = std::move(piece);
    tree.wall_m = wallDistance_m(tree.piece);
    tree.radius_m = lumenRadius_m(tree.piece, tree.wall_m);
    orient(patient, tree);
    const double widest_m = *std::max_element(tree.radius_m.begin(), tree.radius_m.end());
    tree.mean_m_per_s.reserve(tree.piece.size());
    for (const double radius_m : tree.radius_m)
        tree.mean_m_per_s.push_back(settings.trunk_m_per_s[std::size_t(kind)] *
                                    std::max(settings.slowest_share, radius_m / widest_m));
    return tree;
}

Vec3 bloodDirection(const VesselTree& tree, std::size_t m) {
    constexpr int kReach = 2;
    const Vec3& h = tree.piece.box.spacing_m;
    const Index3 at = tree.piece.voxel(m);
    Vec3 sum(0.0);
    forEachVoxel(Index3(-kReach), Index3(kReach), [&](const Index3& step) {
        const std::int32_t other = tree.piece.at(at + step);
        if (other == VoxelPiece::kNone || std::size_t(other) == m) return;
        const Vec3 offset_m = h * Vec3(step);
        const double length2 = glm::dot(offset_m, offset_m);
        const double gain = tree.along_m[std::size_t(other)] - tree.along_m[m];
        // A larger difference means that the neighbour belongs to another branch alongside.
        if (gain * gain <= 2.0 * length2) sum += offset_m * (gain / length2);
    });
    const double length = std::sqrt(glm::dot(sum, sum));
    return length > 0.0 ? sum / length : Vec3(0.0);
}

Vec3 VesselFlow::meanAt_m_per_s(const Vec3& reference_m) const noexcept {
    const Index3 i = grid.nearest(reference_m);
    if (velocity.empty() || !grid.contains(i)) return Vec3(0.0);
    const std::array<std::int16_t, 4>& v = velocity[grid.offset(i)];
    return Vec3(v[0], v[1], v[2]) * (scale_m_per_s / 32767.0);
}

VesselFlow makeVesselFlow(const Patient& patient, const VesselFlowSettings& settings, int threads) {
    LabelSet wanted{};
    for (const Label& label : patient.package().label_table)
        wanted[label.id] = label.blood != BloodKind::none;
    std::vector<VoxelPiece> pieces = connectedPieces(patient.package().labels, wanted);
    std::vector<VesselTree> trees(pieces.size());
    parallelFor(threads, pieces.size(), [&](std::size_t i) {
        const Label* label = patient.label(patient.package().labels[pieces[i].voxel(0)]);
        trees[i] = makeVesselTree(patient, label->blood, std::move(pieces[i]), settings);
    });
    VesselFlow flow;
    flow.scale_m_per_s =
        2.0 * *std::max_element(settings.trunk_m_per_s.begin(), settings.trunk_m_per_s.end());
    Index3 low, high;
    if (trees.empty() || !computeFlowBox(patient, trees, low, high)) return flow;
    flow.grid = {high - low + 1, patient.grid().spacing_m, patient.grid().centre(low)};
    flow.velocity.resize(flow.grid.voxelCount());
    parallelFor(threads, trees.size(), [&](std::size_t i) { write(trees[i], low, flow); });
    return flow;
}

double pulse(BloodKind kind, double t_s, double beats_per_s) noexcept {
    const double beats = t_s * beats_per_s;
    if (!(std::fabs(beats) < 1e9)) return 1.0;
    const double phase = beats - std::floor(beats);
    switch (kind) {
        case BloodKind::portal:
            return 1.0 + 0.12 * detCos(kTau * (phase - 0.25));
        case BloodKind::hepatic:
        case BloodKind::cava: {
            constexpr double kSystolic = 1.75, kDiastolic = 1.1, kAtrial = 0.85;
            constexpr double kSteady = 1.0 - 0.18 * (kSystolic + kDiastolic) + 0.08 * kAtrial;
            return kSteady + kSystolic * bump(phase, 0.22, 0.18) + kDiastolic * bump(phase, 0.58, 0.18) -
                   kAtrial * bump(phase, 0.90, 0.08);
        }
        case BloodKind::artery: {
            // Steep rise, cubic fall. The mean is end-diastole plus 0.2875 of the rise to the peak.
            constexpr double kRise = 0.15, kPeak = 1.0 / (0.3 + 0.7 * 0.2875);
            const double fall = (1.0 - phase) / (1.0 - kRise);
            const double share =
                phase < kRise ? 0.5 - 0.5 * detCos(0.5 * kTau * phase / kRise) : fall * fall * fall;
            return kPeak * (0.3 + 0.7 * share);
        }
        case BloodKind::none:
        case BloodKind::other:
            break;
    }
    return 1.0;
}

}  // namespace stylet::patient
