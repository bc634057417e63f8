// What control clients may ask; SCENARIO.md lists it. Requests are served inside the application's calls.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "openxr_api.h"

namespace xrmock {

class Call;
struct Instance;
struct Session;
struct SubmittedFrame;

// A reply that waits for something to come about.
struct Promise {
    std::uint64_t client = 0;
    std::string id;  // of the request, as JSON; empty: it had none
    std::optional<std::uint64_t> frame;
    std::optional<double> t_s;
    std::optional<XrSessionState> state;
    std::optional<std::uint64_t> haptic_pulses;
    std::optional<std::size_t> eye;  // a picture of the next frame
    bool steps = false;              // until the steps are done
};

struct Lockstep {
    bool paused = false;
    std::uint64_t steps = 0;  // frames that may still go on
};

// Opens the socket of the environment. Throws std::runtime_error.
void openControl(Instance& instance);
// Does what clients asked since the last call, and keeps the promises that are due.
void serveControl(Instance& instance, std::int64_t now_ns);
// Whether the frame that is waited for may go on; takes a step if that is what it needs.
bool mayGoOn(Instance& instance, std::int64_t now_ns);
// Pictures that clients asked for, inside xrEndFrame.
void servePictures(Call& call, Session& session, const SubmittedFrame& frame);

// One request applied to an instance without a socket: what the fuzzer drives. The reply, or nothing for now.
std::string serveRequest(Instance& instance, std::uint64_t client, const std::string& line,
                         std::int64_t now_ns);

}  // namespace xrmock
