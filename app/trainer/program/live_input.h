// The trainee's own input: a force device, controllers in the headset, or the mouse in the window.
#pragma once

#include <cassert>
#include <memory>
#include <optional>
#include <string>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/attempt/config.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/attempt/tool_pose.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/live_hand.h"
#include "app/trainer/hands/mounted_device.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/program/task.h"

namespace stylet::trainer {

inline bool isLive(const AttemptConfig& config) {
    return config.device != kScriptedDevice && config.device != kReplayDevice;
}

// Live input of an attempt: ports, device and tool pose. The pose is used if the device senses no
// orientation.
struct Live {
    std::shared_ptr<ControllerPort> port;  // set for a controller; outlives the device
    std::shared_ptr<WindowPort> window = std::make_shared<WindowPort>();  // also outlives the device
    std::unique_ptr<LiveDevice> device;
    haptics::HapticDevice* loop_device = nullptr;  // the device as the loop uses it
    std::optional<Registration> registration;      // pose of `device` in the headset's room
    std::optional<MountedDevice> mounted;          // set by mount()
    Quat device_from_needle{};
    haptics::GuideSettings guide;
    std::optional<Pose> patient_from_driver;  // of mouse and controllers, which can place a tool (snap.h)

    // Makes the loop use the device through this mount.
    void mount(const Mount& mount) {
        assert(!mounted);  // *loop_device would be destroyed
        loop_device = &mounted.emplace(*loop_device, mount);
    }
    // Pose of `tool` in the device's axes, relative to a needle's tip.
    Pose toolPose(haptics::Tool tool) const {
        return toolPoseFromNeedle({device_from_needle, {}}, tool, guide);
    }
};

// Opens the input that the configuration names, waits until it is ready, and places it. With `retry`, the
// attempt begins with the recorded ticks. Throws UsageError, EnvironmentError and DataError.
Attempt liveAttempt(const AttemptConfig&, const Task&, Live&, const haptics::Clock&, const Retry* retry);

// Has mouse or controller place the tool on the skin. Returns why it cannot.
std::string snapToSkin(const Live&, const Attempt&, const training::DifficultyRules&,
                       const haptics::TickOutput&);

}  // namespace stylet::trainer
