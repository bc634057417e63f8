// The session state machine (OpenXR 1.0, "Session Lifecycle") as a function of where the session is heading.
#pragma once

#include <optional>

#include "openxr_api.h"
#include "scenario.h"

namespace xrmock {

struct SessionProgress {
    XrSessionState state = XR_SESSION_STATE_UNKNOWN;
    bool running = false;      // between xrBeginSession and xrEndSession
    bool frame_ended = false;  // a frame was submitted since xrBeginSession
};

// The next state on the way to the target, or none when the session is there or waits for the application.
std::optional<XrSessionState> nextState(const SessionProgress& progress, SessionTarget target);

// Steps towards more of a session are taken one a frame, so that the application sees each of them.
bool isRise(XrSessionState from, XrSessionState to);

}  // namespace xrmock
