#include "world/director.h"

#include <algorithm>
#include <cmath>

#include "world/call.h"
#include "world/spaces.h"

namespace xrmock {

namespace {

std::int64_t nanoseconds(double seconds) {
    return std::llround(seconds * 1e9);
}

// The upright pose at the head. For STAGE and the stationary space, the pose on the floor below the head.
Pose originAtHead(const Instance& instance, XrReferenceSpaceType space, std::int64_t time_ns) {
    Pose origin = yawOnly(stageFromHead(instance, time_ns));
    if (space != XR_REFERENCE_SPACE_TYPE_LOCAL) origin.position[1] = 0;
    return origin;
}

void announceRecentring(Instance& instance, XrReferenceSpaceType space, std::int64_t change_ns, bool valid,
                        const Pose& room_from_before, const Pose& room_from_after) {
    const Session* session = findSession(instance);
    if (session == nullptr) return;
    const auto handle = toHandle<XrSession>(*session);
    const Pose before_from_after = valid ? inverse(room_from_before) * room_from_after : Pose{};
    instance.events.push(
        XrEventDataReferenceSpaceChangePending{XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING, nullptr,
                                               handle, space, change_ns, valid, toXr(before_from_after)});
}

void apply(Instance& instance, std::int64_t now_ns, const Recentring& recentring) {
    const std::int64_t change_ns = now_ns + nanoseconds(recentring.delay_s);
    const bool is_stage = recentring.space == XR_REFERENCE_SPACE_TYPE_STAGE;
    const bool is_local = recentring.space == XR_REFERENCE_SPACE_TYPE_LOCAL;
    Conditions& conditions = instance.conditions;
    std::vector<OriginKey>& origins =
        is_stage ? conditions.stage : (is_local ? conditions.local : conditions.stationary);
    std::erase_if(origins, [&](const OriginKey& key) { return key.from_ns > change_ns; });
    const Pose before = originAt(origins, change_ns);
    const Pose floor_before = stageFromLocalFloor(instance, change_ns);
    const Pose after =
        recentring.room_from_origin.value_or(originAtHead(instance, recentring.space, change_ns));
    origins.push_back({change_ns, after});
    const bool is_stationary = !is_stage && !is_local;
    if (is_stationary) ++conditions.generation;
    if (!is_stationary || instance.extensions.contains(XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME))
        announceRecentring(instance, recentring.space, change_ns, recentring.pose_valid, before, after);
    if (is_stationary) return;
    // LOCAL_FLOOR moves with LOCAL, and vertically with STAGE.
    const Pose floor_after = stageFromLocalFloor(instance, change_ns);
    const bool floor_moved = is_local || floor_after.position[1] != floor_before.position[1];
    if (!floor_moved || !instance.extensions.contains(XR_EXT_LOCAL_FLOOR_EXTENSION_NAME)) return;
    announceRecentring(instance, XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT, change_ns, recentring.pose_valid,
                       floor_before, floor_after);
}

void apply(Instance& instance, std::int64_t, const MaskChange& change) {
    if (change.lens) instance.scenario.lens = *change.lens;
    ++instance.conditions.mask_revision;
    const Session* session = findSession(instance);
    if (session == nullptr || !instance.extensions.contains(XR_KHR_VISIBILITY_MASK_EXTENSION_NAME)) return;
    const auto handle = toHandle<XrSession>(*session);
    for (std::uint32_t view = 0; view < 2; ++view)
        instance.events.push(
            XrEventDataVisibilityMaskChangedKHR{XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR, nullptr,
                                                handle, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, view});
}

void apply(Instance& instance, std::int64_t now_ns, const ProfileChange& change) {
    switchProfile(instance.scenario.devices, change.profile, instance.clock.scenarioSeconds(now_ns));
}

void apply(Instance& instance, std::int64_t, const RefreshRateChange& change) {
    changeRefreshRate(instance, change.hz);
}

void apply(Instance& instance, std::int64_t, const PresenceChange& change) {
    if (instance.conditions.user_present == change.present) return;
    instance.conditions.user_present = change.present;
    Session* session = findSession(instance);
    if (session != nullptr && session->progress.running) announcePresence(*session);
}

void apply(Instance& instance, std::int64_t, const HeadTracking& change) {
    instance.conditions.head_tracked = change.tracked;
}

void apply(Instance& instance, std::int64_t now_ns, const SessionLoss& loss) {
    Session* session = findSession(instance);
    if (session == nullptr || session->loss != Loss::none) return;
    if (loss.lost_after_s) session->lost_at_ns = now_ns + nanoseconds(*loss.lost_after_s);
    session->loss = session->lost_at_ns == now_ns ? Loss::lost : Loss::pending;
    if (session->loss == Loss::pending) enter(*session, XR_SESSION_STATE_LOSS_PENDING, now_ns);
    runtime().changed.notify_all();
}

void apply(Instance& instance, std::int64_t now_ns, const InstanceLoss& loss) {
    if (instance.conditions.loss != Loss::none) return;
    instance.conditions.loss = Loss::pending;
    instance.conditions.lost_at_ns = now_ns + nanoseconds(loss.lost_after_s);
    instance.events.push(XrEventDataInstanceLossPending{XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, nullptr,
                                                        instance.conditions.lost_at_ns});
}

void apply(Instance& instance, std::int64_t now_ns, const Refusal& refusal) {
    instance.faults.push_back({refusal, now_ns + nanoseconds(refusal.for_s.value_or(0))});
}

void apply(Instance& instance, std::int64_t, const Stall& stall) {
    instance.stalls.push_back(stall);
}

void apply(Instance& instance, std::int64_t, const FrameOverrides& frame_overrides) {
    instance.conditions.frame_overrides.push_back(frame_overrides);
}

void apply(Instance& instance, std::int64_t now_ns, const TargetChange& change) {
    const double now_s = instance.clock.scenarioSeconds(now_ns);
    auto& keys = instance.scenario.session;
    const auto later =
        std::find_if(keys.begin(), keys.end(), [&](const TargetKey& key) { return key.t_s > now_s; });
    keys.insert(later, {now_s, change.target});
}

void apply(Instance& instance, std::int64_t, const CaptureRequest& request) {
    Session* session = findSession(instance);
    if (session != nullptr && !instance.capture_folder.empty()) session->capture_name = request.name;
}

// Completes pending losses whose time has come.
void completeLosses(Instance& instance, std::int64_t now_ns) {
    Conditions& conditions = instance.conditions;
    Session* session = findSession(instance);
    const bool session_lost = session != nullptr && session->loss == Loss::pending && session->lost_at_ns &&
                              now_ns >= *session->lost_at_ns;
    const bool instance_lost = conditions.loss == Loss::pending && now_ns >= conditions.lost_at_ns;
    if (session_lost) session->loss = Loss::lost;
    if (instance_lost) conditions.loss = Loss::lost;
    if (session_lost || instance_lost) runtime().changed.notify_all();
}

}  // namespace

void applyDueEvents(Instance& instance, std::int64_t now_ns) {
    serveControl(instance, now_ns);
    completeLosses(instance, now_ns);
    std::vector<Event>& events = instance.scenario.events;
    if (events.empty()) return;
    const double now_s = instance.clock.scenarioSeconds(now_ns);
    const auto isDue = [&](const Event& event) {
        return event.frame ? *event.frame <= instance.conditions.frames_waited : event.t_s <= now_s;
    };
    if (std::none_of(events.begin(), events.end(), isDue)) return;
    std::vector<Event> due, later;  // due events in order of time
    for (Event& event : events) {
        if (!isDue(event)) {
            later.push_back(std::move(event));
            continue;
        }
        const auto after = std::upper_bound(due.begin(), due.end(), event.t_s,
                                            [](double t_s, const Event& each) { return t_s < each.t_s; });
        due.insert(after, std::move(event));
    }
    events = std::move(later);
    for (const Event& event : due)
        std::visit([&](const auto& action) { apply(instance, now_ns, action); }, event.action);
}

void applyInitialRefusals(Instance& instance, std::int64_t now_ns) {
    std::erase_if(instance.scenario.events, [&](const Event& event) {
        const auto* refusal = std::get_if<Refusal>(&event.action);
        if (refusal == nullptr || event.frame || event.t_s > 0) return false;
        apply(instance, now_ns, *refusal);
        return true;
    });
}

FrameOverride popFrameOverride(Instance& instance) {
    FrameOverride taken;
    auto& frame_overrides = instance.conditions.frame_overrides;
    for (FrameOverrides& each : frame_overrides) {
        --each.count;
        taken.late_refreshes += each.frame_override.late_refreshes;
        taken.should_render = taken.should_render && each.frame_override.should_render;
        taken.discarded = taken.discarded || each.frame_override.discarded;
        taken.dropped = taken.dropped || each.frame_override.dropped;
    }
    std::erase_if(frame_overrides, [](const FrameOverrides& each) { return each.count == 0; });
    return taken;
}

void announcePresence(Session& session) {
    Instance& instance = session.instance;
    if (!instance.extensions.contains(XR_EXT_USER_PRESENCE_EXTENSION_NAME)) return;
    const auto handle = toHandle<XrSession>(session);
    instance.events.push(XrEventDataUserPresenceChangedEXT{
        XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT, nullptr, handle, instance.conditions.user_present});
}

void changeRefreshRate(Instance& instance, double hz) {
    const double before_hz = instance.scenario.refresh_hz;
    if (before_hz == hz) return;
    instance.scenario.refresh_hz = hz;
    if (!instance.extensions.contains(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME)) return;
    instance.events.push(
        XrEventDataDisplayRefreshRateChangedFB{XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB, nullptr,
                                               static_cast<float>(before_hz), static_cast<float>(hz)});
}

}  // namespace xrmock
