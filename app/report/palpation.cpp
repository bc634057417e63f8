#include "app/report/palpation.h"

#include <algorithm>
#include <cmath>

namespace stylet::report {

using haptics::TouchMap;
using patient::Patient;
using patient::Surrogate;

namespace {

constexpr double kAbove_m = 0.002;
constexpr double kAxillaryLine = 0.5;  // distance from the torso's middle, as a share of its half depth
constexpr double kRibCentreShare = 0.7, kGapCentreShare = 0.0;  // share of the pad over bone
constexpr double kMinMargin_m = 0.012;                          // minimum extent of the image around a spot

// Extent of the flank in y and z.
struct Flank {
    double back_m = 1e9, front_m = -1e9, low_m = 1e9, high_m = -1e9;
};

Flank findFlank(const Patient& patient, const patient::Skin& skin) {
    const LabelVolume& labels = patient.package().labels;
    Flank flank;
    forEachVoxel(labels.grid, [&](const Index3& i) {
        const patient::Label* const label = patient.label(labels[i]);
        if (!label || label->tissue != patient::Tissue::liver) return;
        flank.low_m = std::min(flank.low_m, labels.grid.centre(i).z);
        flank.high_m = std::max(flank.high_m, labels.grid.centre(i).z);
    });
    // Front and back of the body at the middle height of the liver.
    const Grid& g = labels.grid;
    const double middle_m = 0.5 * (flank.low_m + flank.high_m);
    for (int y = 0; y < g.dims.y; ++y)
        for (int x = 0; x < g.dims.x; ++x) {
            const Vec3 p{g.centre({x, y, 0}).x, g.centre({x, y, 0}).y, middle_m};
            if (patient::skinAt(skin, p).level_m > 0.0) continue;
            flank.back_m = std::min(flank.back_m, p.y);
            flank.front_m = std::max(flank.front_m, p.y);
        }
    const double centre_m = 0.5 * (flank.front_m + flank.back_m);
    const double reach_m = kAxillaryLine * 0.5 * (flank.front_m - flank.back_m);
    flank.front_m = centre_m + reach_m;
    flank.back_m = centre_m - reach_m;
    return flank;
}

// Finds the skin point at (y, z), coming from the right.
bool findSkin(const Patient& patient, const patient::Skin& skin, double y_m, double z_m, Vec3& found_m) {
    const Grid& g = patient.grid();
    const Vec3 last = g.centre(g.dims - 1);
    if (z_m < g.origin_m.z + kMinMargin_m || z_m > last.z - kMinMargin_m) return false;
    Vec3 p{last.x, y_m, z_m};
    double level_m = patient::skinAt(skin, p).level_m;
    if (level_m <= 0.0) return false;  // cut off by the image's border
    while (level_m > 1e-5 && p.x > g.origin_m.x) {
        p.x -= std::max(0.5 * level_m, 1e-5);
        level_m = patient::skinAt(skin, p).level_m;
    }
    found_m = p;
    return p.x > 0.5 * (g.origin_m.x + last.x);
}

// The rotation of a tool whose +z is `outward`.
Quat toolRotation(const Vec3& outward) {
    const Vec3 x = glm::normalize(glm::cross(Vec3(0.0, 0.0, 1.0), outward));
    return glm::quat_cast(patient::Mat3(x, glm::cross(outward, x), outward));
}

// Palpates all spots with one finger and one continuous breath.
class Palpator {
  public:
    Palpator(const Patient& patient, const TouchMap& map, const PalpationSettings& settings)
        : motion_(patient.package().motion),
          map_(map),
          settings_(settings),
          pad_(haptics::fingerPad(settings.finger)),
          plan_{.rhythm = patient.package().signal} {}

    void press(const Vec3& outward_reference, PalpatedSpot& spot) {
        haptics::FingerState state;
        Surrogate breath = now();
        const Vec3 skin_m = deformedFromReference(motion_, breath, spot.reference_m);
        const Vec3 above_m =
            deformedFromReference(motion_, breath, spot.reference_m + kAbove_m * outward_reference);
        const Vec3 outward = glm::normalize(above_m - skin_m);
        Pose pose{toolRotation(outward), skin_m};
        spot.breath_v = breath.v;
        const int ticks = int(2.0 * (settings_.depth_m + kAbove_m) / (settings_.speed_m_s * settings_.dt_s));
        for (int i = 0; i < ticks; ++i) {
            pose.position_m = skin_m + outward * (kAbove_m - i * settings_.speed_m_s * settings_.dt_s);
            const haptics::ToolForce force =
                haptics::stepFinger(state, settings_.finger, pad_, {map_, motion_, breath}, pose);
            const double force_n = glm::dot(force.force_n, outward), depth_m = state.pad.depth_m;
            if (depth_m > 0.0) spot.stiffness_n_per_m = force_n / depth_m;
            if (force_n >= settings_.force_n || depth_m >= settings_.depth_m) return;
            if (settings_.breathing) patient::stepBreathing(breathing_, plan_, settings_.dt_s);
            breath = now();
        }
    }

