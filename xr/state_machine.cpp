#include "xr/state_machine.h"

namespace stylet::xr {

SessionCall StateMachine::onState(XrSessionState state) {
    if (isFinal() || state < XR_SESSION_STATE_IDLE || state > XR_SESSION_STATE_EXITING)
        return SessionCall::none;
    static_assert(int(SessionPhase::exiting) == XR_SESSION_STATE_EXITING - XR_SESSION_STATE_IDLE);
    phase = SessionPhase(state - XR_SESSION_STATE_IDLE);  // both enumerations have the same order
    const bool was_running = running;
    if (state == XR_SESSION_STATE_READY) running = true;
    if (state >= XR_SESSION_STATE_STOPPING) running = false;
    if (state == XR_SESSION_STATE_READY && !was_running) return SessionCall::begin;
    if (state == XR_SESSION_STATE_STOPPING && was_running) return SessionCall::end;
    return SessionCall::none;
}

void StateMachine::onLoss() {
    // EXITING is not overridden: the user has asked to quit.
    if (phase != SessionPhase::exiting) phase = SessionPhase::lossPending;
    running = false;
}

}  // namespace stylet::xr
