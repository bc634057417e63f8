// What the scenario has brought about: state that the director sets and the calls honour.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pose.h"

namespace xrmock {

// Pending is told (XR_SESSION_LOSS_PENDING is a success; XrEventDataInstanceLossPending); lost refuses every
// call but the destruction.
enum class Loss { none, pending, lost };

// What becomes of one frame.
struct FrameFate {
    std::uint32_t late_refreshes = 0;  // xrWaitFrame skips so many refreshes, as after a stall
    bool should_render = true;         // false: XrFrameState::shouldRender is false, whatever the state
    bool discarded = false;            // xrBeginFrame gives XR_FRAME_DISCARDED
    bool dropped = false;              // xrEndFrame takes it and it is never shown
};

struct FrameFates {
    FrameFate fate;
    std::uint64_t count = 1;  // of the frames that are waited for next
};

// Where a reference space stands from a time on (XrTime), in the room: the axes of the scenario's poses,
// where STAGE stands at the start.
struct OriginKey {
    std::int64_t from_ns;
    Pose room_from_origin;
};
// Steps, by time; the first holds before it too. Never empty.
inline const Pose& originAt(const std::vector<OriginKey>& keys, std::int64_t time_ns) {
    std::size_t at = keys.size() - 1;
    while (at > 0 && keys[at].from_ns > time_ns)
        --at;
    return keys[at].room_from_origin;
}

// Of an instance. The refresh rate that holds now is `scenario.refresh_hz`, and interaction profiles are keys
// of `scenario.devices`: events change them like everything else in the instance's copy of the scenario.
struct Conditions {
    Loss loss = Loss::none;
    std::int64_t lost_at_ns = 0;                            // when pending becomes lost
    std::vector<OriginKey> local{{0, {}}}, stage{{0, {}}};  // recentring appends
    std::vector<OriginKey> stationary{{0, {}}};
    std::uint8_t generation = 1;      // of the stationary space
    std::uint32_t mask_revision = 0;  // grows when the visibility mask changes
    bool user_present = true;         // XR_EXT_user_presence
    bool head_tracked = true;         // else no view has a valid pose
    std::vector<FrameFates> fates;
    std::uint64_t frames_waited = 0;  // by all sessions: the number of the newest frame, 1 for the first
};

}  // namespace xrmock
