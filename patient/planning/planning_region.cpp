#include "patient/planning/planning_region.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "base/distance.h"
#include "base/geodesic.h"
#include "base/parallel.h"

namespace stylet::patient {
namespace {

constexpr double kClearanceMargin_m = 0.012;  // more than 10 mm, where the clearance score saturates
// The axillary lines lie at this share of the torso's half depth in front of and behind its middle. On an
// elliptic torso this is 30 degrees to either side of the most lateral line.
constexpr double kAxillaryLine = 0.5;
constexpr float kUnderRibShare = 0.5f;
constexpr double kInsideLiver_m = 0.030;
// Largest vertical distance between neighbouring ribs, which corresponds to a gap of 25 mm across sloping
// ribs.
constexpr double kNextRib_m = 0.035;
// The chest wall leans, so the next rib may be this far beside the vertical line.
constexpr double kRibLean_m = 0.010;

// Properties of one voxel of the deformed patient.
enum Mark : std::uint8_t { kFilled = 1, kRisk = 2, kBone = 4, kLiver = 8, kBody = 16, kOutside = 32 };

struct Box {
    Vec3 low{1e9}, high{-1e9};
    bool empty() const { return low.x > high.x; }
    void add(const Vec3& p) { low = glm::min(low, p), high = glm::max(high, p); }
};

LabelSet labelsWithTissue(const Patient& patient, Tissue tissue) {
    LabelSet ids{};
    for (const Label& label : patient.package().label_table)
        ids[label.id] = label.tissue == tissue;
    return ids;
}

Box deformedLiver(const Patient& patient, const Surrogate& breath) {
    const LabelSet is_liver = labelsWithTissue(patient, Tissue::liver);
    const Package& p = patient.package();
    Box box;
    forEachVoxel(p.labels.grid, [&](const Index3& i) {
        if (is_liver[p.labels[i]]) box.add(deformedFromReference(p.motion, breath, p.labels.grid.centre(i)));
    });
    return box;
}

// The part of the patient's grid that planning needs: from left of the liver to the right end of the
// image.
Grid cropAround(const Grid& whole, const Box& liver) {
    const Index3 last = whole.dims - 1;
    const double left_m = liver.low.x - kBeyondTarget_m - kClearanceMargin_m;
    Index3 low = whole.nearest({left_m, whole.origin_m.y, liver.low.z - kClearanceMargin_m});
    Index3 high = whole.nearest({left_m, whole.origin_m.y, liver.high.z + kClearanceMargin_m});
    low = glm::clamp(low, Index3(0), last);
    high = {last.x, last.y, std::clamp(high.z, 0, last.z)};
    return {high - low + 1, whole.spacing_m, whole.centre(low)};
}

// Past the fascia, bone begins at a higher CT value. There the voxels between the two thresholds are
// contrast-filled vessels, which are also risk structures. So one threshold is enough.
std::uint8_t markVoxel(const Patient& patient, const Index3& i) noexcept {
    const Package& p = patient.package();
    if (!p.ct.grid.contains(i)) return 0;
    if (const Label* label = patient.label(p.labels[i])) {
        const bool risk = label->role == Role::risk;
        return std::uint8_t((label->tissue != Tissue::air || risk ? kFilled : 0) | (risk ? kRisk : 0) |
                            (isSkeleton(label->tissue) ? kBone : 0) |
                            (label->tissue == Tissue::liver ? kLiver : 0));
    }
    const double ct_hu = p.ct[i];
    if (ct_hu < p.thresholds.t0_hu) return 0;
    return ct_hu < p.thresholds.t2_sensitive_hu ? kFilled : kFilled | kRisk | kBone;
}

Volume<std::uint8_t> markDeformed(const Patient& patient, const Surrogate& breath, const Grid& crop,
                                  int threads) {
    Volume<std::uint8_t> marks(crop);
    const MotionModel& motion = patient.package().motion;
    parallelVoxels(threads, crop, [&](const Index3& i) {
        const Vec3 reference_m = referenceFromDeformed(motion, breath, crop.centre(i));
        marks[i] = markVoxel(patient, patient.grid().nearest(reference_m));
    });
    return marks;
}

// Sets `mark` on every voxel connected to `open` through voxels accepted by `through`.
template <typename Through>
void floodMarks(Volume<std::uint8_t>& marks, std::vector<Index3> open, std::uint8_t mark,
                const Through& through) {
    floodFaces(marks.grid, std::move(open), [&](const Index3& i) {
        if ((marks[i] & mark) || !through(marks[i])) return false;
        marks[i] |= mark;
        return true;
    });
}

// The body is everything connected to the liver, so a table does not belong to it. Outside air is air
// connected to the image's right, front or back side. Other air is gas or lung, which is a risk.
void classifyBodyAndAir(Volume<std::uint8_t>& marks) {
    const Index3 last = marks.grid.dims - 1;
    std::vector<Index3> liver, air;
    forEachVoxel(marks.grid, [&](const Index3& i) {
        std::uint8_t& m = marks[i];
        if (m & kLiver) m |= kBody, liver.push_back(i);
        if (!(m & kFilled) && (i.x == last.x || i.y == 0 || i.y == last.y)) m |= kOutside, air.push_back(i);
    });
    floodMarks(marks, std::move(liver), kBody, [](std::uint8_t m) { return (m & kFilled) != 0; });
    floodMarks(marks, std::move(air), kOutside, [](std::uint8_t m) { return (m & kFilled) == 0; });
    for (std::uint8_t& m : marks.voxels)
        if (!(m & (kFilled | kOutside))) m |= kRisk;
}

Volume<std::uint8_t> riskMask(const Volume<std::uint8_t>& marks) {
    Volume<std::uint8_t> mask(marks.grid);
    std::transform(marks.voxels.begin(), marks.voxels.end(), mask.voxels.begin(),
                   [](std::uint8_t m) { return std::uint8_t(m & kRisk); });
    return mask;
}

// Marks the voxels closer to an uncertain risk structure, or to a suspect, than its border is certain.
// Structures with the same uncertainty share one distance transform.
Volume<std::uint8_t> uncertainMask(const Patient& patient, const Surrogate& breath, const Grid& crop,
                                   int threads) {
    std::map<double, LabelSet> groups;
    for (const Label& label : patient.package().label_table)
        if ((label.role == Role::risk || label.role == Role::suspect) && label.border_uncertainty_m > 0.0)
            groups.try_emplace(label.border_uncertainty_m).first->second[label.id] = true;
    if (groups.empty()) return {};
    const Package& p = patient.package();
    Volume<std::uint8_t> ids(crop), mask(crop);
    parallelVoxels(threads, crop, [&](const Index3& i) {
        ids[i] = p.labels.nearestOr(referenceFromDeformed(p.motion, breath, crop.centre(i)), 0);
    });
    const Vec3 s = crop.spacing_m;
    const float half_voxel_m = float(0.5 * std::max({s.x, s.y, s.z}));
    const auto rank = [](float distance, double uncertainty) {
        return std::uint8_t((distance < float(uncertainty)) +
                            (distance < float(std::min(uncertainty, kNearUncertainty_m))));
    };
    for (const auto& [uncertainty_m, is_member] : groups) {
        Volume<std::uint8_t> members(crop);
        for (std::size_t i = 0; i < ids.voxels.size(); ++i)
            members.voxels[i] = is_member[ids.voxels[i]];
        const Volume<float> distance_m = distanceTo(members, Sites::all, threads);
        for (std::size_t i = 0; i < mask.voxels.size(); ++i)
            mask.voxels[i] =
                std::max(mask.voxels[i], rank(distance_m.voxels[i] - half_voxel_m, uncertainty_m));
    }
    return mask;
}

// Marks the lower edges of ribs, where nerve and vessels run in a groove: bone voxels without bone below.
Volume<std::uint8_t> lowerEdgeMask(const Volume<std::uint8_t>& marks) {
    Volume<std::uint8_t> mask(marks.grid);
    const std::size_t below = marks.grid.offset({0, 0, 1});
    for (std::size_t i = below; i < marks.voxels.size(); ++i)
        mask.voxels[i] = (marks.voxels[i] & kBone) && !(marks.voxels[i - below] & kBone);
    return mask;
}

Volume<float> clearances(const Volume<std::uint8_t>& marks, int threads) {
    const Vec3 spacing_m = marks.grid.spacing_m;
    const float half_voxel_m = float(0.5 * std::max({spacing_m.x, spacing_m.y, spacing_m.z}));
    Volume<float> clearance_m = distanceTo(riskMask(marks), Sites::all, threads);
    const Volume<float> rib_m = distanceTo(lowerEdgeMask(marks), Sites::above, threads);
    for (std::size_t i = 0; i < marks.voxels.size(); ++i)
        clearance_m.voxels[i] =
            std::min(clearance_m.voxels[i] - half_voxel_m, kUnderRibShare * (rib_m.voxels[i] - half_voxel_m));
    return clearance_m;
}

// Bone, widened along x within each slice by the distance that the next rib may lean.
Volume<std::uint8_t> leaningBone(const Volume<std::uint8_t>& marks) {
    Volume<std::uint8_t> wide(marks.grid);
    const int reach = int(kRibLean_m / marks.grid.spacing_m.x);
    forEachVoxel(marks.grid, [&](const Index3& i) {
        if (!(marks[i] & kBone)) return;
        const int low = std::max(0, i.x - reach), high = std::min(marks.grid.dims.x - 1, i.x + reach);
        std::fill_n(wide.voxels.begin() + std::ptrdiff_t(wide.grid.offset({low, i.y, i.z})), high - low + 1,
                    1);
    });
    return wide;
}

Volume<std::uint8_t> intercostalMask(const Volume<std::uint8_t>& marks) {
    const Volume<std::uint8_t> bone = leaningBone(marks);
    if (std::none_of(bone.voxels.begin(), bone.voxels.end(), [](std::uint8_t b) { return b != 0; }))
        return {};
    Volume<std::uint8_t> mask(marks.grid);
    const Index3 dims = marks.grid.dims;
    const int near = int(kNextRib_m / marks.grid.spacing_m.z);
    for (int y = 0; y < dims.y; ++y)
        for (int x = 0; x < dims.x; ++x)
            for (int z = 1, below = -dims.z; z < dims.z; ++z) {
                if (bone[{x, y, z - 1}]) below = z - 1;
                if (bone[{x, y, z}] || z - below > near) continue;
                for (int up = z + 1; up < std::min(dims.z, below + near + 1) && !mask[{x, y, z}]; ++up)
                    mask[{x, y, z}] = bone[{x, y, up}];
            }
    return mask;
}

// y indices of the front and the back of the body in one slice.
struct Depth {
    int back = -1, front = -1;
};
Depth bodyDepth(const Volume<std::uint8_t>& marks, int z) {
    Depth depth;
    for (int y = 0; y < marks.grid.dims.y; ++y) {
        const std::uint8_t* const row = marks.voxels.data() + marks.grid.offset({0, y, z});
        if (std::none_of(row, row + marks.grid.dims.x, [](std::uint8_t m) { return m & kBody; })) continue;
        if (depth.back < 0) depth.back = y;
        depth.front = y;
    }
    return depth;
}

double findBack(const Volume<std::uint8_t>& marks) {
    double lowest_m = marks.grid.centre(marks.grid.dims).y;
    forEachVoxel(marks.grid, [&](const Index3& i) {
        if (marks[i] & kBody) lowest_m = std::min(lowest_m, marks.grid.centre(i).y);
    });
    return lowest_m;
}

// The first voxel from the right that is not outside air. Returns nothing if it is not part of the body or if
// the image cuts off the body.
std::optional<Index3> firstSkinVoxel(const Volume<std::uint8_t>& marks, int y, int z) {
    const int last = marks.grid.dims.x - 1;
    Index3 i{last, y, z};
    while (i.x >= 0 && (marks[i] & kOutside))
        --i.x;
    if (i.x < 0 || i.x == last || !(marks[i] & kBody)) return std::nullopt;
    return i;
}

std::vector<Vec3> skinEntries(const Volume<std::uint8_t>& marks, const Box& liver, double spacing_m) {
    const Grid& grid = marks.grid;
    const int step_y = std::max(1, int(std::lround(spacing_m / grid.spacing_m.y)));
    const int step_z = std::max(1, int(std::lround(spacing_m / grid.spacing_m.z)));
    const int z_low = std::max(0, grid.nearest(liver.low).z);
    const int z_high = std::min(grid.dims.z - 1, grid.nearest(liver.high).z);
    std::vector<Vec3> entries;
    for (int z = z_low; z <= z_high; z += step_z) {
        const Depth depth = bodyDepth(marks, z);
        if (depth.back < 0) continue;
        const double middle = 0.5 * (depth.front + depth.back);
        const double reach = kAxillaryLine * 0.5 * (depth.front - depth.back);
        for (int y = int(std::ceil(middle - reach)); y <= int(std::floor(middle + reach)); y += step_y)
            if (const auto skin = firstSkinVoxel(marks, y, z)) entries.push_back(grid.centre(*skin));
    }
    return entries;
}

// A duct voxel is inside the liver if, from at least five of its six sides, a straight line reaches liver
// through ducts and vessels only.
class InsideLiver {
  public:
    explicit InsideLiver(const Patient& patient)
        : labels_(patient.package().labels),
          liver_(labelsWithTissue(patient, Tissue::liver)),
          duct_(labelsWithTissue(patient, Tissue::duct)),
          vessel_(labelsWithTissue(patient, Tissue::vessel)) {}

