// How a small device drives a long needle. The Falcon reaches 80 mm and senses no orientation; a path has up
// to 90 mm and a direction.
//
// Direction: whatever was last told, so far the planned path's. Motion: millimetre
// for millimetre, never scaled, because force per millimetre is what is trained. Length: while the clutch
// button is held the needle stays where it is, without force, and the grip is drawn back; let go, the needle
// goes on from there, and the force comes back slowly. Placement: the path along the device's longest way,
// its entry near the end toward the hand.
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

// Haptics thread. One read of a device: `state` has the grip's pose and leaves with the needle's. Lost and
// found again, the needle is where it was, as after a clutch.
void stepClutch(ClutchState&, const ClutchSettings&, const Quat& device_from_needle, double dt_s,
                DeviceState& state) noexcept STYLET_NONBLOCKING;

// patient_from_device for a device without a place of its own in the room: the needle's axis along the
// device's z (toward the user), the patient's front up, and the tip at the path's entry when the grip is
// `before_m` short of the workspace's near end. The profile's workspace must be known.
Pose placeAlong(const DeviceProfile&, const Pose& patient_from_needle_at_entry,
                double before_m = 0.015) noexcept;

// Any device behind that rule. Its profile leaves the workspace unknown, for the needle's place is not the
// grip's; the grip's is judged here: where its mechanism cannot be (kReach) it counts as not ready. There is
// no soft wall: the mechanism's own stop ends the grip's way.
//
// The clutch's share of the force is taken after the output stage, so records hold the force before it. It is
// at most 1, and 0 at once with the clutch, so the hand never gets more than what is recorded.
class ClutchedDevice final : public HapticDevice {
  public:
    // The inner device must outlive it.
    ClutchedDevice(HapticDevice& inner, const ClutchSettings&, const Quat& device_from_needle);
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override;
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override;
    // Session or frame loop, one thread. Wait-free.
    void turn(const Quat& device_from_needle) noexcept { turned_.publish(device_from_needle); }

  private:
    HapticDevice* inner_;
    ClutchSettings settings_;
    DeviceProfile profile_;
    Vec3 reach_centre_m_;
    double reach_m_;  // NaN: unknown
    Snapshot<Quat> turned_;
    // Haptics thread.
    Quat device_from_needle_;
    ClutchState state_;
    std::int64_t last_ns_ = 0;
};

}  // namespace stylet::haptics
