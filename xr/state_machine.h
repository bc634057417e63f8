// Session state machine: the call that each new state requires, and whether frames may be rendered.
#pragma once

#include "xr/check.h"

namespace stylet::xr {

enum class SessionCall { none, begin, end };

struct StateMachine {
    SessionPhase phase = SessionPhase::idle;
    bool running = false;  // between xrBeginSession and xrEndSession

    // Returns the call that the new state requires. The caller must make it; `running` is already updated.
    SessionCall onState(XrSessionState);
    // A call or an event reported that the session or instance is lost or about to be lost.
    void onLoss();
    // True in LOSS_PENDING and EXITING, which are final: this session renders no more frames.
    bool isFinal() const { return phase == SessionPhase::lossPending || phase == SessionPhase::exiting; }
};

}  // namespace stylet::xr
