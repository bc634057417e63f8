#include "app/trainer/program/live_input.h"

#include <fmt/core.h>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/snap.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/trainer/stores/registration_store.h"

namespace stylet::trainer {

namespace {

// Makes the attempt begin with the recorded ticks, and converts the device's poses to the device frame of the
// record. Only for devices without force output; liveAttempt() handles the others.
void resume(Live& live, Attempt& attempt, const Retry* retry) {
    if (!retry) return;
    const Pose own = *live.patient_from_driver;
    startFromRecord(attempt, *retry);
    live.mount({.recorded_from_device = attempt.simulation.patient_from_device.inverse() * own});
}

// Controllers are tracked in the drawn room, so they need no registration. They are available only while the
// attempt runs, because the OpenXR session belongs to its pictures.
Attempt controllerAttempt(const AttemptConfig& config, const Task& task, Live& live,
                          const haptics::Clock& clock, const Retry* retry) {
    catchInterrupts();
    live.port = std::make_shared<ControllerPort>();
    live.device = std::make_unique<LiveDevice>(
        kControllers, std::make_unique<ControllerDriver>(*live.port, controllerSide(config.hand), clock),
        clock);
    Attempt attempt = makeLiveAttempt(task.patient, task.scenario, task.path, task.field, config,
                                      task.make_touch(task.patient), {.profile = controllerProfile()});
    live.patient_from_driver = stageFromPatient(task.patient, task.field).inverse();
    attempt.simulation.patient_from_device = *live.patient_from_driver;
    live.loop_device = &live.device->bare();
    resume(live, attempt, retry);
    return attempt;
}

// The device frame of the mouse is the patient frame.
Attempt mouseAttempt(const AttemptConfig& config, const Task& task, Live& live, const haptics::Clock& clock,
                     const Retry* retry) {
    catchInterrupts();
    live.window->enableToolInput();
    live.window->publish(retry ? retry->left.tool : task.scenario.tool, 0.0);
    Attempt attempt = makeLiveAttempt(task.patient, task.scenario, task.path, task.field, config,
                                      task.make_touch(task.patient), {.profile = mouseProfile()});
    live.patient_from_driver = Pose{};
    attempt.simulation.patient_from_device = {};
    const haptics::GuideSettings& guide = attempt.simulation.tools.guide;
    const Pose start =
        retry && retry->left.tick > 0
            ? retry->left.patient_from_tool * toolPoseFromNeedle({}, retry->left.tool, guide).inverse()
            : mouseStart(config.startRules().start, task.patient, task.path, config.seed);
    live.device = std::make_unique<LiveDevice>(
        kMouse, std::make_unique<MouseDriver>(*live.window, start, guide, clock), clock);
    live.loop_device = &live.device->bare();
    resume(live, attempt, retry);
    return attempt;
}

}  // namespace

Attempt liveAttempt(const AttemptConfig& config, const Task& task, Live& live, const haptics::Clock& clock,
                    const Retry* retry) {
    live.window->enableCommands();
    if (config.device == kControllers) return controllerAttempt(config, task, live, clock, retry);
    if (config.device == kMouse) return mouseAttempt(config, task, live, clock, retry);
    haptics::TouchMap touch =
        task.make_touch(task.patient);  // first, because the user may move a device that is ready
    catchInterrupts();
    live.device = openReadyDevice(config.device, config.device_options, clock);
    if (!config.startRules().showsEntry() && !live.device->profile().senses_rotation)
        throw UsageError(
            fmt::format("--difficulty exam: {} senses no rotation, so it holds the needle along the planned "
                        "path; use a device that senses rotation, the mouse or controllers",
                        live.device->profile().name));
    if (live.device->exertsForce()) live.window->enableRearm();
    live.registration = newestRegistration(dataFolder() / "registrations", config.device,
                                           std::string(live.device->profile().name));
    Attempt attempt =
        makeLiveAttempt(task.patient, task.scenario, task.path, task.field, config, std::move(touch),
                        {live.device->profile(), live.device->grip(), live.registration});
    haptics::SimulationSettings& settings = attempt.simulation;
    if (retry) settings.patient_from_device = retry->record.header.settings.patient_from_device;
    const Pose needle = needlePose(task.path.entry_m, glm::normalize(task.path.target_m - task.path.entry_m));
    live.device_from_needle = settings.patient_from_device.inverse().rotation * needle.rotation;
    live.guide = settings.tools.guide;
    live.loop_device = &live.device->loopDevice(live.toolPose(retry ? retry->left.tool : task.scenario.tool));
    if (live.registration && live.device->profile().senses_rotation)
        live.mount({.stylus_from_tip_m = live.registration->stylus_from_tip_m});
    settings.profile = live.loop_device->profile();
    if (retry && !haveSameForceLimits(settings.profile, retry->record.header.settings.profile))
        throw DataError(config.device, "--from",
                        "the attempt was made with another device, whose limits are part of it: use that "
                        "device, the mouse or controllers");
    if (retry) startFromRecord(attempt, *retry);
    return attempt;
}

std::string snapToSkin(const Live& live, const Attempt& attempt, const training::DifficultyRules& rules,
                       const haptics::TickOutput& now) {
    std::string why_not;
    std::optional<Pose> pose = poseOnSkin(rules, now, attempt.patient, *attempt.touchMap(), why_not);
    if (!pose) return why_not;
    pose->position_m += now.patient_moved_m;
    return requestSnap(live.patient_from_driver->inverse() * *pose, live.port.get(), *live.window);
}

}  // namespace stylet::trainer
