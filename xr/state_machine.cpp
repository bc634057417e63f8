#include "xr/state_machine.h"

namespace stylet::xr {

SessionAct StateMachine::onState(XrSessionState state) {
    if (over()) return SessionAct::none;
    switch (state) {
        case XR_SESSION_STATE_IDLE:
            phase = SessionPhase::idle;
            return SessionAct::none;
        case XR_SESSION_STATE_READY:
            phase = SessionPhase::ready;
            if (running) return SessionAct::none;
            running = true;
            return SessionAct::begin;
        case XR_SESSION_STATE_SYNCHRONIZED:
            phase = SessionPhase::synchronized;
            return SessionAct::none;
        case XR_SESSION_STATE_VISIBLE:
            phase = SessionPhase::visible;
            return SessionAct::none;
        case XR_SESSION_STATE_FOCUSED:
            phase = SessionPhase::focused;
            return SessionAct::none;
        case XR_SESSION_STATE_STOPPING:
            phase = SessionPhase::stopping;
            if (!running) return SessionAct::none;
            running = false;
            return SessionAct::end;
        case XR_SESSION_STATE_LOSS_PENDING:
            onLoss();
            return SessionAct::none;
        case XR_SESSION_STATE_EXITING:
            phase = SessionPhase::exiting;
            running = false;
            return SessionAct::none;
        default:
            return SessionAct::none;
    }
}

void StateMachine::onLoss() {
    // EXITING is not overridden: the user has asked to quit.
    if (phase != SessionPhase::exiting) phase = SessionPhase::lossPending;
    running = false;
}

}  // namespace stylet::xr
