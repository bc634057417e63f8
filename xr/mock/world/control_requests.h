// Requests of control clients, listed in SCENARIO.md. They are handled inside the application's OpenXR
// calls.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenario/openxr_api.h"

namespace xrmock {

class Call;
struct Instance;
struct Session;
struct SubmittedFrame;

// A pending reply: sent when its condition is met.
struct PendingReply {
    std::uint64_t client = 0;
    std::string id;  // the request's id as JSON; empty if it had none
    std::optional<std::uint64_t> frame;
    std::optional<double> t_s;
    std::optional<XrSessionState> state;
    std::optional<std::uint64_t> haptic_pulses;
    std::optional<std::size_t> eye;  // eye whose image of the next frame is requested
    bool steps = false;              // reply when the steps are done
};

struct Lockstep {
    bool paused = false;
    std::uint64_t steps = 0;  // number of frames that may still proceed
};

// Opens the socket named by XRMOCK_CONTROL, if set. Throws std::runtime_error.
void openControl(Instance& instance);
// Handles the requests received since the last call and sends the pending replies whose condition is met.
void serveControl(Instance& instance, std::int64_t now_ns);
// Returns whether the waited frame may proceed. Uses up one step if the run is paused.
bool mayProceed(Instance& instance, std::int64_t now_ns);
// Sends the images that clients requested. Called inside xrEndFrame.
void sendPictures(Call& call, Session& session, const SubmittedFrame& frame);

// Handles one request without a socket; used by the fuzzer. Returns the reply, or "" if it is pending.
std::string serveRequest(Instance& instance, std::uint64_t client, const std::string& line,
                         std::int64_t now_ns);

}  // namespace xrmock
