// The session's life as the runtime announces it: what each state asks of the program, and when frames may be
// made.
#pragma once

#include "xr/check.h"

namespace stylet::xr {

enum class SessionAct { none, begin, end };

struct StateMachine {
    SessionPhase phase = SessionPhase::idle;
    bool running = false;  // between xrBeginSession and xrEndSession

    // The call the new state asks for. The caller makes it and then sets nothing: `running` already tells.
    SessionAct onState(XrSessionState);
    // A call or event said that session or instance is gone, or is about to go.
    void onLoss();
    // LOSS_PENDING and EXITING are final: this session will make no more frames.
    bool over() const { return phase == SessionPhase::lossPending || phase == SessionPhase::exiting; }
};

}  // namespace stylet::xr
