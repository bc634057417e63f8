// Keys of the scenario: what holds or passes between them, as a function of scenario time.
#pragma once

#include <string>
#include <vector>

#include "pose.h"

namespace xrmock {

struct PoseKey {
    double t_s;
    Pose stage_from_device;
};
struct ValueKey {
    double t_s;
    double value;
};
struct TextKey {
    double t_s;
    std::string text;
};

// Before the first key its pose holds, after the last one the last. Never without keys.
Pose poseAt(const std::vector<PoseKey>& keys, double t_s);
// Holds from key to key; zero before the first.
double valueAt(const std::vector<ValueKey>& keys, double t_s);
// When the value became what it is at this time; negative if it has been zero for ever.
double changeBefore(const std::vector<ValueKey>& keys, double t_s);
// Holds from key to key; empty before the first.
const std::string& textAt(const std::vector<TextKey>& keys, double t_s);

// What comes from a time on gives way to new keys; what was until then is kept.
template <class Key>
void forgetFrom(std::vector<Key>& keys, double t_s) {
    std::erase_if(keys, [&](const Key& key) { return key.t_s >= t_s; });
}
// The same for poses, which would otherwise pass from the last kept one to the first new one.
void holdFrom(std::vector<PoseKey>& keys, double t_s);

}  // namespace xrmock
