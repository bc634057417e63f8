// Session state machine (OpenXR 1.0, "Session Lifecycle"), as a function of the session's target state.
#pragma once

#include <optional>

#include "scenario/openxr_api.h"
#include "scenario/scenario.h"

namespace xrmock {

struct SessionProgress {
    XrSessionState state = XR_SESSION_STATE_UNKNOWN;
    bool running = false;      // between xrBeginSession and xrEndSession
    bool frame_ended = false;  // a frame was submitted since xrBeginSession
};

// The next state towards the target. Returns nullopt at the target, or while the application must act
// first.
std::optional<XrSessionState> nextState(const SessionProgress& progress, SessionTarget target);

// Returns whether the step leads to a higher state. At most one such step is taken per frame, so that the
// application sees every state.
bool isUpwardStep(XrSessionState from, XrSessionState to);

}  // namespace xrmock
