#include "patient/motion/motion_template.h"

#include <algorithm>
#include <cmath>

#include "base/distance.h"
#include "base/geodesic.h"
#include "base/parallel.h"
#include "base/smoothstep.h"
#include "patient/motion/motion_interface.h"

namespace stylet::patient {
namespace {

constexpr double kWorkSpacing_m = 0.002;  // spacing of the grid on which the cavity is shaped
constexpr double kSmooth_m = 0.006;       // sigma of the smoothing of its surface
constexpr double kMaxShapedLevel_m = 0.060;
constexpr double kHull_m = 0.015;  // closes gaps between organs narrower than twice this
constexpr double kSlot_m = 0.014;  // closes slots narrower than twice this
constexpr double kBoneClearance_m = 0.0015;
constexpr double kBoneMargin_m = 0.001;  // minimum level at the centre of a bone voxel
constexpr double kPad_m = 0.030;         // margin of nodes around the image
constexpr double kFade_m = 0.060, kMinFade_m = 0.035;
// the slide fades beside the spine over at least this many metres per metre of travel
constexpr double kShear = 1.6;
constexpr double kMaxDomeTravel_m = 0.028;  // largest dome travel in any breath
constexpr double kRibRise = 0.67;
constexpr double kMaxSlideGradient = 1.5;  // limit of the slide's gradient, per metre and unit of v
constexpr double kMaxBreathGradient =
    0.995 * kMaxFieldGradient;  // limit over the whole breath; leaves a margin for rounding to 1 um
constexpr int kFlattenSweeps = 200;

// Meaning of each label id for the motion.
struct LabelKinds {
    std::array<bool, 256> fascia{}, bone{}, liver{}, organ{}, skin{}, wall{};
};

LabelKinds classifyLabels(const std::vector<Label>& table) {
    LabelKinds kinds;
    for (const Label& label : table) {
        kinds.fascia[label.id] = label.tissue == Tissue::fascia;
        kinds.bone[label.id] = isSkeleton(label.tissue);
        kinds.liver[label.id] = label.tissue == Tissue::liver;
        kinds.skin[label.id] = label.tissue == Tissue::skin;
        kinds.organ[label.id] =
            label.tissue == Tissue::air || label.tissue == Tissue::liver || label.abdominal;
        kinds.wall[label.id] = kinds.fascia[label.id] || kinds.bone[label.id] || kinds.skin[label.id];
    }
    return kinds;
}

// Dimensions that shape the fields, in the reference.
struct Body {
    double liver_low_m = 1e9, liver_high_m = -1e9;                      // z
    double left_m = 1e9, right_m = -1e9, back_m = 1e9, front_m = -1e9;  // at the liver's height
    double spine_x_m = 0.0, spine_front_m = 0.0;
    bool empty() const { return liver_low_m > liver_high_m; }
    double middle() const { return 0.5 * (left_m + right_m); }
};

Body measureBody(const LabelVolume& labels, const LabelKinds& kinds) {
    Body body;
    const Grid& grid = labels.grid;
    forEachVoxel(grid, [&](const Index3& i) {
        if (!kinds.liver[labels[i]]) return;
        const double z = grid.centre(i).z;
        body.liver_low_m = std::min(body.liver_low_m, z), body.liver_high_m = std::max(body.liver_high_m, z);
    });
    const auto atLiver = [&](const auto& visit) {
        forEachVoxel(grid, [&](const Index3& i) {
            const Vec3 p = grid.centre(i);
            if (labels[i] != 0 && p.z >= body.liver_low_m && p.z <= body.liver_high_m) visit(labels[i], p);
        });
    };
    atLiver([&](std::uint8_t, const Vec3& p) {
        body.left_m = std::min(body.left_m, p.x), body.right_m = std::max(body.right_m, p.x);
        body.back_m = std::min(body.back_m, p.y), body.front_m = std::max(body.front_m, p.y);
    });
    const double half_depth_m = 0.5 * (body.front_m - body.back_m);
    body.spine_front_m = body.back_m + 0.6 * half_depth_m;
    body.spine_x_m = body.middle();
    double front_m = -1e9, sum_x = 0.0;
    std::size_t bones = 0;
    atLiver([&](std::uint8_t id, const Vec3& p) {
        if (!kinds.bone[id] || std::fabs(p.x - body.middle()) > 0.025 || p.y > body.back_m + half_depth_m)
            return;
        front_m = std::max(front_m, p.y), sum_x += p.x, ++bones;
    });
    if (bones > 0) body.spine_front_m = front_m, body.spine_x_m = sum_x / double(bones);
    return body;
}

// Region inside the fascia that is connected to the liver. Empty if the fascia is missing or leaks.
std::vector<bool> insideFascia(const LabelVolume& labels, const LabelKinds& kinds) {
    const bool lined = std::any_of(labels.voxels.begin(), labels.voxels.end(),
                                   [&](std::uint8_t l) { return kinds.fascia[l]; });
    if (!lined) return {};
    std::vector<bool> inside(labels.voxels.size(), false);
    bool leaks = false;
    const auto enter = [&](const Index3& i) {
        leaks = leaks || kinds.skin[labels[i]];
        const std::size_t at = labels.grid.offset(i);
        if (leaks || inside[at] || kinds.wall[labels[i]]) return false;
        inside[at] = true;
        leaks = labels.grid.atSide(i);  // leaks through the side of the body
        return true;
    };
    std::vector<Index3> liver;
    forEachVoxel(labels.grid, [&](const Index3& i) {
        if (kinds.liver[labels[i]] && enter(i)) liver.push_back(i);
    });
    floodFaces(labels.grid, std::move(liver), enter);
    return leaks ? std::vector<bool>() : inside;
}

Grid workGrid(const Grid& image) {
    Grid work = image;
    for (int axis = 0; axis < 3; ++axis) {
        const int stride = std::max(1, int(std::floor(kWorkSpacing_m / image.spacing_m[axis] + 0.5)));
        work.spacing_m[axis] = image.spacing_m[axis] * stride;
        work.dims[axis] = std::max(1, image.dims[axis] / stride);
        work.origin_m[axis] = image.origin_m[axis] + 0.5 * (stride - 1) * image.spacing_m[axis];
    }
    return work;
}

Volume<std::uint8_t> within(const Volume<float>& distance_m, double reach_m, bool inverted) {
    Volume<std::uint8_t> mask(distance_m.grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        mask.voxels[i] = (double(distance_m.voxels[i]) <= reach_m) != inverted;
    return mask;
}

// The cavity on the work grid, without bones.
Volume<std::uint8_t> cavityMask(const LabelVolume& labels, const LabelKinds& kinds, int threads) {
    Volume<std::uint8_t> mask(workGrid(labels.grid)), bone(mask.grid);
    const std::vector<bool> inside = insideFascia(labels, kinds);
    forEachVoxel(mask.grid, [&](const Index3& i) {
        const Index3 source =
            glm::clamp(labels.grid.nearest(mask.grid.centre(i)), Index3(0), labels.grid.dims - 1);
        const std::size_t at = labels.grid.offset(source);
        mask[i] = inside.empty() ? kinds.organ[labels.voxels[at]] : inside[at];
        bone[i] = kinds.bone[labels.voxels[at]];
    });
    if (inside.empty()) {
        mask = within(distanceTo(mask, Sites::all, threads), kHull_m, true);
        mask = within(distanceTo(mask, Sites::all, threads), kHull_m, true);
    }
    const Volume<float> from_bone_m = distanceTo(bone, Sites::all, threads);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        if (double(from_bone_m.voxels[i]) <= kBoneClearance_m) mask.voxels[i] = 0;
    // Morphological opening: removes slots that are too narrow to slide in.
    const Volume<std::uint8_t> outside = within(distanceTo(mask, Sites::all, threads), 0.0, true);
    mask = within(distanceTo(outside, Sites::all, threads), kSlot_m, true);
    return within(distanceTo(mask, Sites::all, threads), kSlot_m, false);
}

// Binomial smoothing along each axis until the variance is that of kSmooth_m.
void smooth(Volume<float>& volume) {
    for (int axis = 0; axis < 3; ++axis) {
        const double sigma = kSmooth_m / volume.grid.spacing_m[axis];
        const int passes = int(std::floor(2.0 * sigma * sigma + 0.5));
        parallelLines(1, volume.grid.dims, axis, volume.voxels.data(),
                      [&](float* first, std::size_t stride, std::size_t count) {
                          for (int pass = 0; pass < passes; ++pass)
                              smoothLine(first, stride, count);
                      });
    }
}

// Smoothed signed distance to the mask's border.
Volume<float> computeLevel(const Volume<std::uint8_t>& mask, int threads) {
    const Vec3 s = mask.grid.spacing_m;
    const double half_m = 0.5 * std::min({s.x, s.y, s.z});
    Volume<std::uint8_t> outside(mask.grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        outside.voxels[i] = !mask.voxels[i];
    Volume<float> level = distanceTo(mask, Sites::all, threads);
    const Volume<float> depth = distanceTo(outside, Sites::all, threads);
    for (std::size_t i = 0; i < level.voxels.size(); ++i) {
        const double signed_m =
            mask.voxels[i] ? half_m - double(depth.voxels[i]) : double(level.voxels[i]) - half_m;
        level.voxels[i] = float(std::clamp(signed_m, -kMaxShapedLevel_m, kMaxShapedLevel_m));
    }
    smooth(level);
    return level;
}

// Covers the image, and along z at least the range from `low_m` to `high_m`. Nodes lie on whole
// millimetres.
Grid nodeGrid(const Grid& image, double spacing_m, double low_m, double high_m) {
    Grid grid;
    grid.spacing_m = Vec3(spacing_m);
    Vec3 low = image.origin_m - kPad_m, high = image.centre(image.dims - 1) + kPad_m;
    low.z = std::min(low.z, low_m - spacing_m), high.z = std::max(high.z, high_m + spacing_m);
    for (int axis = 0; axis < 3; ++axis) {
        grid.origin_m[axis] = std::floor(low[axis] * 1000.0) / 1000.0;
        grid.dims[axis] = 2 + int(std::floor((high[axis] - grid.origin_m[axis]) / spacing_m));
    }
    return grid;
}

// The template's two fields, before the slide is made tangential.
class TemplateFields {
  public:
    TemplateFields(const Body& body, const MotionAmplitudes& a, const Grid& image, double v_ref,
                   double node_m)
        : body_(body), a_(a), low_m_(image.origin_m), high_m_(image.centre(image.dims - 1)), node_m_(node_m) {
        const double v = std::clamp(v_ref, 0.0, 1.0);
        full_low_m_ = body.liver_low_m - 0.003 - a.dome_m * (1.0 - v);
        full_high_m_ = body.liver_high_m + 0.003 + a.dome_m * v;
        // The field fades to zero within the scan if there is room, so that no air is drawn in.
        const double min_m = std::max(kMinFade_m, 2.2 * a.dome_m);
        zero_low_m_ = std::min(full_low_m_ - min_m, std::max(full_low_m_ - kFade_m, low_m_.z));
        zero_high_m_ = std::max(full_high_m_ + min_m, std::min(full_high_m_ + kFade_m, high_m_.z));
    }

    // Lateral and anterior motion would press against the cavity's wall. So `level_m` limits it to the inner
    // part of the cavity.
    Vec3 slide(const Vec3& p, double level_m) const {
        const double inner = smoothStep(-0.008, -0.040, level_m);
        return along(p.z) * freeOfSpine(p) * fadeOut(p, 2) *
               Vec3(-a_.lateral_m * inner, a_.anterior_m * inner, -a_.dome_m);
    }
    Vec3 slideLag(const Vec3& p) const {
        return Vec3(0.0, 0.0, -along(p.z) * freeOfSpine(p) * fadeOut(p, 2) * a_.hysteresis_m_s);
    }

    // The slide is zero below zeroLow_m() and above zeroHigh_m().
    double zeroLow_m() const { return zero_low_m_; }
    double zeroHigh_m() const { return zero_high_m_; }

    Vec3 wall(const Vec3& p) const {
        const double half_width_m = 0.5 * (body_.right_m - body_.left_m);
        const double side = std::clamp((p.x - body_.middle()) / half_width_m, -1.2, 1.2);
        const double front = (p.y - body_.spine_front_m) / (body_.front_m - body_.spine_front_m);
        const double liver_m = 0.5 * (body_.liver_low_m + body_.liver_high_m);
        // The front of the chest rises less than the abdomen.
        const double below = 1.0 - 0.7 * smoothStep(liver_m, body_.liver_high_m + 0.02, p.z);
        // Zero at the scan's ends, so that no air is drawn in.
        const double ends =
            smoothStep(low_m_.z, low_m_.z + 0.04, p.z) * smoothStep(high_m_.z, high_m_.z - 0.04, p.z);
        const Vec3 w(a_.rib_m * side, a_.belly_m * below * smoothStep(0.45, 0.95, front),
                     kRibRise * a_.rib_m * side * side * ends);
        return offSpine(p) * fadeOut(p, 3) * w;
    }

  private:
    double along(double z) const {
        return smoothStep(zero_low_m_, full_low_m_, z) * smoothStep(zero_high_m_, full_high_m_, z);
    }
    // Distance from the spine, measured to its front and sides.
    double fromSpine_m(const Vec3& p, double half_width_m) const {
        const double beside_m = std::max(0.0, std::fabs(p.x - body_.spine_x_m) - half_width_m);
        const double before_m = std::max(0.0, p.y - body_.spine_front_m);
        return std::sqrt(beside_m * beside_m + before_m * before_m);
    }
    double offSpine(const Vec3& p) const { return smoothStep(0.005, 0.050, fromSpine_m(p, 0.040)); }
    // Structures on the spine (great vessels, psoas) move less because the spine holds them. The slide fades
    // over a distance that nodes and tables can resolve.
    double freeOfSpine(const Vec3& p) const {
        constexpr double kWithin_m = 0.020;
        return smoothStep(0.0, kWithin_m + std::max(0.020, kShear * a_.dome_m),
                          fromSpine_m(p + Vec3(0.0, kWithin_m, 0.0), 0.040 - kWithin_m));
    }
    // 1 in the image, falling to 0 before the nodes end, along the first `axes` axes.
    double fadeOut(const Vec3& p, int axes) const {
        double share = 1.0;
        const double reach_m = kPad_m - node_m_;
        for (int axis = 0; axis < axes; ++axis) {
            const double beyond_m = std::max(low_m_[axis] - p[axis], p[axis] - high_m_[axis]);
            share *= smoothStep(reach_m, 0.0, beyond_m);
        }
        return share;
    }

    Body body_;
    MotionAmplitudes a_;
    Vec3 low_m_, high_m_;
    double node_m_;
    double full_low_m_, full_high_m_, zero_low_m_, zero_high_m_;
};

std::array<float, 3> narrowed(const Vec3& v) {
    // Rounds to steps of 2^-20 m, about 1 um. This halves the file and is too small to feel.
    const auto round = [](double x) { return float(std::floor(x * 0x1p20 + 0.5) * 0x1p-20); };
    return {round(v.x), round(v.y), round(v.z)};
}

// Factor on the slide near the surface. It is 1 on straight walls. It is 0 where the surface bends along z,
// the direction of sliding, with a radius below 15 mm, and where it leans by more than 40 degrees.
Volume<float> slideFactor(const MotionModel& m) {
    Volume<float> level(m.grid), share(m.grid, 1.0f);
    level.voxels = m.level_m;
    smooth(level);
    const double cell_m = m.grid.spacing_m.z;
    const auto normalAt = [&](const Index3& i) {
        Vec3 g;
        for (int axis = 0; axis < 3; ++axis) {
            Index3 low = i, high = i;
            --low[axis], ++high[axis];
            g[axis] = double(level[high] - level[low]) / m.grid.spacing_m[axis];
        }
        return g / std::sqrt(glm::dot(g, g) + 1e-6);
    };
    forEachVoxel(m.grid, [&](const Index3& i) {
        if (!m.grid.contains(i - 2) || !m.grid.contains(i + 2)) return;
        if (std::fabs(double(level[i])) > 2.0 * cell_m) return;
        const Vec3 bend = normalAt({i.x, i.y, i.z + 1}) - normalAt({i.x, i.y, i.z - 1});
        const double per_m = std::sqrt(glm::dot(bend, bend)) / (2.0 * cell_m);
        const double lean = std::fabs(normalAt(i).z);
        share[i] =
            float((1.0 - smoothStep(1.0 / 0.060, 1.0 / 0.015, per_m)) * (1.0 - smoothStep(0.25, 0.65, lean)));
    });
    for (int pass = 0; pass < 4; ++pass)
        smooth(share);
    for (float& x : share.voxels)
        x = float(smoothStep(0.4, 1.0, double(x)));
    return share;
}

// Reduces differences between neighbours until no edge is steeper than `max_gradient` per metre and unit of
// v, nor steeper than packages allow. On a rough cavity the sides then slide less and the gaps are larger,
// but the package is valid.
void limitGradient(MotionModel& m, double max_gradient) {
    const std::array<std::size_t, 3> strides = m.grid.strides();
    bool steep = true;
    for (int sweep = 0; sweep < kFlattenSweeps && steep; ++sweep) {
        steep = false;
        for (int axis = 0; axis < 3; ++axis) {
            const double max_change_m = max_gradient * m.grid.spacing_m[axis];
            for (std::size_t at = strides[std::size_t(axis)]; at < m.slide.size(); ++at) {
                MotionCoefficients &a = m.slide[at - strides[std::size_t(axis)]], &b = m.slide[at];
                double change_m = 0.0;
                for (std::size_t c = 0; c < 3; ++c)
                    change_m = std::max(change_m, std::fabs(double(b.a1_m[c]) - double(a.a1_m[c])));
                if (change_m <= max_change_m &&
                    maxNodeDifference(m, a, b) <= kMaxBreathGradient * m.grid.spacing_m[axis])
                    continue;
                steep = true;
                // Keeps the mean of the two, so that one spike does not flatten its whole surroundings.
                for (std::size_t c = 0; c < 3; ++c) {
                    const float a1 = 0.1f * (b.a1_m[c] - a.a1_m[c]), a2 = 0.1f * (b.a2_m_s[c] - a.a2_m_s[c]);
                    a.a1_m[c] += a1, b.a1_m[c] -= a1;
                    a.a2_m_s[c] += a2, b.a2_m_s[c] -= a2;
                }
            }
        }
    }
}

std::vector<Vec3> bonePoints(const LabelVolume& labels, const LabelKinds& kinds) {
    std::vector<Vec3> points_m;
    forEachVoxel(labels.grid, [&](const Index3& i) {
        if (kinds.bone[labels[i]]) points_m.push_back(labels.grid.centre(i));
    });
    return points_m;
}

}  // namespace

MotionModel motionTemplate(const LabelVolume& labels, const std::vector<Label>& table,
                           const MotionAmplitudes& amplitudes, const Surrogate& reference, int threads) {
    MotionModel m;
    m.reference = reference;
    m.dome_travel_m = amplitudes.dome_m;
    // Limits v so that a sigh does not move the dome by more than kMaxDomeTravel_m.
    m.v.high = std::min(m.v.high, std::max(1.0, kMaxDomeTravel_m / amplitudes.dome_m));
    const LabelKinds kinds = classifyLabels(table);
    const Body body = measureBody(labels, kinds);
    if (body.empty()) return m;
    const Volume<float> level = computeLevel(cavityMask(labels, kinds, threads), threads);
    const TemplateFields fields(body, amplitudes, labels.grid, reference.v, amplitudes.spacing_m);
    m.grid = nodeGrid(labels.grid, amplitudes.spacing_m, fields.zeroLow_m(), fields.zeroHigh_m());
    forEachVoxel(m.grid, [&](const Index3& i) {
        const Vec3 p = m.grid.centre(i);
        const double inner = m.grid.atBorder(i) ? 0.0 : 1.0;
        m.wall.push_back({narrowed(inner * fields.wall(p)), {}});
        const double level_m = sampleTrilinear(level, p);
        m.slide.push_back({narrowed(inner * fields.slide(p, level_m)), narrowed(inner * fields.slideLag(p))});
        m.level_m.push_back(float(level_m));
    });
    raiseLevelAt(m, bonePoints(labels, kinds), kBoneMargin_m);
    const Volume<float> share = slideFactor(m);
    for (std::size_t i = 0; i < m.slide.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            m.slide[i].a1_m[c] *= share.voxels[i];
            m.slide[i].a2_m_s[c] *= share.voxels[i];
        }
    makeTangential(m);
    limitGradient(m, kMaxSlideGradient);
    for (MotionCoefficients& c : m.slide) {
        c.a1_m = narrowed({double(c.a1_m[0]), double(c.a1_m[1]), double(c.a1_m[2])});
        c.a2_m_s = narrowed({double(c.a2_m_s[0]), double(c.a2_m_s[1]), double(c.a2_m_s[2])});
    }
    return m;
}

}  // namespace stylet::patient