    bool operator()(const Index3& i) const {
        return std::count_if(kFaceSteps.begin(), kFaceSteps.end(),
                             [&](const Index3& step) { return meetsLiver(i, step); }) >= 5;
    }

  private:
    bool meetsLiver(Index3 i, const Index3& step) const {
        const int steps = int(kInsideLiver_m / glm::length(Vec3(step) * labels_.grid.spacing_m));
        for (int n = 0; n <= steps && labels_.grid.contains(i); ++n, i += step) {
            const std::uint8_t id = labels_[i];
            if (liver_[id]) return true;
            if (!duct_[id] && !vessel_[id]) return false;
        }
        return false;
    }

    const LabelVolume& labels_;
    LabelSet liver_, duct_, vessel_;
};

struct Ridge {
    Vec3 centre_m;
    float depth_m;
};

// Duct voxels whose distance from the wall is not exceeded by a neighbour.
std::vector<Ridge> findRidges(const Volume<float>& depth_m) {
    std::vector<Ridge> ridges;
    forEachVoxel(depth_m.grid, [&](const Index3& i) {
        const float own = depth_m[i];
        if (own <= 0.0f) return;
        const Index3 low = glm::max(i - 1, Index3(0)), high = glm::min(i + 1, depth_m.grid.dims - 1);
        float deepest_m = own;
        forEachVoxel(low, high, [&](const Index3& near) { deepest_m = std::max(deepest_m, depth_m[near]); });
        if (deepest_m <= own) ridges.push_back({depth_m.grid.centre(i), own});
    });
    return ridges;
}

// Bounding box of the duct voxels plus one voxel.
Grid cropAroundDucts(const LabelVolume& labels, const LabelSet& is_duct) {
    Index3 low = labels.grid.dims, high{-1};
    forEachVoxel(labels.grid, [&](const Index3& i) {
        if (is_duct[labels[i]]) low = glm::min(low, i), high = glm::max(high, i);
    });
    low = glm::max(low - 1, Index3(0));
    high = glm::min(high + 1, labels.grid.dims - 1);
    return {glm::max(high - low + 1, Index3(0)), labels.grid.spacing_m, labels.grid.centre(low)};
}

}  // namespace

std::vector<Vec3> ductCentreLine(const Patient& patient, double spacing_m) {
    const LabelVolume& labels = patient.package().labels;
    const LabelSet is_duct = labelsWithTissue(patient, Tissue::duct);
    const Grid crop = cropAroundDucts(labels, is_duct);
    if (crop.voxelCount() == 0) return {};
    const Index3 corner = labels.grid.nearest(crop.origin_m);
    Volume<std::uint8_t> not_duct(crop);
    forEachVoxel(crop, [&](const Index3& i) { not_duct[i] = !is_duct[labels[i + corner]]; });

    std::vector<Ridge> ridges = findRidges(distanceTo(not_duct, Sites::all, 1));
    const InsideLiver inside(patient);
    std::erase_if(ridges, [&](const Ridge& r) { return !inside(labels.grid.nearest(r.centre_m)); });
    std::sort(ridges.begin(), ridges.end(), [](const Ridge& a, const Ridge& b) {
        return std::tie(b.depth_m, a.centre_m.z, a.centre_m.y, a.centre_m.x) <
               std::tie(a.depth_m, b.centre_m.z, b.centre_m.y, b.centre_m.x);
    });
    std::vector<Vec3> kept_m;
    for (const Ridge& ridge : ridges)
        if (std::none_of(kept_m.begin(), kept_m.end(),
                         [&](const Vec3& k) { return glm::length(k - ridge.centre_m) < spacing_m; }))
            kept_m.push_back(ridge.centre_m);
    return kept_m;
}

PlanRegion makePlanRegion(const Patient& patient, const PlanSettings& settings) {
    const Box liver = deformedLiver(patient, settings.breath);
    if (liver.empty()) return {};
    const Grid crop = cropAround(patient.grid(), liver);
    Volume<std::uint8_t> marks = markDeformed(patient, settings.breath, crop, settings.threads);
    classifyBodyAndAir(marks);
    return {clearances(marks, settings.threads),
            uncertainMask(patient, settings.breath, crop, settings.threads), intercostalMask(marks),
            skinEntries(marks, liver, settings.skin_spacing_m), findBack(marks)};
}

}  // namespace stylet::patient
