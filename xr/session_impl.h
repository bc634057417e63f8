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

    // Returns true on success, false if the session is lost or exiting. Throws on any other failure.
    bool succeeded(XrResult result, const char* call, const char* meaning) {
        if (!handleLoss(result)) check(result, call, meaning);
        return !state_machine.isFinal();
    }
    // For optional calls: enters lossPending on a loss and ignores other failures. Returns true on a loss.
    bool handleLoss(XrResult result) {
        const bool lost = result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST ||
                          result == XR_SESSION_LOSS_PENDING;
        if (lost) state_machine.onLoss();
        return lost;
    }
    SessionPhase poll();
    void requestExit();
    // Requests exit of a running session and polls until it has ended, with a time limit.
    void endSession();

    void onEvent(const XrEventDataBuffer&);
    void onStateChanged(XrSessionState);
    void onEventsLost();
    void readProfiles();
    bool locateViews(Frame&);
    void acquireImages(Frame&);
    bool releaseImages();
    const XrCompositionLayerBaseHeader* projectionLayer(bool transparent);

    // Members are destroyed in reverse order of declaration.
    std::shared_ptr<void> device_owner;
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
    StateMachine state_machine;
    SessionEvents events;

    // Exactly as located: the submitted views must be bitwise equal to them.
    std::array<XrView, 2> views{};
    bool frame_begun = false;
    // Layers of the frame being ended. They are members so that frames do not allocate memory.
    std::array<XrCompositionLayerProjectionView, 2> eyes{};
    std::array<XrCompositionLayerDepthInfoKHR, 2> eye_depths{};
    XrCompositionLayerProjection projection{};
    std::vector<XrCompositionLayerQuad> behind, in_front;
    std::vector<const XrCompositionLayerBaseHeader*> layers;

    // For gripAt(), read from any thread: whether the session has input focus, and the last frame's display
    // time.
    std::atomic<bool> has_focus{false};
    std::atomic<XrTime> last_display{0};
};

}  // namespace stylet::xr
