// A registered haptic device and the room that is drawn: the patient is placed so that what is felt at the
// device is seen there, and he lies level.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/registration_store.h"
#include "patient/planning.h"

namespace stylet::trainer {

struct Colocation {
    Registration registration;
    patient::Pose patient_from_device;  // of the attempt
};

// The device in the room: as it is tilted, turned about the vertical so that its +z faces the operator.
patient::Quat roomFromDeviceRotation(const Registration&);

// the path, from outside the body (< 0) to where it ends.
patient::Pose levelPatientFromDevice(const Registration&, const patient::Pose& room_from_patient,
                                     const patient::Vec3& middle_m);

// Where the runtime's space lies in the room that is drawn.
patient::Pose roomFromStage(const Colocation&, const patient::Pose& room_from_patient);

// Why what is felt may not be where it is seen.
enum class RoomDoubt : std::uint8_t {
    none,
    unchecked,  // nothing of the runtime's says that its space is the one of the registration
    moved,      // the picture was moved along with the space
    lost        // nobody knows how far it has moved: only another registration helps
};

// Where the runtime's space lies in the room that is drawn, from frame to frame and from headset to headset.
// Without a colocation both are the same, but for who sits. Frame thread.
class RoomPlace {
  public:
    RoomPlace(std::optional<Colocation>, const patient::Pose& room_from_patient, bool seated);

    // A headset was found. A sentence when the registration is of another space: it is not used then.
    std::string begin(const std::string& space, const std::string& generation);
    // Its space will mean other places from `at_ns` on; nothing: nobody knows which. The runtime's time.
    void onChange(std::int64_t at_ns, const std::optional<patient::Pose>& previous_from_new);
    // The display time has come so far.
    void advance(std::int64_t display_ns);
    // How high the eyes of who sits are above the floor; the first time counts.
    void sitDown(double eyes_m);
    const patient::Pose& roomFromStage() const { return room_from_stage_; }

    // While there is one, no force: until the user says that what he sees is where he feels it.
    RoomDoubt doubt() const { return doubt_; }
    std::uint64_t doubts() const { return doubts_; }  // so far: another number is another reason to ask
    void confirm();

    // Where who sits has his eyes.
    static constexpr double kEyes_m = 1.60;

  private:
    struct Change {
        std::int64_t at_ns = 0;
        std::optional<patient::Pose> previous_from_new;
    };
    void raise(RoomDoubt);

    std::optional<Colocation> colocation_;
    patient::Pose room_from_patient_, room_from_stage_;
    bool seated_, seat_known_ = false, used_ = false;
    RoomDoubt doubt_ = RoomDoubt::none;
    std::uint64_t doubts_ = 0;
    std::vector<Change> changes_;
};

}  // namespace stylet::trainer
