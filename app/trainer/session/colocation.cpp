#include "app/trainer/session/colocation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <utility>

namespace stylet::trainer {

Quat roomFromDeviceRotation(const Registration& registration) {
    // An axis counts as vertical if the horizontal component of its unit vector is shorter than this (within
    // 11.5 degrees).
    constexpr double kLevel = 0.2;
    const Pose& stage_from_device = registration.stage_from_device;
    Vec3 to_operator = stage_from_device.direction({0.0, 0.0, 1.0});
    // Normally the device's +z axis points to the operator. If +z points up, the -y axis does. If +z points
    // down, the +y axis does.
    if (std::hypot(to_operator.x, to_operator.z) < kLevel)
        to_operator = stage_from_device.direction({0.0, to_operator.y > 0.0 ? -1.0 : 1.0, 0.0});
    return glm::angleAxis(-std::atan2(to_operator.x, to_operator.z), Vec3(0.0, 1.0, 0.0)) *
           stage_from_device.rotation;
}

Pose levelPatientFromDevice(const Registration& registration, const Pose& room_from_patient,
                            const Vec3& middle_m) {
    const Quat rotation =
        glm::normalize(glm::inverse(room_from_patient.rotation) * roomFromDeviceRotation(registration));
    return {rotation, middle_m - rotation * registration.centre_m};
}

Pose roomFromStage(const Colocation& c, const Pose& room_from_patient) {
    return room_from_patient * c.patient_from_device * c.registration.rigid().inverse();
}

RoomAlignment::RoomAlignment(std::optional<Colocation> colocation, const Pose& room_from_patient, bool seated)
    : colocation_(std::move(colocation)), room_from_patient_(room_from_patient), seated_(seated) {}

void RoomAlignment::raise(RoomWarning warning) {
    ++warning_count_;
    warning_ = std::max(warning_, warning);
}

void RoomAlignment::confirm() {
    if (warning_ != RoomWarning::lost) warning_ = RoomWarning::none;
}

std::string RoomAlignment::begin(const std::string& space, const std::string& generation) {
    changes_.clear();
    room_from_stage_ = {};
    seat_known_ = false;
    if (!colocation_) return "";
    const RegistrationKey& key = colocation_->registration.key;
    const bool was_used = used_;
    used_ = key.space == space && key.generation == generation;
    if (used_) {
        room_from_stage_ = trainer::roomFromStage(*colocation_, room_from_patient_);
        if (generation.empty()) raise(RoomWarning::unchecked);
        return "";
    }
    if (was_used) raise(RoomWarning::lost);
    return "the " + key.device +
           " was registered in another room than this headset's: forces are not felt "
           "where they are seen; run \"stylet register\" again";
}

void RoomAlignment::onChange(std::int64_t at_ns, const std::optional<Pose>& previous_from_new) {
    changes_.push_back({at_ns, previous_from_new});
}

void RoomAlignment::advance(std::int64_t display_ns) {
    while (!changes_.empty() && changes_.front().at_ns <= display_ns) {
        const Change change = changes_.front();
        changes_.erase(changes_.begin());
        if (!used_) continue;
        raise(change.previous_from_new ? RoomWarning::moved : RoomWarning::lost);
        if (!change.previous_from_new) continue;
        Pose& stage_from_device = colocation_->registration.stage_from_device;
        stage_from_device = change.previous_from_new->inverse() * stage_from_device;
        room_from_stage_ = trainer::roomFromStage(*colocation_, room_from_patient_);
    }
}

void RoomAlignment::setEyeHeight(double eyes_m) {
    if (!seated_ || used_ || seat_known_) return;
    seat_known_ = true;
    room_from_stage_.position_m.y = kEyes_m - eyes_m;
}

}  // namespace stylet::trainer
