#include "scenario/timeline.h"

#include <algorithm>
#include <cmath>

namespace xrmock {

namespace {

// Normalises the quaternion. Returns false if it is no rotation.
bool normalise(std::array<double, 4>& q) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length >= 0.99 && length <= 1.01)) return false;
    for (double& component : q)
        component /= length;
    return true;
}

}  // namespace

double keyTime(const Field& key, double previous_s, const ReadContext& context) {
    if (context.is_message && !key.has("t_s")) {
        if (previous_s >= context.now_s) key.required("t_s");
        return context.now_s;
    }
    const double t_s = context.now_s + key.required("t_s").number(0, kMaxNumber);
    if (t_s <= previous_s) key.at("t_s").fail("later than the key before expected");
    return t_s;
}

Pose parsePose(const Field& field) {
    Pose pose;
    pose.position = field.required("position").numbers<3>(-kMaxNumber, kMaxNumber);
    if (!field.has("orientation")) return pose;
    pose.orientation = field.at("orientation").numbers<4>(-kMaxNumber, kMaxNumber);
    if (!normalise(pose.orientation)) field.at("orientation").fail("a unit quaternion x y z w expected");
    return pose;
}

Pose makePose(const double* numbers, const CsvFailure& fail) {
    Pose pose{{numbers[3], numbers[4], numbers[5], numbers[6]}, {numbers[0], numbers[1], numbers[2]}};
    if (!normalise(pose.orientation)) fail("a unit quaternion x y z w expected");
    return pose;
}

std::vector<PoseKey> parsePoses(const Field& field, const ReadContext& context) {
    std::vector<PoseKey> keys;
    if (field.value.is_object()) {
        field.requireObject({"csv"});
        readCsv(field.required("csv"), context.folder, "t_s,x,y,z,qx,qy,qz,qw",
                [&](const std::vector<double>& numbers, const CsvFailure& fail) {
                    keys.push_back({context.now_s + numbers[0], makePose(&numbers[1], fail)});
                });
        return keys;
    }
    double t_s = -1;
    for (std::size_t i = 0; i < field.arraySize(); ++i) {
        const Field key = field.at(i);
        key.requireObject({"t_s", "position", "orientation"});
        t_s = keyTime(key, t_s, context);
        keys.push_back({t_s, parsePose(key)});
    }
    if (keys.empty()) field.fail("at least one key expected");
    return keys;
}

double parseButton(const Field& field) {
    if (field.value.is_boolean()) return field.boolean() ? 1 : 0;
    return field.number(-1, 1);
}

SessionTarget targetAt(const std::vector<TargetKey>& keys, double t_s) {
    SessionTarget target = keys.front().target;
    for (const TargetKey& key : keys)
        if (key.t_s <= t_s) target = key.target;
    return target;
}

void splice(std::vector<PoseKey>& keys, std::vector<PoseKey> read, const ReadContext& context) {
    constexpr double kKept_s = 10;  // older keys are removed, because a client may send poses for hours
    if (!context.is_message) keys.clear();
    if (keys.size() > 1 && keys[1].t_s < context.now_s - kKept_s) {
        const auto kept = std::find_if(keys.begin() + 1, keys.end(), [&](const PoseKey& key) {
            return key.t_s >= context.now_s - kKept_s;
        });
        keys.erase(keys.begin(), kept - 1);
    }
    freezeFrom(keys, context.now_s);
    eraseFrom(keys, read.front().t_s);  // removes the key added by freezeFrom() if the first new key is now
    keys.insert(keys.end(), read.begin(), read.end());
}

}  // namespace xrmock
