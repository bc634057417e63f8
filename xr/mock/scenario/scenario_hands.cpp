#include "scenario/scenario_hands.h"

#include <string>
#include <utility>

#include "scenario/profiles.h"

namespace xrmock {

namespace {

constexpr const char* kDeviceNames[] = {"left", "right", "head", "gamepad"};  // by User
constexpr const char* kFingerKeys[kFingerCount] = {"thumb", "index", "middle", "ring", "little"};

// Calls read(key, t_s) for each key of the list.
template <class Read>
void eachKey(const Field& field, const Reading& reading, Read read) {
    double t_s = -1;
    if (field.arraySize() == 0) field.fail("at least one key expected");
    for (std::size_t i = 0; i < field.arraySize(); ++i) {
        const Field key = field.at(i);
        key.object();
        t_s = keyTime(key, t_s, reading);
        read(key, t_s);
    }
}

std::string readProfile(const Field& field, User user) {
    if (field.value.is_null()) return {};
    const std::string path = field.text();
    const Profile* profile = findProfile(path);
    if (profile == nullptr) field.fail("not an interaction profile");
    if (componentsOf(*profile, user).empty()) field.fail("not a profile of this user path");
    return path;
}

// A profile name (null: nothing connected), or keys with names.
std::vector<TextKey> readProfiles(const Field& field, const Reading& reading, User user) {
    if (!field.value.is_array()) return {{reading.now_s, readProfile(field, user)}};
    std::vector<TextKey> keys;
    eachKey(field, reading, [&](const Field& key, double t_s) {
        key.objectOf({"t_s", "profile"});
        keys.push_back({t_s, readProfile(key.required("profile"), user)});
    });
    return keys;
}

void readValues(const Field& field, const Reading& reading, User user, Device& device) {
    eachKey(field, reading, [&](const Field& key, double t_s) {
        for (const auto& [name, unused] : key.value.items()) {
            if (name == "t_s") continue;
            const std::string component = "input/" + name;
            if (!isValueOfAnyProfile(user, component)) key.at(name).fail("unknown component");
            auto& keys = device.values[component];
            forgetFrom(keys, t_s);
            keys.push_back({t_s, parseButton(key.at(name))});
        }
    });
}

void readDevice(const Field& field, const Reading& reading, User user, Device& device) {
    if (isHand(user)) {
        field.objectOf({"profile", "poses", "grip_from_aim", "values"});
    } else {
        field.objectOf({"profile", "values"});
        if (!reading.is_message) field.required("profile");
    }
    if (field.has("profile")) {
        splice(device.profiles, readProfiles(field.at("profile"), reading, user), reading);
    }
    if (field.has("poses")) splice(device.grips, parsePoses(field.at("poses"), reading), reading);
    if (field.has("grip_from_aim")) {
        field.at("grip_from_aim").objectOf({"position", "orientation"});
        device.grip_from_aim = parsePose(field.at("grip_from_aim"));
    }
    if (field.has("values")) readValues(field.at("values"), reading, user, device);
}

std::vector<CurlKey> readCurls(const Field& field, const Reading& reading) {
    std::vector<CurlKey> keys;
    Curls curls{};
    eachKey(field, reading, [&](const Field& key, double t_s) {
        key.objectOf({"t_s", "thumb", "index", "middle", "ring", "little"});
        for (std::size_t finger = 0; finger < kFingerCount; ++finger) {
            if (key.has(kFingerKeys[finger])) curls[finger] = key.at(kFingerKeys[finger]).number(0, 1);
        }
        keys.push_back({t_s, curls});
    });
    return keys;
}

Joint jointOf(const double* numbers, const CsvFailure& fail) {
    if (!(numbers[7] > 0)) fail("a radius greater than zero expected");
    return {poseOf(numbers, fail), numbers[7]};
}

// "t_s,0x,0y,0z,0qx,0qy,0qz,0qw,0r,1x,...", numbered by XrHandJointEXT.
std::string jointsHeading() {
    std::string heading = "t_s";
    for (int joint = 0; joint < XR_HAND_JOINT_COUNT_EXT; ++joint) {
        for (const char* column : {"x", "y", "z", "qx", "qy", "qz", "qw", "r"})
            heading.append(",").append(std::to_string(joint)).append(column);
    }
    return heading;
}

std::vector<JointsKey> readJoints(const Field& field, const Reading& reading) {
    std::vector<JointsKey> keys;
    if (field.value.is_object()) {
        field.objectOf({"csv"});
        readCsv(field.required("csv"), reading.folder, jointsHeading(),
                [&](const std::vector<double>& numbers, const CsvFailure& fail) {
                    JointsKey& key = keys.emplace_back(JointsKey{reading.now_s + numbers[0], {}});
                    for (std::size_t i = 0; i < key.joints.size(); ++i)
                        key.joints[i] = jointOf(&numbers[1 + i * 8], fail);
                });
        return keys;
    }
    eachKey(field, reading, [&](const Field& key, double t_s) {
        key.objectOf({"t_s", "joints"});
        const Field joints = key.required("joints");
        if (joints.arraySize() != XR_HAND_JOINT_COUNT_EXT) joints.fail("26 joints expected");
        JointsKey& read = keys.emplace_back(JointsKey{t_s, {}});
        for (std::size_t i = 0; i < read.joints.size(); ++i) {
            const Field joint = joints.at(i);
            const auto numbers = joint.numbers<8>(-kMaxNumber, kMaxNumber);
            read.joints[i] = jointOf(numbers.data(), [&](const char* reason) { joint.fail(reason); });
        }
    });
    return keys;
}

// Like splice() for poses: interpolated motion continues from its current value.
template <class Key>
void spliceMoving(std::vector<Key>& keys, std::vector<Key> read, const Reading& reading,
                  Key (*keyAt)(const std::vector<Key>&, double)) {
    if (reading.is_message && !keys.empty()) {
        const Key held = keyAt(keys, reading.now_s);
        forgetFrom(keys, reading.now_s);
        keys.push_back(held);
    }
    splice(keys, std::move(read), reading);
}

void readHand(const Field& field, const Reading& reading, TrackedHand& hand) {
    field.objectOf({"poses", "joints", "curls", "tracked"});
    if (field.has("poses")) splice(hand.palms, parsePoses(field.at("poses"), reading), reading);
    if (field.has("joints")) {
        spliceMoving<JointsKey>(hand.joints, readJoints(field.at("joints"), reading), reading,
                                [](const std::vector<JointsKey>& keys, double t_s) {
                                    return JointsKey{t_s, jointsAt(keys, t_s)};
                                });
    }
    if (field.has("curls")) {
        spliceMoving<CurlKey>(
            hand.curls, readCurls(field.at("curls"), reading), reading,
            [](const std::vector<CurlKey>& keys, double t_s) { return CurlKey{t_s, curlsAt(keys, t_s)}; });
    }
    if (!field.has("tracked")) return;
    std::vector<ValueKey> tracked;
    eachKey(field.at("tracked"), reading, [&](const Field& key, double t_s) {
        key.objectOf({"t_s", "tracked"});
        tracked.push_back({t_s, key.required("tracked").boolean() ? 1.0 : 0.0});
    });
    splice(hand.tracked, std::move(tracked), reading);
}

}  // namespace

void readControllers(const Field& field, const Reading& reading, Scenario& scenario) {
    field.objectOf({"profile", "left", "right", "head", "gamepad"});
    if (!reading.is_message) {
        for (std::size_t i = 0; i < std::size(kDeviceNames); ++i) {
            if (!field.has(kDeviceNames[i]) || !isHand(static_cast<User>(i)))
                scenario.devices[i].profiles = {};
        }
    }
    if (field.has("profile")) {
        for (std::size_t hand = 0; hand < kHandCount; ++hand)
            if (reading.is_message) forgetFrom(scenario.devices[hand].profiles, reading.now_s);
        takeUp(scenario.devices, readProfile(field.at("profile"), User::left_hand), reading.now_s);
    }
    for (std::size_t i = 0; i < std::size(kDeviceNames); ++i) {
        if (!field.has(kDeviceNames[i])) continue;
        readDevice(field.at(kDeviceNames[i]), reading, static_cast<User>(i), scenario.devices[i]);
    }
}

void readHands(const Field& field, const Reading& reading, Scenario& scenario) {
    field.objectOf({"supported", "left", "right"});
    if (field.has("supported")) scenario.hand_tracking = field.at("supported").boolean();
    for (std::size_t hand = 0; hand < kHandCount; ++hand) {
        if (field.has(kDeviceNames[hand]))
            readHand(field.at(kDeviceNames[hand]), reading, scenario.hands[hand]);
    }
}

}  // namespace xrmock
