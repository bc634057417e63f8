#include "scenario/keys.h"

#include <algorithm>

namespace xrmock {

namespace {

// The first key later than `t_s`.
template <class Key>
auto keyAfter(const std::vector<Key>& keys, double t_s) {
    return std::upper_bound(keys.begin(), keys.end(), t_s,
                            [](double time_s, const Key& key) { return time_s < key.t_s; });
}

}  // namespace

Pose poseAt(const std::vector<PoseKey>& keys, double t_s) {
    const auto next = keyAfter(keys, t_s);
    if (next == keys.begin()) return next->stage_from_device;
    const auto previous = next - 1;
    if (next == keys.end()) return previous->stage_from_device;
    return interpolate(previous->stage_from_device, next->stage_from_device,
                       (t_s - previous->t_s) / (next->t_s - previous->t_s));
}

double valueAt(const std::vector<ValueKey>& keys, double t_s) {
    const auto next = keyAfter(keys, t_s);
    return next == keys.begin() ? 0.0 : (next - 1)->value;
}

double changeBefore(const std::vector<ValueKey>& keys, double t_s) {
    for (auto key = keyAfter(keys, t_s); key != keys.begin();) {
        --key;
        if (key->value != (key == keys.begin() ? 0.0 : (key - 1)->value)) return key->t_s;
    }
    return -1;
}

const std::string& textAt(const std::vector<TextKey>& keys, double t_s) {
    static const std::string kNone;
    const auto next = keyAfter(keys, t_s);
    return next == keys.begin() ? kNone : (next - 1)->text;
}

void freezeFrom(std::vector<PoseKey>& keys, double t_s) {
    if (keys.empty()) return;
    const PoseKey frozen{t_s, poseAt(keys, t_s)};
    eraseFrom(keys, t_s);
    keys.push_back(frozen);
}

}  // namespace xrmock
