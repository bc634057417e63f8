// What a scenario demands of the application: looked at as frames come, told in the report.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "devices.h"
#include "json_fields.h"
#include "openxr_api.h"

namespace xrmock {

class Call;
struct Instance;
struct Session;
struct SubmittedFrame;

struct FramesAtLeast {
    std::uint64_t count;
};
enum class Counted { discarded, missed, refusals };
struct CountAtMost {
    Counted counted;
    std::uint64_t most;
};
enum class Part { projection, quad, cylinder, depth };
struct EveryFrameHas {
    Part part;
};
// Every view of every projection layer is where the eye is at the display time.
struct ViewsWithin {
    double position_m, angle_rad;
};
struct FormatIs {
    std::int64_t format;  // VkFormat of every view
};
struct DepthRange {
    std::array<double, 2> near_m, far_m;  // the distances that the depth of every view may span
};
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
    std::vector<XrSessionState> states;  // in this order, others may lie between
};

struct Assertion {
    std::string name;
    std::uint64_t first_frame = 1, last_frame = std::numeric_limits<std::uint64_t>::max();
    std::variant<FramesAtLeast, CountAtMost, EveryFrameHas, ViewsWithin, FormatIs, DepthRange, PulseWithin,
                 PixelIs, StatesReached>
        demand;
    // So far:
    std::uint64_t checked = 0;  // frames, or states of StatesReached
    std::string failure;        // the first one
};

std::vector<Assertion> parseAssertions(const Field& field);  // throws FieldError

// Frames that the application was told to render.
void assertFrame(Call& call, Session& session, const SubmittedFrame& frame);
void assertState(Instance& instance, XrSessionState state);
// At the end: why the demand is not met; empty when it is.
std::string verdict(const Assertion& assertion, const Instance& instance);

}  // namespace xrmock
