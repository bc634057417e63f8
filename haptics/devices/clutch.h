// How a small device drives a long needle. The Falcon reaches 80 mm and senses no orientation; a path has up
// to 90 mm and a direction.
//
// Direction: as it is told for the tool in hand, so that a needle lies along the planned path and a probe has
// its guide there. Motion: millimetre for millimetre, never scaled, because force per millimetre is what is
// trained. Length: while the clutch button is held the needle stays where it is, without force, and the grip
// is drawn back; let go, the needle goes on from there, and the force comes back slowly. Placement: the path
// along the device's longest way, its entry near the end toward the hand.
#pragma once

#include <cstdint>

#include "haptics/device.h"
#include "haptics/rings.h"

namespace stylet::haptics {

struct ClutchSettings {
    std::uint32_t button = 1u << 2;  // the Falcon's centre button
    double force_back_s = 0.2;
};

struct ClutchState {
    bool placed = false;        // there has been a pose
    bool engaged = false;       // the needle goes with the grip
    Vec3 tip_m{0.0};            // device frame
    Vec3 tip_from_grip_m{0.0};  // tip - grip
    double force_share = 0.0;   // of what is sent
};

// Haptics thread. One read of a device: `state` has the grip's pose and leaves with the tool's. `held`, in
// the device's axes: how the tool is turned, and where its tip is from a needle's. Lost and found again, the
// needle is where it was, as after a clutch.
void stepClutch(ClutchState&, const ClutchSettings&, const Pose& held, double dt_s,
                DeviceState& state) noexcept STYLET_NONBLOCKING;

// From `now` toward `wanted`, as far as a hand would turn and move a tool in `dt_s`: a tool that touches
// something is not torn through it.
Pose turnToward(const Pose& now, const Pose& wanted, double dt_s) noexcept STYLET_NONBLOCKING;

// patient_from_device for a device without a place of its own in the room: the needle's axis along the
// device's z (toward the user), the patient's front up, and the path's entry near the workspace's near end,
// the soft wall and some room before it left free. The profile's workspace must be known.
Pose placeAlong(const DeviceProfile&, const Pose& patient_from_needle_at_entry) noexcept;

// Any device behind that rule. It says where the grip is beside the tip, and the share of the force that the
// clutch leaves (DeviceState): the output stage keeps wall, reach and account by them.
class ClutchedDevice final : public HapticDevice {
  public:
    // The inner device must outlive it.
    ClutchedDevice(HapticDevice& inner, const ClutchSettings&, const Pose& held);
    const DeviceProfile& profile() const noexcept override { return inner_->profile(); }
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override;
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { inner_->send(force_n); }
    // Session or frame loop, one thread. Wait-free.
    // The tool is turned so from now on, not at once.
    void hold(const Pose& held) noexcept { wanted_.publish(held); }

  private:
    HapticDevice* inner_;
    ClutchSettings settings_;
    Snapshot<Pose> wanted_;
    // Haptics thread.
    Pose held_, held_in_the_end_;
    ClutchState state_;
    std::int64_t last_ns_ = 0;
};

}  // namespace stylet::haptics
