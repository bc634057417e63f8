#include "app/trainer/attempt/attempt.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/random.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/colocation.h"
#include "app/training/infiltration.h"
#include "haptics/devices/clutch.h"
#include "haptics/output/safety.h"

namespace stylet::trainer {

namespace {

// Part of the workspace that is kept for motion outside the skin, if the device's workspace is not known.
constexpr double kRoomOutside_m = 0.02;
// How far an exam displaces and tilts the line along which a device is placed.
constexpr double kLeastAside_m = 0.015, kMostAside_m = 0.03;
constexpr double kLeastTilt_rad = 0.20, kMostTilt_rad = 0.40;
// In a small workspace both are made smaller step by step, down to this share.
constexpr double kSmallerShare = 0.9, kLeastShare = 0.1;
constexpr std::uint64_t kAsideStream = 0x4173696465;

haptics::SimulationSettings simulationSettings(const patient::Patient& patient, const Scenario& scenario,
                                               std::uint64_t seed, double rate_hz) {
    haptics::SimulationSettings settings;
    settings.dt_s = std::round(1e9 / rate_hz) / 1e9;
    settings.patient_from_device = placeDeviceBeside(patient.grid());
    settings.output.model_tangent_n_per_m = haptics::maxTangent(patient.package().tissues, settings.tools);
    settings.tools.first = scenario.tool;
    settings.breath = breathPlan(patient.package(), scenario.breath, seed);
    settings.scenario_digest = digest(scenario);
    settings.seed = seed;
    return settings;
}

std::optional<haptics::TouchMap> touchMapFor(const patient::Patient& patient,
                                             const haptics::SimulationSettings& settings,
                                             const haptics::Trace& hand, const MakeTouch& make) {
    bool presses = haptics::pressesOnSkin(settings.tools.first);
    for (const haptics::TraceCommand& c : hand.commands)
        presses = presses || haptics::selectsSkinTool(c.command);
    if (!presses) return std::nullopt;
    return make(patient);
}

std::optional<patient::DuctSpace> ductSpaceFor(const patient::Patient& patient, const haptics::Trace& hand) {
    const bool uses =
        std::any_of(hand.commands.begin(), hand.commands.end(),
                    [](const haptics::TraceCommand& c) { return haptics::selectsAccessTool(c.command); });
    if (!uses) return std::nullopt;
    return patient::makeDuctSpace(patient);
}

// A line into the body: the needle's at its entry.
struct Line {
    Vec3 entry_m, direction;
};

// Displaces a line across its direction and tilts it further to that side, so that it stays beside the old
// line. `share` scales both.
Line besideOf(const Line& line, double share, Random& random) {
    const Vec3& along = line.direction;
    const Vec3 across = glm::normalize(
        glm::cross(along, std::fabs(along.z) < 0.9 ? Vec3(0.0, 0.0, 1.0) : Vec3(0.0, 1.0, 0.0)));
    const Vec3 third = glm::cross(along, across);
    const auto toward = [&](double turn_rad) {
        return std::cos(turn_rad) * across + std::sin(turn_rad) * third;
    };
    const double turn_rad = random.between(0.0, 2.0 * std::numbers::pi);
    const double further_rad = turn_rad + random.between(-0.25, 0.25) * std::numbers::pi;
    const double aside_m = share * random.between(kLeastAside_m, kMostAside_m);
    const double tilt_rad = share * random.between(kLeastTilt_rad, kMostTilt_rad);
    return {line.entry_m + aside_m * toward(turn_rad),
            std::cos(tilt_rad) * along + std::sin(tilt_rad) * toward(further_rad)};
}

// The device's place for a line, if its workspace is known. The path must be within reach in any case.
Pose alignForExam(const haptics::DeviceProfile& profile, const Line& path, double length_m,
                  std::uint64_t seed) {
    const auto isInReach = [&](const Pose& placed) {
        const double reach_m = (1.0 - haptics::kWallShare) * profile.workspace_radius_m;
        for (const double along_m : {0.0, length_m})
            if (glm::length(placed.inverse() * (path.entry_m + along_m * path.direction) -
                            profile.workspace_centre_m) > reach_m)
                return false;
        return true;
    };
    Random random{seed ^ kAsideStream};
    for (double share = 1.0; share > kLeastShare; share *= kSmallerShare) {
        const Line line = besideOf(path, share, random);
        const Pose placed = haptics::alignWithPath(profile, needlePose(line.entry_m, line.direction));
        if (isInReach(placed)) return placed;
    }
    // The path fills the workspace: this tells where it runs, but an exam that cannot be done is worse.
    return haptics::alignWithPath(profile, needlePose(path.entry_m, path.direction));
}

}  // namespace

std::int64_t Attempt::begun_ns() const noexcept {
    return std::int64_t(beginning.size()) * std::llround(simulation.dt_s * 1e9);
}

void equip(Attempt& attempt, const haptics::ToolSettings& tools) {
    haptics::SimulationSettings& settings = attempt.simulation;
    const haptics::Tool first = settings.tools.first;
    settings.tools = tools;
    settings.tools.first = first;
    settings.output.model_tangent_n_per_m =
        haptics::maxTangent(attempt.patient.package().tissues, settings.tools);
}

haptics::TouchMap makeTouch(const patient::Patient& patient) {
    return haptics::makeTouchMap(patient);
}

patient::BreathPlan breathPlan(const patient::Package& package, const ScenarioBreath& scenario,
                               std::uint64_t seed) {
    patient::BreathPlan plan = scenario.plan;
    plan.rhythm = package.signal;
    plan.rhythm.period_s = scenario.period_s.value_or(plan.rhythm.period_s);
    plan.rhythm.amplitude = scenario.amplitude.value_or(plan.rhythm.amplitude);
    plan.seed = seed;
    const double dome_travel_m = package.motion.dome_travel_m;
    plan.hold.creep_v = dome_travel_m > 0.0 ? -scenario.creep_m / dome_travel_m : 0.0;
    return plan;
}

Attempt makeAttempt(const patient::Patient& patient, const Scenario& scenario,
                    const patient::PlannedPath& path, std::uint64_t seed, double rate_hz,
                    const MakeTouch& make_touch) {
    const haptics::SimulationSettings settings = simulationSettings(patient, scenario, seed, rate_hz);
    const double breath_s = patient::longestBreath_s(*settings.breath, settings.dt_s);
    haptics::Trace hand =
        makeScriptedTrace(scenario, path, breath_s, settings, seed, training::capsuleDepth_m(patient, path));
    std::optional<haptics::TouchMap> touch = touchMapFor(patient, settings, hand, make_touch);
    std::optional<patient::DuctSpace> ducts = ductSpaceFor(patient, hand);
    return {patient, settings, std::move(hand), std::move(touch), std::move(ducts)};
}

Attempt makeLiveAttempt(const patient::Patient& patient, const Scenario& scenario,
                        const patient::PlannedPath& path, const AttemptConfig& config,
                        haptics::TouchMap touch, const LiveDeviceFacts& device) {
    const haptics::DeviceProfile& profile = device.profile;
    haptics::SimulationSettings settings = simulationSettings(patient, scenario, config.seed, config.rate_hz);
    settings.profile = profile;
    if (const double longest_s = haptics::kMaxDelayTicks * settings.dt_s; profile.delay_s > longest_s)
        throw EnvironmentError(
            fmt::format("{} answers after {:.1f} ms. At this rate its force is stable only up to {:.1f} ms: "
                        "choose a lower --rate-hz.",
                        profile.name, 1e3 * profile.delay_s, 1e3 * longest_s));
    const training::DifficultyRules& rules = config.startRules();
    const Line line{path.entry_m, glm::normalize(path.target_m - path.entry_m)};
    const bool hidden = !rules.showsEntry() && profile.senses_rotation;
    Random random{config.seed ^ kAsideStream};
    const Line shown = hidden ? besideOf(line, 1.0, random) : line;
    const Vec3 middle_m = shown.entry_m + 0.5 * (path.length_m - kRoomOutside_m) * shown.direction;
    Pose& placed = settings.patient_from_device;
    if (device.registration)
        placed = levelPatientFromDevice(
            *device.registration, stageFromPatient(patient, operativeField(patient, path, rules)), middle_m);
    else if (!std::isnan(profile.workspace_radius_m))
        placed = hidden ? alignForExam(profile, line, path.length_m, config.seed)
                        : haptics::alignWithPath(profile, needlePose(line.entry_m, line.direction));
    else
        placed.position_m = middle_m - placed.rotation * device.device_from_grip.position_m;
    return {patient, settings, {}, std::move(touch), patient::makeDuctSpace(patient)};
}

}  // namespace stylet::trainer
