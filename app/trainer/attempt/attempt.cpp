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

namespace stylet::trainer {

namespace {

// Part of the workspace that is kept for motion outside the skin, if the device's workspace is not known.
constexpr double kRoomOutside_m = 0.02;
// How far an exam displaces and tilts the line along which a device is placed.
constexpr double kLeastAside_m = 0.015, kMostAside_m = 0.03;
constexpr double kLeastTilt_rad = 0.20, kMostTilt_rad = 0.40;
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

// Displaces a line across its direction and tilts it, differently for each seed.
void misplace(Vec3& entry_m, Vec3& direction, double most_m, std::uint64_t seed) {
    Random random{seed ^ kAsideStream};
    const Vec3 across = glm::normalize(
        glm::cross(direction, std::fabs(direction.z) < 0.9 ? Vec3(0.0, 0.0, 1.0) : Vec3(0.0, 1.0, 0.0)));
    const Vec3 third = glm::cross(direction, across);
    const auto drawn = [&] {
        const double turn_rad = random.between(0.0, 2.0 * std::numbers::pi);
        return std::cos(turn_rad) * across + std::sin(turn_rad) * third;
    };
    entry_m += random.between(std::min(kLeastAside_m, most_m), most_m) * drawn();
    const double tilt_rad = random.between(kLeastTilt_rad, kMostTilt_rad);
    direction = std::cos(tilt_rad) * direction + std::sin(tilt_rad) * drawn();
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
    Vec3 entry_m = path.entry_m, direction = glm::normalize(path.target_m - path.entry_m);
    if (!rules.showsEntry() && profile.senses_rotation) {
        const double most_m = std::isnan(profile.workspace_radius_m)
                                  ? kMostAside_m
                                  : std::min(kMostAside_m, profile.workspace_radius_m / 3.0);
        misplace(entry_m, direction, most_m, config.seed);
    }
    const double half_way_m = 0.5 * (path.length_m - kRoomOutside_m);
    const Vec3 middle_m = entry_m + half_way_m * direction;
    Pose& placed = settings.patient_from_device;
    if (device.registration)
        placed = levelPatientFromDevice(
            *device.registration, stageFromPatient(patient, operativeField(patient, path, rules)), middle_m);
    else if (!std::isnan(profile.workspace_radius_m))
        placed = haptics::alignWithPath(profile, needlePose(entry_m, direction));
    else
        placed.position_m = middle_m - placed.rotation * device.device_from_grip.position_m;
    return {patient, settings, {}, std::move(touch), patient::makeDuctSpace(patient)};
}

}  // namespace stylet::trainer
