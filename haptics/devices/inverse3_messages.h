// The JSON of Haply's Inverse Service, versions 3.1 to 3.5. No I/O.
// Facts from docs.haply.co (inverseSDK/service: websocket-protocol, control-commands, http, commons/basis;
// 3.1.1 and 3.5). Haply's frame, which a session keeps that sets no basis: x right, y forward, z up. The
// device frame: x right, y up, z toward the user.
// Unproven without hardware: that services before 3.5 want `values` and do not send a session_id, and that
// the grip points along its +y.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "haptics/device.h"

namespace stylet::haptics::inverse3 {

// A message beyond these is refused unread.
inline constexpr std::size_t kMostBytes = 256 * 1024;
inline constexpr int kDeepest = 16;
inline constexpr std::size_t kMostDevices = 16;
inline constexpr double kFarthest_m = 2.0;

// How set_cursor_force names its argument: `vector` since 3.5, `values` before.
enum class Spelling { vector, values };

// What a message of the service says about the first Inverse3 and the first VerseGrip (wireless, wired or
// custom, in that order) that it lists.
struct Update {
    bool present = false;  // there is an Inverse3
    std::string device_id;
    Vec3 cursor_m{0.0};  // Haply's frame
    // From `status`; a service that does not say is taken to be well.
    bool calibrated = true, ready = true, powered = true;

    bool grip_present = false;
    Quat haply_from_grip{1.0, 0.0, 0.0, 0.0};
    std::uint32_t buttons = 0;  // a, b, c or button_0 ... as bits from the lowest

    bool has_session = false;  // session_id is there
};

// Empty when the message is not JSON within the bounds, or a field it needs is missing, of another type, not
// finite or out of reach; `why` then says which. Never throws but bad_alloc.
std::optional<Update> parseUpdate(std::string_view text, std::string& why);

// The spelling that a service of this /version document wants; empty when the document names no version.
std::optional<Spelling> spellingOf(std::string_view version_document);

// One command: the force on the cursor, N, given in the device frame and written in Haply's. `device_id` is
// one that parseUpdate() let pass.
void writeForce(std::string& text, std::string_view device_id, const Vec3& force_n, Spelling);

// The stylus (tip at origin, +z to the hub) as held in the grip, which points along its +y; device frame.
Pose stylusPose(const Update&) noexcept;

}  // namespace stylet::haptics::inverse3
