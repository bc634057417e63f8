// Events that happen once, at a time or at a frame. SCENARIO.md lists the kinds; the director applies them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scenario/conditions.h"
#include "scenario/timeline.h"

namespace xrmock {

// Visible area of a lens: a convex polygon, counter-clockwise, in tangents of view angles (x right, y up,
// on the plane one metre in front of the eye). Empty: everything is visible.
using LensOutline = std::vector<std::array<double, 2>>;

struct Recentring {
    XrReferenceSpaceType space = XR_REFERENCE_SPACE_TYPE_LOCAL;
    std::optional<Pose> room_from_origin;  // nullopt: at the head or below it, upright
    bool pose_valid = true;
    double delay_s = 0;  // from the event to its changeTime
};
struct MaskChange {
    std::optional<std::array<LensOutline, 2>> lens;  // nullopt: only send the event
};
struct ProfileChange {
    std::string profile;
};
struct RefreshRateChange {
    double hz;
};
struct PresenceChange {
    bool present;
};
struct HeadTracking {
    bool tracked;
};
struct SessionLoss {
    std::optional<double> lost_after_s;  // nullopt: the loss stays pending
};
struct InstanceLoss {
    double lost_after_s;
};
// Refuses the nth to (nth + times - 1)th call after the event, or all calls for a duration.
struct Refusal {
    std::string function;
    XrResult result = XR_ERROR_RUNTIME_FAILURE;
    std::uint64_t nth = 1, times = 1;
    std::optional<double> for_s;
};
// Delays the nth call after the event by this long, in real time.
struct Stall {
    std::string function;
    double for_s = 0;
    std::uint64_t nth = 1;
};
struct TargetChange {
    SessionTarget target;
};
struct CaptureRequest {
    std::string name;
};

struct Event {
    std::optional<std::uint64_t> frame;  // due when this frame is waited for, starting at 1; otherwise
    double t_s = 0;                      // due from this time on
    std::variant<Recentring, MaskChange, ProfileChange, RefreshRateChange, PresenceChange, HeadTracking,
                 SessionLoss, InstanceLoss, Refusal, Stall, FrameOverrides, TargetChange, CaptureRequest>
        action;
};

std::vector<Event> parseEvents(const Field& field, const ReadContext& context);  // throws FieldError
SessionTarget parseTarget(const Field& field);
// Returns the name after "capture:". Empty if the label has no such prefix, or if the name is not a plain
// file name.
std::string captureName(const std::string& label);
// Reads { "outline": [[x, y], ...] } or { "radius": r, "centre": [x, y] }. This is the lens of the left eye;
// the right lens is its mirror image.
std::array<LensOutline, 2> parseLens(const Field& field);

}  // namespace xrmock
