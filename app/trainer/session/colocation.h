// Aligns the drawn room with a haptic device whose place has been registered (co-location). The patient lies
// level, and the user sees a contact where the device renders its force.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/stores/registration_store.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

struct Colocation {
    Registration registration;
    Pose patient_from_device;  // SimulationSettings::patient_from_device of the attempt
};

// Rotation of the device in the drawn room. The device keeps its tilt and is turned about the vertical until
// its +z faces the operator.
Quat roomFromDeviceRotation(const Registration&);

// Returns patient_from_device for a patient that lies level in the room. The point `middle_m` (patient frame)
// is placed at the centre of the device's registered working cube.
Pose levelPatientFromDevice(const Registration&, const Pose& room_from_patient, const Vec3& middle_m);

// Pose of the runtime's space in the drawn room.
Pose roomFromStage(const Colocation&, const Pose& room_from_patient);

// Why the felt position may differ from the seen position.
enum class RoomWarning : std::uint8_t {
    none,
    unchecked,  // the runtime cannot confirm that this is the registered space
    moved,      // the runtime's space moved, and the picture was moved with it
    lost        // the space moved by an unknown amount: register again
};

// Frame thread. Tracks the pose of the OpenXR runtime's space in the drawn room (roomFromStage()), also when
// the space changes or another headset is connected. Without a colocation the pose is the identity, unless
// seated mode is on.
class RoomAlignment {
  public:
    RoomAlignment(std::optional<Colocation>, const Pose& room_from_patient, bool seated);

    // Call when a headset has been found. Returns a message for the user if the registration belongs to
    // another space; the registration is then not used. Otherwise returns an empty string.
    std::string begin(const std::string& space, const std::string& generation);
    // The runtime's space changes at `at_ns` (runtime time). nullopt: the new pose is unknown.
    void onChange(std::int64_t at_ns, const std::optional<Pose>& previous_from_new);
    // Applies the pending changes up to the display time.
    void advance(std::int64_t display_ns);
    // Eye height of a seated user above the floor. Only the first call after begin() counts.
    void setEyeHeight(double eyes_m);
    const Pose& roomFromStage() const { return room_from_stage_; }

    // While there is a warning, no force is rendered. The user calls confirm() to accept that felt and seen
    // positions agree, which clears the warning. RoomWarning::lost cannot be confirmed.
    RoomWarning warning() const { return warning_; }
    // Number of warnings so far. When it increases, the user must confirm again.
    std::uint64_t warningCount() const { return warning_count_; }
    void confirm();

    // Seated mode: height above the drawn floor at which the user's eyes are placed.
    static constexpr double kEyes_m = 1.60;

  private:
    struct Change {
        std::int64_t at_ns = 0;
        std::optional<Pose> previous_from_new;
    };
    void raise(RoomWarning);

    std::optional<Colocation> colocation_;
    Pose room_from_patient_, room_from_stage_;
    bool seated_, seat_known_ = false, used_ = false;
    RoomWarning warning_ = RoomWarning::none;
    std::uint64_t warning_count_ = 0;
    std::vector<Change> changes_;
};

}  // namespace stylet::trainer
