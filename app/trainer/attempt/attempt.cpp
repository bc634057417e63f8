#include "app/trainer/attempt/attempt.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/random.h"
#include "app/trainer/session/colocation.h"
#include "app/training/infiltration.h"
#include "haptics/devices/clutch.h"
#include "haptics/output/safety.h"

namespace stylet::trainer {

namespace {

// Part of the workspace that is kept for motion outside the skin, if the device's workspace is not known.
constexpr double kRoomOutside_m = 0.02;
// How far from the middle of flank and liver an exam may put the middle of a device's workspace.
constexpr double kAround_m = 0.12;
constexpr int kPlaces = 100'000;  // places that are tried
constexpr std::uint64_t kPlaceStream = 0x506c616365;

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

// The middle of a device's workspace in an exam. It is the middle between flank and liver if the path is
// within reach from there. Otherwise places around it are drawn from the seed until the path is: then the
// place reveals no more than that. A radius that is not a number reaches everything. Throws UsageError if the
// path is longer than the workspace: a place on the path would reveal it.
Vec3 middleForExam(const OperativeField& field, const patient::PlannedPath& path,
                   const haptics::DeviceProfile& profile, std::uint64_t seed) {
    const Vec3 along = glm::normalize(path.target_m - path.entry_m);
    const double reach_m = (1.0 - haptics::kWallShare) * profile.workspace_radius_m;
    // A place in front of the skin that should be within reach too.
    const double outside_m = std::clamp(reach_m - 0.5 * path.length_m, 0.0, kRoomOutside_m);
    const Vec3 before_m = path.entry_m - outside_m * along;
    const Vec3 middle_m = 0.5 * (field.entry_m + field.inside_m);
    Random random{seed ^ kPlaceStream};
    const auto drawn = [&] { return random.between(-kAround_m, kAround_m); };
    Vec3 place_m = middle_m;
    for (int tries = 0; tries < kPlaces; ++tries) {
        if (!(glm::distance(place_m, before_m) > reach_m || glm::distance(place_m, path.target_m) > reach_m))
            return place_m;
        const double x_m = drawn(), y_m = drawn(), z_m = drawn();
        place_m = middle_m + Vec3(x_m, y_m, z_m);
    }
    throw UsageError(
        fmt::format("--difficulty exam: the path of {:.0f} mm is out of the reach of {}; use another path or "
                    "patient, a larger device, the mouse or controllers",
                    1e3 * path.length_m, profile.name));
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
                        const patient::PlannedPath& path, const OperativeField& field,
                        const AttemptConfig& config, haptics::TouchMap touch, const LiveDeviceFacts& device) {
    const haptics::DeviceProfile& profile = device.profile;
    haptics::SimulationSettings settings = simulationSettings(patient, scenario, config.seed, config.rate_hz);
    settings.profile = profile;
    if (const double longest_s = haptics::kMaxDelayTicks * settings.dt_s; profile.delay_s > longest_s)
        throw EnvironmentError(
            fmt::format("{} answers after {:.1f} ms. At this rate its force is stable only up to {:.1f} ms: "
                        "choose a lower --rate-hz.",
                        profile.name, 1e3 * profile.delay_s, 1e3 * longest_s));
    const Vec3 along = glm::normalize(path.target_m - path.entry_m);
    const bool hidden = !config.startRules().showsEntry(), bounded = !std::isnan(profile.workspace_radius_m);
    const Vec3 middle_m = hidden ? middleForExam(field, path, profile, config.seed)
                                 : path.entry_m + 0.5 * (path.length_m - kRoomOutside_m) * along;
    Pose& placed = settings.patient_from_device;
    if (device.registration)
        placed = levelPatientFromDevice(*device.registration, stageFromPatient(patient, field), middle_m);
    else if (bounded && !hidden)
        placed = haptics::alignWithPath(profile, needlePose(path.entry_m, along));
    else
        placed.position_m = middle_m - placed.rotation * (bounded ? profile.workspace_centre_m
                                                                  : device.device_from_grip.position_m);
    return {patient, settings, {}, std::move(touch), patient::makeDuctSpace(patient)};
}

}  // namespace stylet::trainer
