// Reading timelines: what a scenario says of the run and what a control message says from now on.
#pragma once

#include <string>
#include <vector>

#include "csv.h"
#include "json_fields.h"
#include "keys.h"

namespace xrmock {

// Where a session is heading; ordered, so that less means less of a session.
enum class SessionTarget { exiting, stopped, synchronized, visible, focused };

struct TargetKey {
    double t_s;
    SessionTarget target;
};

// How a document is read: the times of a scenario are those of the run, those of a control message count from
// now. Files that it names are looked for in the folder.
struct Reading {
    bool is_message = false;
    double now_s = 0;
    std::string folder;
};

// The t_s of a key: greater than that of the key before. 0 where a control message leaves it out.
double keyTime(const Field& key, double previous_s, const Reading& reading);
// A list of { "t_s", "position", "orientation" }, or { "csv": FILE } with the lines t_s,x,y,z,qx,qy,qz,qw
// below that heading. Throws FieldError.
std::vector<PoseKey> parsePoses(const Field& field, const Reading& reading);
Pose parsePose(const Field& field);                          // { "position", "orientation" }
Pose poseOf(const double* numbers, const CsvFailure& fail);  // x y z, then the quaternion x y z w
double parseButton(const Field& field);

SessionTarget targetAt(const std::vector<TargetKey>& keys, double t_s);

// Puts newly read keys in the place of a timeline, or, those of a message, in the place of what was to come.
template <class Key>
void splice(std::vector<Key>& keys, std::vector<Key> read, const Reading& reading) {
    if (!reading.is_message) keys.clear();
    if (read.empty()) return;
    forgetFrom(keys, read.front().t_s);
    keys.insert(keys.end(), read.begin(), read.end());
}
// Poses move on from where they are now.
void splice(std::vector<PoseKey>& keys, std::vector<PoseKey> read, const Reading& reading);

}  // namespace xrmock
