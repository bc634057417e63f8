#include "world/session_state.h"

namespace xrmock {

std::optional<XrSessionState> nextState(const SessionProgress& progress, SessionTarget target) {
    const bool leaving = target <= SessionTarget::stopped;
    switch (progress.state) {
        case XR_SESSION_STATE_UNKNOWN:
            return XR_SESSION_STATE_IDLE;
        case XR_SESSION_STATE_IDLE:
            if (target == SessionTarget::exiting) return XR_SESSION_STATE_EXITING;
            if (!leaving) return XR_SESSION_STATE_READY;
            return std::nullopt;
        case XR_SESSION_STATE_READY:
            // Only a synchronized session can be stopped. A session that exits early therefore passes
            // through SYNCHRONIZED.
            if (progress.running && (progress.frame_ended || leaving)) return XR_SESSION_STATE_SYNCHRONIZED;
            return std::nullopt;
        case XR_SESSION_STATE_SYNCHRONIZED:
            if (leaving) return XR_SESSION_STATE_STOPPING;
            if (target >= SessionTarget::visible) return XR_SESSION_STATE_VISIBLE;
            return std::nullopt;
        case XR_SESSION_STATE_VISIBLE:
            if (target < SessionTarget::visible) return XR_SESSION_STATE_SYNCHRONIZED;
            if (target == SessionTarget::focused) return XR_SESSION_STATE_FOCUSED;
            return std::nullopt;
        case XR_SESSION_STATE_FOCUSED:
            if (target < SessionTarget::focused) return XR_SESSION_STATE_VISIBLE;
            return std::nullopt;
        case XR_SESSION_STATE_STOPPING:
            if (!progress.running) return XR_SESSION_STATE_IDLE;
            return std::nullopt;
        default:
            return std::nullopt;
    }
}

bool isUpwardStep(XrSessionState from, XrSessionState to) {
    return from >= XR_SESSION_STATE_READY && from < XR_SESSION_STATE_FOCUSED && to == from + 1;
}

}  // namespace xrmock
