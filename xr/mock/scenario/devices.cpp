#include "scenario/devices.h"

#include <algorithm>

namespace xrmock {

namespace {

constexpr std::string_view kUserPaths[kUserCount] = {"/user/hand/left", "/user/hand/right", "/user/head",
                                                     "/user/gamepad", "/user/treadmill"};

// The keys before and after a time, and the position of the time between them, 0 to 1.
template <class Key>
struct Span {
    const Key& from;
    const Key& to;
    double fraction;
};
template <class Key>
Span<Key> spanAt(const std::vector<Key>& keys, double t_s) {
    const auto next = std::upper_bound(keys.begin(), keys.end(), t_s,
                                       [](double time_s, const Key& key) { return time_s < key.t_s; });
    const Key& from = next == keys.begin() ? *next : *(next - 1);
    const Key& to = next == keys.end() ? from : *next;
    return {from, to, &from == &to ? 0 : (t_s - from.t_s) / (to.t_s - from.t_s)};
}

}  // namespace

std::string_view userPath(User user) {
    return kUserPaths[static_cast<std::size_t>(user)];
}

std::optional<User> findUser(std::string_view path) {
    const auto found = std::find(std::begin(kUserPaths), std::end(kUserPaths), path);
    if (found == std::end(kUserPaths)) return std::nullopt;
    return static_cast<User>(found - std::begin(kUserPaths));
}

std::array<Device, kUserCount> restingDevices() {
    std::array<Device, kUserCount> devices;
    for (std::size_t hand = 0; hand < kHandCount; ++hand) {
        devices[hand].profiles = {{0, "/interaction_profiles/khr/simple_controller"}};
        devices[hand].grips = {{0, {{0, 0, 0, 1}, {hand == 0 ? -0.2 : 0.2, 1.3, -0.4}}}};
    }
    return devices;
}

void switchProfile(std::array<Device, kUserCount>& devices, const std::string& profile, double from_s) {
    for (std::size_t hand = 0; hand < kHandCount; ++hand) {
        auto& profiles = devices[hand].profiles;
        if (textAt(profiles, from_s).empty()) continue;
        const auto later = std::find_if(profiles.begin(), profiles.end(),
                                        [&](const TextKey& key) { return key.t_s > from_s; });
        profiles.insert(later, {from_s, profile});
    }
}

Curls curlsAt(const std::vector<CurlKey>& keys, double t_s) {
    if (keys.empty()) return {};
    const auto span = spanAt(keys, t_s);
    Curls curls;
    for (std::size_t i = 0; i < kFingerCount; ++i)
        curls[i] = span.from.curls[i] + (span.to.curls[i] - span.from.curls[i]) * span.fraction;
    return curls;
}

Joints jointsAt(const std::vector<JointsKey>& keys, double t_s) {
    const auto span = spanAt(keys, t_s);
    Joints joints;
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const Joint& from = span.from.joints[i];
        const Joint& to = span.to.joints[i];
        joints[i] = {interpolate(from.stage_from_joint, to.stage_from_joint, span.fraction),
                     from.radius_m + (to.radius_m - from.radius_m) * span.fraction};
    }
    return joints;
}

}  // namespace xrmock
