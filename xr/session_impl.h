// The parts of a session, for the files that work on them: session (its life), events, frame (each frame).
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

// Near and far plane of depth images.
struct DepthRange {
    float near_m = 0, far_m = 0;
};

struct Session::Impl {
    Impl(const std::string& application_name, const SessionSettings&);

    // True on success. A lost session is a state, not an error; anything else that fails throws.
    bool usable(XrResult result, const char* call, const char* meaning) {
        if (!noticeLoss(result)) check(result, call, meaning);
        return !machine.over();
    }
    // All that counts of a call that one can do without.
    bool noticeLoss(XrResult result) {
        const bool lost = result == XR_ERROR_SESSION_LOST || result == XR_ERROR_INSTANCE_LOST ||
                          result == XR_SESSION_LOSS_PENDING;
        if (lost) machine.onLoss();
        return lost;
    }
    SessionPhase poll();
    void requestExit();
    // Asks a running session to end and polls until it has, for a while.
    void leave();

    void onEvent(const XrEventDataBuffer&);
    void onStateChanged(XrSessionState);
    void onEventsLost();
    void readProfiles();
    bool locateViews(Frame&);
    void acquireImages(Frame&);
    bool releaseImages();
    const XrCompositionLayerBaseHeader* projectionLayer(bool transparent);

    // Declaration order is teardown order, reversed.
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

    // As the runtime gave them: what is submitted must equal them to the bit.
    std::array<XrView, 2> views{};
    bool frame_begun = false;
    // The layers of the frame that ends: kept here, so that frames allocate nothing.
    std::array<XrCompositionLayerProjectionView, 2> eyes{};
    std::array<XrCompositionLayerDepthInfoKHR, 2> eye_depths{};
    XrCompositionLayerProjection projection{};
    std::vector<XrCompositionLayerQuad> behind, before;
    std::vector<const XrCompositionLayerBaseHeader*> layers;

    // For gripAt(), from any thread: the session has the focus, and the time of the last frame.
    std::atomic<bool> tracks{false};
    std::atomic<XrTime> last_display{0};
};

}  // namespace stylet::xr
