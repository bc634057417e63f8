// Clutching lets a small device drive a long needle. The Falcon reaches 80 mm and senses no orientation, but
// a path is up to 90 mm long and has a direction.
//
// Direction: setTool() sets it for the active tool. A needle lies along the planned path. A probe is turned
// so that its guide lies there.
// Motion: unscaled, one millimetre per millimetre, because the trainee learns the force per millimetre.
// Length: while the clutch button is pressed, the needle keeps its place and there is no force. The user
// draws the grip back. On release the needle follows again and the force rises slowly.
// Placement: the path lies along the device's longest axis, its entry near the end toward the user.
#pragma once

#include <cstdint>

#include "base/rings.h"
#include "haptics/tools/device.h"

namespace stylet::haptics {

struct ClutchSettings {
    std::uint32_t button = 1u << 2;  // the Falcon's centre button
    double force_ramp_s = 0.2;
};

struct ClutchState {
    bool has_pose = false;      // a pose has been received
    bool engaged = false;       // the needle follows the grip
    Vec3 tip_m{0.0};            // device frame
    Vec3 tip_from_grip_m{0.0};  // tip - grip
    double force_share = 0.0;   // fraction of the force that is sent
};

// Haptics thread. Processes one device read: `state` enters with the grip's pose and leaves with the tool's.
// `tool` has the tool's orientation in the device frame and the offset of its tip from the tip that a needle
// would have at the same grip. After a reconnection the needle continues from its last position, as after
// clutching.
void stepClutch(ClutchState&, const ClutchSettings&, const Pose& tool, double dt_s,
                DeviceState& state) noexcept STYLET_NONBLOCKING;

// Moves `now` toward `wanted`, at most as fast as a hand would turn and move a tool. A tool in contact
// therefore does not tear through the tissue.
Pose moveToward(const Pose& now, const Pose& wanted, double dt_s) noexcept STYLET_NONBLOCKING;

// Returns patient_from_device for a device that is not registered to the room. The needle's axis lies along
// the device's z (toward the user) and the patient's front is up. The path's entry is near the workspace's
// end toward the user, with room left before the soft wall. The profile's workspace must be known.
Pose alignWithPath(const DeviceProfile&, const Pose& patient_from_needle_at_entry) noexcept;

// Adds clutching to any device. DeviceState also reports the grip's position and the clutch's force share;
// the output stage uses them for the wall, the reach check and the energy account.
class ClutchedDevice final : public HapticDevice {
  public:
    // `inner` must outlive this object.
    ClutchedDevice(HapticDevice& inner, const ClutchSettings&, const Pose& tool);
    const DeviceProfile& profile() const noexcept override { return inner_->profile(); }
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override;
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { inner_->send(force_n); }
    // Session or frame loop, one thread. Wait-free. Sets the wanted orientation and offset of the tool. The
    // tool turns there gradually.
    void setTool(const Pose& tool) noexcept { requested_tool_.publish(tool); }

  private:
    HapticDevice* inner_;
    ClutchSettings settings_;
    Snapshot<Pose> requested_tool_;
    // Haptics thread.
    Pose tool_, target_tool_;
    ClutchState state_;
    std::int64_t last_ns_ = 0;
};

}  // namespace stylet::haptics
