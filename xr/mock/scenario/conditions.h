// Current state of the simulated runtime. The director sets it; the API calls read it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scenario/pose.h"

namespace xrmock {

// Pending: the loss has been announced (XrEventDataInstanceLossPending, or the success code
// XR_SESSION_LOSS_PENDING). Lost: every call except destruction is refused.
enum class Loss { none, pending, lost };

// Scripted treatment of one frame.
struct FrameOverride {
    std::uint32_t late_refreshes = 0;  // number of refreshes that xrWaitFrame skips, as after a stall
    bool should_render = true;         // false: XrFrameState::shouldRender is false in every session state
    bool discarded = false;            // xrBeginFrame returns XR_FRAME_DISCARDED
    bool dropped = false;              // xrEndFrame accepts the frame, but it is never shown
};

struct FrameOverrides {
    FrameOverride frame_override;
    std::uint64_t count = 1;  // applies to the next `count` waited frames
};

// Pose of a reference space's origin from a time (XrTime) on, in the room frame. The room frame is the frame
// of the scenario's poses; it equals STAGE at the start.
struct OriginKey {
    std::int64_t from_ns;
    Pose room_from_origin;
};
// A step function, sorted by time. Times before the first key use the first key. `keys` must not be empty.
inline const Pose& originAt(const std::vector<OriginKey>& keys, std::int64_t time_ns) {
    std::size_t at = keys.size() - 1;
    while (at > 0 && keys[at].from_ns > time_ns)
        --at;
    return keys[at].room_from_origin;
}

// Per instance. The current refresh rate and the interaction profiles are not here: they are `refresh_hz`
// and the keys of `devices` in the instance's copy of the scenario, which events also change.
struct Conditions {
    Loss loss = Loss::none;
    std::int64_t lost_at_ns = 0;                            // when the pending loss takes effect
    std::vector<OriginKey> local{{0, {}}}, stage{{0, {}}};  // recentring appends a key
    std::vector<OriginKey> stationary{{0, {}}};
    std::uint8_t generation = 1;      // generation of the stationary space
    std::uint32_t mask_revision = 0;  // increases with each change of the visibility mask
    bool user_present = true;         // XR_EXT_user_presence
    bool head_tracked = true;         // false: views have no valid pose
    std::vector<FrameOverrides> frame_overrides;
    std::uint64_t frames_waited = 0;  // over all sessions: number of the latest waited frame, starting at 1
};

}  // namespace xrmock
