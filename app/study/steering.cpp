#include "app/study/steering.h"

#include <algorithm>
#include <cmath>

namespace stylet::study {

using haptics::Borders;
using haptics::Segment;
using patient::PlannedPath;
using patient::Surrogate;
using patient::Tissue;

namespace {

// The depth of the first border into the body, or the end of the walk.
double firstContact(const std::vector<Segment>& segments, double end_m) {
    for (const Segment& s : segments)
        if (s.tissue != Tissue::air) return s.begin_m;
    return end_m;
}

// The breathing signal per tick, starting at the time when it is nearest to `start`.
std::vector<Surrogate> sampleBreathing(const patient::Package& package, const Surrogate& start,
                                       double seconds) {
    patient::BreathPlan plan;
    plan.rhythm = package.signal;
    patient::BreathingState state;
    const auto ticks = [](double s) { return std::size_t(std::ceil(s / kTick_s)) + 1; };
    const std::size_t cycle = ticks(package.signal.period_s), count = ticks(seconds);
    std::vector<Surrogate> signal;
    for (std::size_t i = 0; i < cycle + count; ++i) {
        signal.push_back(patient::surrogateAt(state, plan, kTick_s));
        patient::stepBreathing(state, plan, kTick_s);
    }
    const auto nearest = std::min_element(signal.begin(), signal.begin() + std::ptrdiff_t(cycle),
                                          [&](const Surrogate& a, const Surrogate& b) {
                                              return std::fabs(a.v - start.v) < std::fabs(b.v - start.v);
                                          });
    return {nearest, nearest + std::ptrdiff_t(count)};
}

haptics::ExactEvent makeExactEvent(const haptics::NeedleEvent& e, double depth_m) {
    return {e.kind,  e.border.to,      e.border.to_label, depth_m - e.tenting_m,
            depth_m, e.force_before_n, e.force_after_n};
}

}  // namespace

Steering::Steering(const PreparedPair& pair, const SteeringSettings& settings)
    : pair_(pair),
      settings_(settings),
      // Bone gives the paper's maximum force at once. A planned path meets bone only where the built patient
      // is wrong.
      full_(pair.full_map, settings.needle, haptics::Bone::immediateMaximum),
      partial_(pair.partial_map, settings.needle, haptics::Bone::immediateMaximum) {
    constexpr double kLongest_m = 0.2;
    if (settings.breathing)
        breath_ = sampleBreathing(pair.pair.reference, pair.pair.reference.motion.reference,
                                  kLongest_m / settings.speed_m_s);
}

// Finds the segments and the closed form of the force for both patients in one shared voxel walk.
void Steering::solveStatic(const PlannedPath& path) {
    const Vec3 way = path.target_reference_m - path.entry_reference_m;
    const double length_m = glm::length(way);
    const Vec3 axis = way / length_m;
    const Vec3 begin_m = path.entry_reference_m - axis * settings_.before_m;
    const Vec3 end_m = path.target_reference_m + axis * settings_.beyond_m;
    const double walk_m = settings_.before_m + length_m + settings_.beyond_m;
    const auto& walk = path_.traverse(pair_.full_map.grid(), begin_m, end_m);
    steered_.full.force = &full_.solve(walk, walk_m, Borders::tissueChanges);
    steered_.partial.force = &partial_.solve(walk, walk_m, Borders::tissueChanges);
    steered_.full.segments = &full_.segments();
    steered_.partial.segments = &partial_.segments();
    steered_.entry_m = settings_.before_m;
    steered_.end_m = settings_.before_m + length_m;
    steered_.begin_m =
        std::min(firstContact(full_.segments(), walk_m), firstContact(partial_.segments(), walk_m));
}

void Steering::walkBreathing(const PlannedPath& path, const patient::Patient& patient,
                             haptics::ExactForce& force, std::vector<double>& samples_n) const {
    const Vec3 axis = glm::normalize(path.target_m - path.entry_m);
    haptics::NeedleState needle;
    haptics::NeedleEvents events;
    force.pieces.clear();
    force.events.clear();
    const auto stepTo = [&](double depth_m) {
        const auto tick =
            std::min(std::size_t(depth_m / (settings_.speed_m_s * kTick_s)), breath_.size() - 1);
        const Vec3 tip_m = path.entry_m + (depth_m - steered_.entry_m) * axis;
        haptics::stepNeedle(needle, settings_.needle, {patient, breath_[tick]}, {tip_m, axis}, events);
        for (int i = 0; i < events.count; ++i)
            force.events.push_back(makeExactEvent(events.list[std::size_t(i)], depth_m));
    };
    stepTo(0.0);
    for (std::size_t i = 0; i < samples_n.size(); ++i) {
        stepTo(steered_.first_m + double(i) * steered_.step_m);
        samples_n[i] = needle.force_n;
    }
}

const SteeringResult* Steering::steer(const PlannedPath& path) {
    solveStatic(path);
    SteeringResult& s = steered_;
    const double travel_m = s.end_m - s.begin_m;
    if (!(travel_m > 0.0)) return nullptr;
    const std::size_t count =
        std::max(std::size_t(settings_.samples), std::size_t(std::ceil(travel_m / settings_.max_spacing_m)));
    s.step_m = travel_m / double(count);
    s.first_m = s.begin_m + 0.5 * s.step_m;
    s.full.samples_n.resize(count);
    s.partial.samples_n.resize(count);
    if (settings_.breathing) {
        walkBreathing(path, pair_.full, breathing_full_, s.full.samples_n);
        walkBreathing(path, pair_.partial, breathing_partial_, s.partial.samples_n);
        s.full.force = &breathing_full_;
        s.partial.force = &breathing_partial_;
    } else {
        haptics::sampleForce(*s.full.force, s.first_m, s.step_m, s.full.samples_n);
        haptics::sampleForce(*s.partial.force, s.first_m, s.step_m, s.partial.samples_n);
    }
    return &s;
}

}  // namespace stylet::study
