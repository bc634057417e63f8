// Keys of the scenario, evaluated as functions of scenario time.
#pragma once

#include <string>
#include <vector>

#include "scenario/pose.h"

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

// Interpolates between keys; constant before the first and after the last. `keys` must not be empty.
Pose poseAt(const std::vector<PoseKey>& keys, double t_s);
// Value of the last key up to `t_s`; 0 before the first key.
double valueAt(const std::vector<ValueKey>& keys, double t_s);
// Time of the last change up to `t_s`; negative if the value has always been 0.
double changeBefore(const std::vector<ValueKey>& keys, double t_s);
// Text of the last key up to `t_s`; empty before the first key.
const std::string& textAt(const std::vector<TextKey>& keys, double t_s);

// Removes the keys from `t_s` on.
template <class Key>
void eraseFrom(std::vector<Key>& keys, double t_s) {
    std::erase_if(keys, [&](const Key& key) { return key.t_s >= t_s; });
}
// The same for poses. Adds a key with the current pose at `t_s`; otherwise the pose would move from the last
// kept key to the first new one.
void freezeFrom(std::vector<PoseKey>& keys, double t_s);

}  // namespace xrmock
