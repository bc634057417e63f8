// One frame: its time, views, images and submitted layers.
#include <algorithm>
#include <cassert>

#include "xr/session_impl.h"

namespace stylet::xr {
namespace {

constexpr XrDuration kImageTimeout_ns = 1'000'000'000;

template <typename Layer>
const XrCompositionLayerBaseHeader* baseHeader(const Layer& layer) {
    return reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer);
}

}  // namespace

Frame Session::beginFrame() {
    Impl& s = *impl_;
    assert(s.state_machine.running && !s.frame_begun);
    Frame frame;
    const char* meaning = "the runtime refuses the next frame";
    const XrFrameWaitInfo wait{XR_TYPE_FRAME_WAIT_INFO, nullptr};
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    if (!s.succeeded(xrWaitFrame(s.session.get(), &wait, &state), "xrWaitFrame", meaning)) return frame;
    frame.predicted_display_time_ns = state.predictedDisplayTime;
    frame.predicted_display_period_ns = state.predictedDisplayPeriod;
    s.last_display = state.predictedDisplayTime;
    if (s.facts.refresh_hz <= 0.0 && state.predictedDisplayPeriod > 0)
        s.facts.refresh_hz = 1e9 / double(state.predictedDisplayPeriod);
    if (!s.succeeded(s.input.sync(s.session.get(), s.spaces.stage(), state.predictedDisplayTime),
                     "xrSyncActions", "the controllers cannot be read"))
        return frame;
    // XR_FRAME_DISCARDED is a success code: the previous frame was dropped, but this one has begun.
    const XrFrameBeginInfo begin{XR_TYPE_FRAME_BEGIN_INFO, nullptr};
    if (!s.succeeded(xrBeginFrame(s.session.get(), &begin), "xrBeginFrame", meaning)) return frame;
    s.frame_begun = true;
    if (s.locateViews(frame) && state.shouldRender) s.acquireImages(frame);
    return frame;
}

void Session::Impl::acquireImages(Frame& frame) {
    const char* call = "xrAcquireSwapchainImage";
    const char* meaning = "no image to draw into";
    bool ready = false;
    if (!succeeded(colour.acquire(ready, kImageTimeout_ns), call, meaning) || !ready) return;
    if (depth.exists()) {
        bool depth_ready = false;
        if (!succeeded(depth.acquire(depth_ready, kImageTimeout_ns), call, meaning)) return;
        if (depth_ready) frame.depth_image = depth.image();
    }
    frame.should_render = true;
    frame.image = colour.image();
}

bool Session::lateUpdate(Frame& frame) {
    return impl_->frame_begun && impl_->locateViews(frame);
}

bool Session::Impl::locateViews(Frame& frame) {
    auto info = makeStruct<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
    info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    info.displayTime = frame.predicted_display_time_ns;
    info.space = spaces.stage();
    auto state = makeStruct<XrViewState>(XR_TYPE_VIEW_STATE);
    std::array<XrView, 2> found;
    found.fill({XR_TYPE_VIEW, nullptr, kIdentityPose, {}});
    std::uint32_t count = 0;
    if (!succeeded(xrLocateViews(session.get(), &info, &state, 2, &count, found.data()), "xrLocateViews",
                   "the runtime does not report the poses of the eyes"))
        return false;
    constexpr XrViewStateFlags kWhole =
        XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
    if ((state.viewStateFlags & kWhole) != kWhole || count != 2) return false;
    views = found;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const XrFovf& fov = views[eye].fov;
        frame.views[eye] = {toPose(views[eye].pose), fov.angleLeft, fov.angleRight, fov.angleUp,
                            fov.angleDown};
    }
    return true;
}

bool Session::Impl::releaseImages() {
    const char* call = "xrReleaseSwapchainImage";
    const char* meaning = "the image cannot be released";
    if (colour.isReady() && !succeeded(colour.release(), call, meaning)) return false;
    return !depth.isReady() || succeeded(depth.release(), call, meaning);
}

const XrCompositionLayerBaseHeader* Session::Impl::projectionLayer(bool transparent) {
    projection = makeStruct<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
    // Over the real room, alpha is premultiplied. Over panels, alpha is straight and either 0 or 1, and a
    // transparent pixel keeps its colour. The image is therefore complete even without the panels.
    if (transparent) projection.layerFlags = XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT;
    if (!behind.empty()) projection.layerFlags |= XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
    projection.space = spaces.stage();
    projection.viewCount = 2;
    projection.views = eyes.data();
    for (std::uint32_t eye = 0; eye < 2; ++eye)
        eyes[eye] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, views[eye].pose, views[eye].fov,
                     colour.subImage(eye)};
    return baseHeader(projection);
}

void Session::endFrame(const Frame& frame, std::span<const ShownPanel> shown) {
    Impl& s = *impl_;
    if (!s.frame_begun) return;  // the session was lost in beginFrame()
    s.frame_begun = false;
    const bool drawn = s.colour.isReady(), has_depth = s.depth.isReady();
    if (!s.releaseImages()) return;

    s.layers.clear();
    if (drawn) {
        s.panels.writeQuads(shown, true, s.spaces.stage(), s.spaces.head(), s.behind);
        s.panels.writeQuads(shown, false, s.spaces.stage(), s.spaces.head(), s.in_front);
        // Leave room for the projection layer.
        s.behind.resize(std::min(s.behind.size(), s.headset.max_layers - 1));
        for (const auto& quad : s.behind)
            s.layers.push_back(baseHeader(quad));
        s.layers.push_back(
            s.projectionLayer(!s.behind.empty() || s.headset.blend_mode != XR_ENVIRONMENT_BLEND_MODE_OPAQUE));
        for (std::uint32_t eye = 0; has_depth && eye < 2; ++eye) {
            // Reversed depth: the smallest value, 0, is at the far plane.
            s.eye_depths[eye] = {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR,
                                 nullptr,
                                 s.depth.subImage(eye),
                                 0.0f,
                                 1.0f,
                                 s.depth_range->far_m,
                                 s.depth_range->near_m};
            s.eyes[eye].next = &s.eye_depths[eye];
        }
        for (const auto& quad : s.in_front)
            s.layers.push_back(baseHeader(quad));
        s.layers.resize(std::min(s.layers.size(), s.headset.max_layers));
    }
    auto end = makeStruct<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
    end.displayTime = frame.predicted_display_time_ns;
    end.environmentBlendMode = s.headset.blend_mode;
    end.layerCount = std::uint32_t(s.layers.size());
    end.layers = s.layers.empty() ? nullptr : s.layers.data();
    s.succeeded(xrEndFrame(s.session.get(), &end), "xrEndFrame", "the runtime refuses the frame");
}

}  // namespace stylet::xr