  private:
    Surrogate now() const {
        return settings_.breathing ? patient::surrogateAt(breathing_, plan_, settings_.dt_s) : Surrogate{};
    }

    const patient::MotionModel& motion_;
    const TouchMap& map_;
    const PalpationSettings& settings_;
    haptics::Pad pad_;
    patient::BreathPlan plan_;
    patient::BreathingState breathing_;
};

const PalpatedSpot* skinSpotAt(const PalpationMap& map, int column, int row) {
    if (column < 0 || row < 0 || column >= map.columns || row >= map.rows) return nullptr;
    const PalpatedSpot& spot = map.spots[std::size_t(row * map.columns + column)];
    return spot.on_skin ? &spot : nullptr;
}

// The share of a pad centred on the spot that is over bone, counted in spots.
double boneShare(const PalpationMap& map, int column, int row, double radius_m) {
    const int reach = int(radius_m / map.pitch_m + 0.5);
    int all = 0, bone = 0;
    for (int r = -reach; r <= reach; ++r)
        for (int c = -reach; c <= reach; ++c) {
            if (r * r + c * c > reach * reach) continue;
            const PalpatedSpot* const spot = skinSpotAt(map, column + c, row + r);
            if (spot) ++all, bone += spot->over_bone;
        }
    return all > 0 ? double(bone) / all : 0.0;
}

struct Mean {
    double sum = 0.0;
    int count = 0;
    void add(double x) { sum += x, ++count; }
    double value() const { return count > 0 ? sum / count : 0.0; }
};

void computeStatistics(PalpationMap& map) {
    Mean all, squares, bone, rib, gap, over, beside;
    for (const PalpatedSpot& s : map.spots) {
        if (!s.on_skin) continue;
        const double k = s.stiffness_n_per_m;
        all.add(k), squares.add(k * k), bone.add(s.over_bone);
        (s.over_bone ? over : beside).add(k);
        if (s.over_bone && s.bone_share >= kRibCentreShare) rib.add(k);
        if (s.bone_share <= kGapCentreShare) gap.add(k);
    }
    map.rib_n_per_m = rib.value(), map.gap_n_per_m = gap.value();
    if (beside.value() > 0.0) map.rib_over_gap_everywhere = over.value() / beside.value();
    const double share = bone.value(), variance = squares.value() - all.value() * all.value();
    const double covariance = share * (over.value() - all.value());
    const double spread = variance * share * (1.0 - share);
    map.pearson = spread > 0.0 ? covariance / std::sqrt(spread) : 0.0;
}

}  // namespace

PalpationMap palpate(const Patient& patient, const patient::Skin& skin, const TouchMap& touch,
                     const PalpationSettings& settings) {
    const Flank flank = findFlank(patient, skin);
    PalpationMap map;
    if (!(flank.low_m < flank.high_m) || !(flank.back_m < flank.front_m)) return map;
    map.pitch_m = settings.pitch_m;
    map.columns = 1 + int((flank.front_m - flank.back_m) / settings.pitch_m);
    map.rows = 1 + int((flank.high_m - flank.low_m) / settings.pitch_m);
    map.front_m = flank.front_m, map.top_m = flank.high_m;
    map.spots.resize(std::size_t(map.columns) * std::size_t(map.rows));
    Palpator palpator(patient, touch, settings);
    for (int row = 0; row < map.rows; ++row)
        for (int column = 0; column < map.columns; ++column) {
            PalpatedSpot& spot = map.spots[std::size_t(row * map.columns + column)];
            const double y_m = map.front_m - column * map.pitch_m, z_m = map.top_m - row * map.pitch_m;
            spot.on_skin = findSkin(patient, skin, y_m, z_m, spot.reference_m);
            if (!spot.on_skin) continue;
            const Vec3 outward = glm::normalize(patient::skinAt(skin, spot.reference_m).normal);
            spot.over_bone =
                std::isfinite(haptics::computeLayers(patient, spot.reference_m, -outward).cover_m);
            palpator.press(outward, spot);
        }
    for (int row = 0; row < map.rows; ++row)
        for (int column = 0; column < map.columns; ++column)
            map.spots[std::size_t(row * map.columns + column)].bone_share =
                boneShare(map, column, row, settings.finger.radius_m);
    computeStatistics(map);
    return map;
}

}  // namespace stylet::report
