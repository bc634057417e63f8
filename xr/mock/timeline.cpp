#include "timeline.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace xrmock {

namespace {

constexpr std::string_view kCsvHeading = "t_s,x,y,z,qx,qy,qz,qw";

// False when it is no rotation.
bool normalise(std::array<double, 4>& q) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length >= 0.99 && length <= 1.01)) return false;
    for (double& component : q)
        component /= length;
    return true;
}

PoseKey parseCsvLine(const Field& field, std::string_view line, const std::string& place) {
    std::array<double, 8> numbers;
    const char* at = line.data();
    const char* const end = at + line.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (i > 0 && (at == end || *at++ != ',')) field.fail(place + "8 numbers with commas expected");
        const auto [next, error] = std::from_chars(at, end, numbers[i]);
        if (error != std::errc() || !(std::abs(numbers[i]) <= kMaxNumber)) {
            field.fail(place + "8 numbers with commas expected");
        }
        at = next;
    }
    if (at != end) field.fail(place + "8 numbers with commas expected");
    std::array<double, 4> orientation{numbers[4], numbers[5], numbers[6], numbers[7]};
    if (!normalise(orientation)) field.fail(place + "a unit quaternion x y z w expected");
    return {numbers[0], {orientation, {numbers[1], numbers[2], numbers[3]}}};
}

std::vector<PoseKey> parseCsv(const Field& field, const Reading& reading) {
    const std::string name = field.text();
    const std::string text =
        readTextFile(name.starts_with('/') || reading.folder.empty() ? name : reading.folder + "/" + name);
    std::vector<PoseKey> keys;
    std::string_view rest = text;
    for (std::size_t line_number = 1; !rest.empty(); ++line_number) {
        std::string_view line = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(line.size() + 1, rest.size()));
        if (line.ends_with('\r')) line.remove_suffix(1);
        const std::string place = name + " line " + std::to_string(line_number) + ": ";
        if (line_number == 1) {
            if (line != kCsvHeading) field.fail(place + std::string(kCsvHeading) + " expected");
            continue;
        }
        PoseKey key = parseCsvLine(field, line, place);
        key.t_s += reading.now_s;
        if (key.t_s < 0 || (!keys.empty() && key.t_s <= keys.back().t_s)) {
            field.fail(place + "later than the line before expected");
        }
        if (keys.size() == kMaxElements) field.fail(place + "too many lines");
        keys.push_back(key);
    }
    if (keys.empty()) field.fail("at least one line below the heading expected");
    return keys;
}

}  // namespace

double keyTime(const Field& key, double previous_s, const Reading& reading) {
    if (reading.is_message && !key.has("t_s")) {
        if (previous_s >= reading.now_s) key.required("t_s");
        return reading.now_s;
    }
    const double t_s = reading.now_s + key.required("t_s").number(0, kMaxNumber);
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

std::vector<PoseKey> parsePoses(const Field& field, const Reading& reading) {
    if (field.value.is_object()) {
        field.objectOf({"csv"});
        return parseCsv(field.required("csv"), reading);
    }
    std::vector<PoseKey> keys;
    double t_s = -1;
    for (std::size_t i = 0; i < field.arraySize(); ++i) {
        const Field key = field.at(i);
        key.objectOf({"t_s", "position", "orientation"});
        t_s = keyTime(key, t_s, reading);
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
    for (const TargetKey& key : keys) {
        if (key.t_s <= t_s) target = key.target;
    }
    return target;
}

void splice(std::vector<PoseKey>& keys, std::vector<PoseKey> read, const Reading& reading) {
    if (!reading.is_message) keys.clear();
    holdFrom(keys, reading.now_s);
    forgetFrom(keys, read.front().t_s);  // the held one, when the first is for now
    keys.insert(keys.end(), read.begin(), read.end());
}

}  // namespace xrmock
