// Private parts of Session, shared by session.cpp (lifetime), events.cpp (events) and frame.cpp (frames).
#pragma once

#include <atomic>

#include "xr/headset.h"
#include "xr/input.h"
#include "xr/instance.h"
#include "xr/panels.h"
#include "xr/spaces.h"
#include "xr/state_machine.h"
#include "xr/swapchain.h"

namespace stylet::xr {

// Near and far plane of the depth images.
struct DepthRange {
    float near_m = 0, far_m = 0;
};

struct Session::Impl {
    Impl(const std::string& application_name, const SessionSettings&);

    // True on success. A lost session is a state, not an error: returns false. Any other failure throws.
    bool usable(XrResult result, const char* call, const char* meaning) {
        if (!noticeLoss(result)) check(result, call, meaning);
        return !machine.over();
    }
    // Checks an optional call: reacts to session loss and ignores other failures. Returns true on a loss.
    bool noticeLoss(XrResult result) {
        const bool lost = result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST ||
                          result == XR_SESSION_LOSS_PENDING;
        if (lost) machine.onLoss();
        return lost;
    }
    SessionPhase poll();
    void requestExit();
    // Requests exit of a running session and polls until it has ended, with a time limit.
    void leave();

    void onEvent(const XrEventDataBuffer&);
    void onStateChanged(XrSessionState);
    void onEventsLost();
    void readProfiles();
    bool locateViews(Frame&);
    void acquireImages(Frame&);
    bool releaseImages();
    const XrCompositionLayerBaseHeader* projectionLayer(bool transparent);

    // Members are destroyed in reverse order of declaration.
    std::shared_ptr<void> kept;
    const SessionSettings settings;
    std::vector<std::string> notes;
    Instance instance;
    Headset headset;
    RuntimeFacts facts;
    Owned<XrSession, xrDestroySession> session;
    Spaces spaces;
    Input input;
    std::vector<VkFormat> formats;
    Swapchain colour, depth;
    std::optional<DepthRange> depth_range;
    Panels panels;
    StateMachine machine;
    News news;

    // Exactly as located: the submitted views must be bitwise equal to them.
    std::array<XrView, 2> views{};
    bool frame_begun = false;
    // Layers of the frame being ended. Members, so that no frame allocates.
    std::array<XrCompositionLayerProjectionView, 2> eyes{};
    std::array<XrCompositionLayerDepthInfoKHR, 2> eye_depths{};
    XrCompositionLayerProjection projection{};
    std::vector<XrCompositionLayerQuad> behind, before;
    std::vector<const XrCompositionLayerBaseHeader*> layers;

    // For gripAt(), read from any thread: whether the session has input focus, and the last frame's display
    // time.
    std::atomic<bool> tracks{false};
    std::atomic<XrTime> last_display{0};
};

}  // namespace stylet::xr
