#include "app/trainer/view/access_tubes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace stylet::trainer {

using haptics::AccessOutput;
using haptics::DrainState;
using haptics::Tool;

namespace {

constexpr double kDilator_m = 0.20;
constexpr double kPathStep_m = 0.003, kTolerance_m = 0.0002;
constexpr double kLoopTurns = 0.8;  // part of a full turn that the pigtail makes
constexpr int kLoopPoints = 20;
const Vec3 kSteel{0.55, 0.56, 0.58}, kDilatorBlue{0.10, 0.25, 0.60}, kDrainWhite{0.85, 0.85, 0.80};

// The path of wire, dilator and drain in the deformed patient. Depths are from the skin. The track is
// straight between entry and base, as the tools that lie in it keep it, although organs slide past the body
// wall.
class DeformedPath {
  public:
    DeformedPath(const haptics::TickOutput& tick, const patient::MotionModel& motion)
        : tick_(tick),
          motion_(motion),
          entry_m_(deformed(tick.access.entry_m)),
          into_(glm::normalize(deformed(tick.access.base_m) - entry_m_)),
          track_m_(glm::distance(tick.access.entry_m, tick.access.base_m)) {
        for (int i = 0; i < tick.access.path_count; ++i)
            path_m_.emplace_back(tick.access.path_m[std::size_t(i)]);
    }
    double track_m() const { return track_m_; }

    // From a depth above the base to the tip of the wire.
    std::vector<Vec3> wire(double from_m) const {
        const AccessOutput& access = tick_.access;
        std::vector<Vec3> points{onTrack(from_m), onTrack(track_m_ + std::min(0.0, access.wire_m))};
        if (access.wire_m > 0.0)
            for (int i = access.node_count; i-- > 0;)
                points.push_back(deformed(Vec3(access.nodes_m[std::size_t(i)])));
        return points;
    }
    // The part of the path of dilator and drain between two depths.
    std::vector<Vec3> tube(double from_m, double to_m) const {
        std::vector<Vec3> points{onTrack(from_m), onTrack(std::min(to_m, track_m_))};
        for (double at_m = track_m_ + kPathStep_m; at_m < to_m; at_m += kPathStep_m)
            points.push_back(beyondTrack(at_m));
        if (to_m > track_m_) points.push_back(beyondTrack(to_m));
        return points;
    }

  private:
    Vec3 deformed(const Vec3& reference_m) const {
        return patient::deformedFromReference(motion_, tick_.breath, reference_m);
    }
    Vec3 onTrack(double depth_m) const { return entry_m_ + depth_m * into_; }
    Vec3 beyondTrack(double depth_m) const { return deformed(haptics::pointAt({path_m_, depth_m}, depth_m)); }

    const haptics::TickOutput& tick_;
    const patient::MotionModel& motion_;
    Vec3 entry_m_, into_;
    double track_m_;
    std::vector<Vec3> path_m_;
};

// Replaces the end of the drain, as long as the loop, by the loop. It lies in the coronal plane, where the
// C-arm shows it best.
std::vector<Vec3> curledTube(const DeformedPath& path, double from_m, double tip_m, double diameter_m) {
    const double loop_m = std::numbers::pi * diameter_m * kLoopTurns;
    std::vector<Vec3> points = path.tube(from_m, tip_m - loop_m);
    const Vec3 start = points.back();
    const Vec3 front{0.0, 1.0, 0.0}, end = start - points[points.size() - 2];
    const Vec3 coronal = end - glm::dot(end, front) * front;
    const Vec3 along =
        glm::length(coronal) > 0.1 * glm::length(end) ? glm::normalize(coronal) : Vec3(0.0, 0.0, -1.0);
    const Vec3 side = glm::cross(along, front);
    for (int i = 1; i <= kLoopPoints; ++i) {
        const double angle = 2.0 * std::numbers::pi * kLoopTurns * i / kLoopPoints;
        points.push_back(start +
                         0.5 * diameter_m * (std::sin(angle) * along + (1.0 - std::cos(angle)) * side));
    }
    return points;
}

double distanceToChord_m(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 chord = b - a;
    const double square = glm::dot(chord, chord);
    const double share = square > 0.0 ? std::clamp(glm::dot(p - a, chord) / square, 0.0, 1.0) : 0.0;
    return glm::distance(p, a + share * chord);
}

// Appends the points of (first, last] that are needed.
void simplifyPart(const std::vector<Vec3>& points, std::size_t first, std::size_t last, double tolerance_m,
                  std::vector<Vec3>& kept) {
    std::size_t furthest = first;
    double most_m = tolerance_m;
    for (std::size_t i = first + 1; i < last; ++i)
        if (const double off_m = distanceToChord_m(points[i], points[first], points[last]); off_m > most_m)
            most_m = off_m, furthest = i;
    if (furthest == first) {
        kept.push_back(points[last]);
        return;
    }
    simplifyPart(points, first, furthest, tolerance_m, kept);
    simplifyPart(points, furthest, last, tolerance_m, kept);
}

}  // namespace

