// The scenario's assertions about the application. They are checked as frames are submitted, and reported
// at the end.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scenario/devices.h"
#include "scenario/json_fields.h"
#include "scenario/openxr_api.h"

namespace xrmock {

struct FramesAtLeast {
    std::uint64_t count;
};
enum class Counter { discarded, missed, refusals };
struct CountAtMost {
    Counter counter;
    std::uint64_t max_count;
};
enum class Part { projection, quad, cylinder, depth };
struct EveryFrameHas {
    Part part;
};
// Every view of every projection layer is within these limits of the eye's pose at the display time.
struct ViewsWithin {
    double position_m, angle_rad;
};
struct FormatIs {
    std::int64_t format;  // VkFormat of every view
};
struct DepthRange {
    // Allowed range of the near and the far distance of every view's depth.
    std::array<double, 2> near_m, far_m;
};
// Maximum number of haptic pulses that a session stores.
inline constexpr std::size_t kMaxPulses = 4096;
struct PulseWithin {
    std::optional<User> user;
    double from_s, to_s;
    std::uint64_t at_least;
    double amplitude_at_least;
};
struct PixelIs {
    std::uint64_t frame;
    std::size_t eye;
    double x, y;  // 0 to 1 from the top left
    std::array<double, 3> rgb;
    double tolerance;
};
struct StatesReached {
    std::vector<XrSessionState> states;  // reached in this order; other states may come between them
};

template <class Requirement>
inline constexpr bool kChecksEveryFrame =
    std::is_same_v<Requirement, EveryFrameHas> || std::is_same_v<Requirement, ViewsWithin> ||
    std::is_same_v<Requirement, FormatIs> || std::is_same_v<Requirement, DepthRange>;

struct Assertion {
    std::string name;
    std::uint64_t first_frame = 1, last_frame = std::numeric_limits<std::uint64_t>::max();
    std::variant<FramesAtLeast, CountAtMost, EveryFrameHas, ViewsWithin, FormatIs, DepthRange, PulseWithin,
                 PixelIs, StatesReached>
        requirement;
    // Result so far:
    std::uint64_t checked = 0;  // frames checked; for StatesReached: states reached
    std::string failure;        // reason of the first failure
};

std::vector<Assertion> parseAssertions(const Field& field);  // throws FieldError

}  // namespace xrmock
