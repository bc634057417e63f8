#include <algorithm>
#include <chrono>

#include "api/api.h"
#include "world/capture.h"
#include "world/director.h"
#include "world/layers.h"
#include "world/objects.h"
#include "world/verify.h"

namespace xrmock {

namespace {

Session& runningSession(Call& call, XrSession handle) {
    Session& session = call.live<Session>(handle);
    require(session.progress.running, XR_ERROR_SESSION_NOT_RUNNING, "the session does not run");
    return session;
}

// Identifies one run of a session. A waiting call releases the lock; meanwhile the run may end, and the
// session may be lost or destroyed.
struct Run {
    std::uint64_t session;
    std::uint64_t run;
};

// Returns the session, or null if the run is over.
Session* findRunning(const Run& run) {
    auto* session = static_cast<Session*>(runtime().handles.find(run.session));
    const bool is_running = session != nullptr && session->progress.running && session->run == run.run &&
                            session->loss != Loss::lost && session->instance.conditions.loss != Loss::lost;
    return is_running ? session : nullptr;
}

Session& requireSameRun(Call& call, XrSession handle, const Run& run) {
    Session& session = runningSession(call, handle);
    require(session.run == run.run, XR_ERROR_SESSION_NOT_RUNNING, "the session was ended meanwhile");
    return session;
}

// xrWaitFrame blocks until the previous frame has begun.
void waitForPreviousFrame(Call& call, const Run& run) {
    runtime().changed.wait(call.lock, [&] {
        const Session* session = findRunning(run);
        return session == nullptr || (!session->frames.waiting && !session->frames.waited);
    });
}

// Waits for a step while a control client has paused the run. Pacing restarts afterwards, so that refreshes
// during the pause do not count as missed.
void waitForStep(Call& call, const Run& run) {
    // Poll, because the control thread does not notify `changed`.
    constexpr std::chrono::milliseconds kPollInterval{5};
    for (Session* session = findRunning(run); session != nullptr; session = findRunning(run)) {
        Instance& instance = session->instance;
        const std::int64_t now_ns = instance.clock.now(monotonicNs());
        applyDueEvents(instance, now_ns);
        if (mayProceed(instance, now_ns)) return;
        session->frames.paced = false;
        runtime().changed.wait_for(call.lock, kPollInterval);
    }
}

void sleepUntil(Call& call, const Run& run, std::int64_t wake_ns) {
    const std::chrono::steady_clock::time_point wake{std::chrono::nanoseconds(wake_ns)};
    runtime().changed.wait_until(call.lock, wake, [&] { return findRunning(run) == nullptr; });
}

void requireEnvironmentBlendMode(const Scenario& scenario, XrEnvironmentBlendMode mode) {
    requireValid(mode >= XR_ENVIRONMENT_BLEND_MODE_OPAQUE && mode <= XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND,
                 "environmentBlendMode is no known value");
    const auto& offered = scenario.offers.blend_modes;
    require(std::find(offered.begin(), offered.end(), mode) != offered.end(),
            XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED, "the headset does not have this blend mode");
}

}  // namespace

XrResult waitFrame(Call& call, XrSession handle, const XrFrameWaitInfo* info, XrFrameState* state) {
    Session* session = &runningSession(call, handle);
    if (info != nullptr) requireStruct(info, XR_TYPE_FRAME_WAIT_INFO);
    requireStruct(state, XR_TYPE_FRAME_STATE);
    const Run run{session->handle, session->run};
    waitForPreviousFrame(call, run);
    session = &requireSameRun(call, handle, run);

    session->frames.waiting = true;
    if (session->instance.control) waitForStep(call, run);
    session = &requireSameRun(call, handle, run);

    Instance& instance = session->instance;
    ++instance.conditions.frames_waited;
    applyDueEvents(instance, instance.clock.now(monotonicNs()));
    session = &runningSession(call, handle);
    const FrameOverride frame_override = popFrameOverride(instance);
    const std::int64_t period_ns = refreshPeriodNs(instance.scenario);
    const FramePlan plan =
        planFrame(session->frames, instance.clock, monotonicNs(), period_ns, frame_override.late_refreshes);
    if (!instance.clock.is_virtual) sleepUntil(call, run, plan.wake_ns);
    session = &requireSameRun(call, handle, run);

    session->frames.waiting = false;
    session->frames.waited = true;
    session->frames.paced = true;
    session->frames.last_display_ns = plan.display_ns;
    session->instance.statistics.missed += plan.missed;
    session->frames.frame_override = frame_override;
    if (session->instance.clock.is_virtual) session->instance.clock.virtual_now_ns = plan.display_ns;
    applyDueEvents(session->instance, session->instance.clock.now(monotonicNs()));
    session = &runningSession(call, handle);
    state->predictedDisplayTime = plan.display_ns;
    state->predictedDisplayPeriod = period_ns;
    const XrSessionState session_state = session->progress.state;
    session->frames.frame_override.should_render =
        frame_override.should_render &&
        (session_state == XR_SESSION_STATE_VISIBLE || session_state == XR_SESSION_STATE_FOCUSED);
    state->shouldRender = session->frames.frame_override.should_render;
    return XR_SUCCESS;
}

XrResult beginFrame(Call& call, XrSession handle, const XrFrameBeginInfo* info) {
    Session& session = runningSession(call, handle);
    if (info != nullptr) requireStruct(info, XR_TYPE_FRAME_BEGIN_INFO);
    require(session.frames.waited, XR_ERROR_CALL_ORDER_INVALID, "no frame was waited for");
    const bool discarded = session.frames.begun || session.frames.frame_override.discarded;
    if (discarded) ++session.instance.statistics.discarded;
    session.frames.begun_override = session.frames.frame_override;
    session.frames.waited = false;
    session.frames.begun = true;
    runtime().changed.notify_all();
    return discarded ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

XrResult endFrame(Call& call, XrSession handle, const XrFrameEndInfo* info) {
    Session& session = runningSession(call, handle);
    requireStruct(info, XR_TYPE_FRAME_END_INFO);
    require(session.frames.begun, XR_ERROR_CALL_ORDER_INVALID, "no frame was begun");
    requireTime(info->displayTime);
    requireEnvironmentBlendMode(session.instance.scenario, info->environmentBlendMode);
    const SubmittedFrame frame = checkFrame(call, session, *info);
    observeFrame(call, session, frame);
    captureIfDue(call, session, frame);

    session.frames.begun = false;
    session.progress.frame_ended = true;
    ++session.frames_submitted;
    ++session.instance.statistics.submitted;
    advance(session, session.instance.clock.now(call.now_ns), true);
    return XR_SUCCESS;
}

}  // namespace xrmock
