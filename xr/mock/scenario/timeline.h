// Reads timelines. Those of a scenario cover the whole run; those of a control message start now.
#pragma once

#include <string>
#include <vector>

#include "scenario/csv.h"
#include "scenario/json_fields.h"
#include "scenario/keys.h"

namespace xrmock {

// Target state of a session, in ascending order.
enum class SessionTarget { exiting, stopped, synchronized, visible, focused };

struct TargetKey {
    double t_s;
    SessionTarget target;
};

// Context in which a document is read. Times of a scenario are absolute; times of a control message count
// from now. File names are resolved against `folder`.
struct ReadContext {
    bool is_message = false;
    double now_s = 0;
    std::string folder;
};

// Reads the t_s of a key, which must be greater than the previous one. A control message may omit the t_s of
// its first key, which is then the current time.
double keyTime(const Field& key, double previous_s, const ReadContext& context);
// Reads a list of { "t_s", "position", "orientation" }, or { "csv": FILE } with the heading
// t_s,x,y,z,qx,qy,qz,qw and one line per key. Throws FieldError.
std::vector<PoseKey> parsePoses(const Field& field, const ReadContext& context);
Pose parsePose(const Field& field);                            // { "position", "orientation" }
Pose makePose(const double* numbers, const CsvFailure& fail);  // x y z, then the quaternion x y z w
double parseButton(const Field& field);

SessionTarget targetAt(const std::vector<TargetKey>& keys, double t_s);

// Replaces a timeline by newly read keys. The keys of a control message replace only the existing keys from
// their first time on.
template <class Key>
void splice(std::vector<Key>& keys, std::vector<Key> read, const ReadContext& context) {
    if (!context.is_message) keys.clear();
    if (read.empty()) return;
    eraseFrom(keys, read.front().t_s);
    keys.insert(keys.end(), read.begin(), read.end());
}
// The same for poses. With a control message, motion continues from the current pose.
void splice(std::vector<PoseKey>& keys, std::vector<PoseKey> read, const ReadContext& context);

}  // namespace xrmock
