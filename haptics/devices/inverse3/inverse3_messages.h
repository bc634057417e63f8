// JSON messages of Haply's Inverse Service, versions 3.1 to 3.5. No I/O.
// Facts from docs.haply.co (inverseSDK/service: websocket-protocol, control-commands, http, commons/basis;
// 3.1.1 and 3.5). Haply's frame is x right, y forward, z up; a session that sets no basis uses it. The
// device frame is x right, y up, z toward the user.
// Unproven without hardware: that services before 3.5 expect `values` and send no session_id, and that the
// grip points along its +y.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "haptics/tools/device.h"

namespace stylet::haptics::inverse3 {

// Limits. A message beyond them is rejected.
inline constexpr std::size_t kMaxMessageBytes = 256 * 1024;
inline constexpr int kMaxNesting = 16;
inline constexpr std::size_t kMaxDevices = 16;
inline constexpr double kFarthest_m = 2.0;

// Name of the argument of set_cursor_force: `vector` since 3.5, `values` before.
enum class Spelling { vector, values };

// Content of one service message: the first Inverse3 and the first VerseGrip (wireless, wired or custom, in
// that order) that it lists.
struct Update {
    bool present = false;  // an Inverse3 is listed
    std::string device_id;
    Vec3 cursor_m{0.0};  // Haply's frame
    // From `status`. Missing fields count as true.
    bool calibrated = true, ready = true, powered = true;

    bool grip_present = false;
    Quat haply_from_grip{1.0, 0.0, 0.0, 0.0};
    std::uint32_t buttons = 0;  // a, b, c or button_0 ... as bits from the lowest

    bool has_session = false;  // session_id is present
};

// Returns empty with a reason in `why` if the message is not JSON within the limits, or if a required field
// is missing, of the wrong type, not finite or out of range. Throws nothing but bad_alloc.
std::optional<Update> parseUpdate(std::string_view text, std::string& why);

// The spelling that a service with this /version document expects. Empty if the document names no version.
std::optional<Spelling> parseSpelling(std::string_view version_document);

// Writes one command to `text`: the cursor force, N, given in the device frame and written in Haply's frame.
// `device_id` must be one that parseUpdate() accepted.
void writeForce(std::string& text, std::string_view device_id, const Vec3& force_n, Spelling);

// The stylus pose (tip at origin, +z to the hub) in the device frame. The stylus points along the grip's +y.
Pose stylusPose(const Update&) noexcept;

}  // namespace stylet::haptics::inverse3
