// Handles events from the runtime: session state, loss, reference spaces, controllers and the headset.
#include <utility>

#include "xr/session_impl.h"

namespace stylet::xr {
namespace {

template <typename Event>
const Event& eventCast(const XrEventDataBuffer& event) {
    return reinterpret_cast<const Event&>(event);
}

}  // namespace

SessionPhase Session::poll() {
    return impl_->poll();
}

SessionPhase Session::Impl::poll() {
    for (;;) {
        XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
        const XrResult result = xrPollEvent(instance.handle.get(), &event);
        if (result == XR_EVENT_UNAVAILABLE) break;
        if (!succeeded(result, "xrPollEvent", "the runtime has stopped answering")) break;
        onEvent(event);
    }
    has_focus = state_machine.phase == SessionPhase::focused;
    return state_machine.phase;
}

SessionEvents Session::popEvents() {
    return std::exchange(impl_->events, {});
}

void Session::Impl::onEvent(const XrEventDataBuffer& event) {
    switch (int(event.type)) {  // later.h defines some types outside the header's enumeration
        case XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED:
            onStateChanged(eventCast<XrEventDataSessionStateChanged>(event).state);
            break;
        case XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING:
            state_machine.onLoss();
            break;
        case XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING:
            if (const auto change =
                    spaces.toSpaceChange(eventCast<XrEventDataReferenceSpaceChangePending>(event)))
                events.spaces.push_back(*change);
            break;
        case XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED:
            readProfiles();
            break;
        case XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR:
            if (const auto view = eventCast<XrEventDataVisibilityMaskChangedKHR>(event).viewIndex; view < 2)
                events.hidden_area_changed[view] = true;
            break;
        case XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT:
            events.worn = bool(eventCast<XrEventDataUserPresenceChangedEXT>(event).isUserPresent);
            break;
        case XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB:
            facts.refresh_hz =
                double(eventCast<XrEventDataDisplayRefreshRateChangedFB>(event).toDisplayRefreshRate);
            break;
        case XR_TYPE_EVENT_DATA_EVENTS_LOST:
            onEventsLost();
            break;
        default:
            break;
    }
}

// Assumes that every kind of event was among the lost ones. For example, the stage's origin may have moved to
// an unknown place.
void Session::Impl::onEventsLost() {
    notes.push_back("xrPollEvent: the runtime has lost events");
    events.spaces.push_back({last_display, false, {}});
    events.hidden_area_changed = {true, true};
    readProfiles();
    if (const double rate_hz = refreshRate_hz(instance, session.get()); rate_hz > 0.0)
        facts.refresh_hz = rate_hz;
}

void Session::Impl::readProfiles() {
    events.profiles_changed = true;
    succeeded(input.readProfiles(instance, session.get(), facts.profiles), "xrGetCurrentInteractionProfile",
              "the runtime does not report which controllers are held");
}

void Session::Impl::onStateChanged(XrSessionState state) {
    switch (state_machine.onState(state)) {
        case SessionCall::begin: {
            auto info = makeStruct<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
            info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
            succeeded(xrBeginSession(session.get(), &info), "xrBeginSession",
                      "the runtime announced READY, then refused");
            break;
        }
        case SessionCall::end:
            succeeded(xrEndSession(session.get()), "xrEndSession",
                      "the runtime announced STOPPING, then refused");
            break;
        case SessionCall::none:
            break;
    }
}

}  // namespace stylet::xr