std::vector<Vec3> simplifyCurve(const std::vector<Vec3>& points_m, double tolerance_m) {
    if (points_m.size() < 3) return points_m;
    std::vector<Vec3> kept{points_m.front()};
    simplifyPart(points_m, 0, points_m.size() - 1, tolerance_m, kept);
    return kept;
}

std::optional<Vec3> tipOnTrack_m(const haptics::TickOutput& tick, const patient::MotionModel& motion) {
    const AccessOutput& access = tick.access;
    if (!access.open || !haptics::isAccessTool(tick.tool)) return std::nullopt;
    const DeformedPath path(tick, motion);
    if (tick.tool == Tool::wire) return access.wire_in ? std::optional(path.wire(0.0).back()) : std::nullopt;
    const double depth_m = tick.tool == Tool::dilator ? access.dilator_m : access.drain_m;
    return depth_m > 0.0 ? std::optional(path.tube(0.0, depth_m).back()) : std::nullopt;
}

std::vector<CurvedTube> accessTubes(const haptics::TickOutput& tick, const haptics::AccessSettings& settings,
                                    const patient::MotionModel& motion, double needle_m) {
    const AccessOutput& access = tick.access;
    std::vector<CurvedTube> tubes;
    if (!access.wire_in && access.path_count < 2) return tubes;
    const DeformedPath path(tick, motion);
    const auto add = [&](const std::vector<Vec3>& points, const Vec3& colour) -> CurvedTube& {
        return tubes.emplace_back(
            CurvedTube{.points_m = simplifyCurve(points, kTolerance_m), .colour = colour});
    };
    const auto addTube = [&](const std::vector<Vec3>& points, const haptics::TubeSettings& tube,
                             const Vec3& colour) {
        CurvedTube& shown = add(points, colour);
        shown.radius_m = 0.5 * tube.outer_m, shown.bore_m = 0.5 * tube.inner_m;
        shown.attenuation_per_m = tube.attenuation_per_m;
    };
    if (access.wire_in) {
        const double hub_m = access.needle_in ? std::max(0.0, needle_m - path.track_m()) : 0.0;
        CurvedTube& wire = add(path.wire(-hub_m - kTubeOutside_m), kSteel);
        wire.radius_m = settings.wire.radius_m();
        wire.attenuation_per_m = settings.wire.attenuation_per_m;
    }
    if (access.path_count < 2) return tubes;
    if (tick.tool == Tool::dilator && access.open)
        addTube(path.tube(access.dilator_m - kDilator_m, access.dilator_m), settings.dilator, kDilatorBlue);
    const double tip_m = access.drain_m, from_m = std::min(tip_m, 0.0) - kTubeOutside_m;
    if (access.drain == DrainState::in_place)
        addTube(curledTube(path, from_m, tip_m, settings.drain.pigtail_m), settings.drain, kDrainWhite);
    else if ((tick.tool == Tool::drain && access.open) || access.drain != DrainState::none)
        addTube(path.tube(from_m, tip_m), settings.drain, kDrainWhite);
    return tubes;
}

}  // namespace stylet::trainer
