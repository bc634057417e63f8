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
void forEachKey(const Field& field, const ReadContext& context, Read read) {
    double t_s = -1;
    if (field.arraySize() == 0) field.fail("at least one key expected");
    for (std::size_t i = 0; i < field.arraySize(); ++i) {
        const Field key = field.at(i);
        key.requireObject();
        t_s = keyTime(key, t_s, context);
        read(key, t_s);
    }
}

std::string readProfile(const Field& field, User user) {
    if (field.value.is_null()) return {};
    const std::string path = field.text();
    const Profile* profile = findProfile(path);
    if (profile == nullptr) field.fail("not an interaction profile");
    if (findComponents(*profile, user).empty()) field.fail("not a profile of this user path");
    return path;
}

// Reads a profile name (null: nothing is connected), or keys with profile names.
std::vector<TextKey> readProfiles(const Field& field, const ReadContext& context, User user) {
    if (!field.value.is_array()) return {{context.now_s, readProfile(field, user)}};
    std::vector<TextKey> keys;
    forEachKey(field, context, [&](const Field& key, double t_s) {
        key.requireObject({"t_s", "profile"});
        keys.push_back({t_s, readProfile(key.required("profile"), user)});
    });
    return keys;
}

void readValues(const Field& field, const ReadContext& context, User user, Device& device) {
    forEachKey(field, context, [&](const Field& key, double t_s) {
        for (const auto& [name, unused] : key.value.items()) {
            if (name == "t_s") continue;
            const std::string component = "input/" + name;
            if (!isValueOfAnyProfile(user, component)) key.at(name).fail("unknown component");
            auto& keys = device.values[component];
            eraseFrom(keys, t_s);
            keys.push_back({t_s, parseButton(key.at(name))});
        }
    });
}

void readDevice(const Field& field, const ReadContext& context, User user, Device& device) {
    if (isHand(user)) {
        field.requireObject({"profile", "poses", "grip_from_aim", "values"});
    } else {
        field.requireObject({"profile", "values"});
        if (!context.is_message) field.required("profile");
    }
    if (field.has("profile"))
        splice(device.profiles, readProfiles(field.at("profile"), context, user), context);
    if (field.has("poses")) splice(device.grips, parsePoses(field.at("poses"), context), context);
    if (field.has("grip_from_aim")) {
        field.at("grip_from_aim").requireObject({"position", "orientation"});
        device.grip_from_aim = parsePose(field.at("grip_from_aim"));
    }
    if (field.has("values")) readValues(field.at("values"), context, user, device);
}

std::vector<CurlKey> readCurls(const Field& field, const ReadContext& context) {
    std::vector<CurlKey> keys;
    Curls curls{};
    forEachKey(field, context, [&](const Field& key, double t_s) {
        key.requireObject({"t_s", "thumb", "index", "middle", "ring", "little"});
        for (std::size_t finger = 0; finger < kFingerCount; ++finger)
            if (key.has(kFingerKeys[finger])) curls[finger] = key.at(kFingerKeys[finger]).number(0, 1);
        keys.push_back({t_s, curls});
    });
    return keys;
}

Joint makeJoint(const double* numbers, const CsvFailure& fail) {
    if (!(numbers[7] > 0)) fail("a radius greater than zero expected");
    return {makePose(numbers, fail), numbers[7]};
}

// "t_s,0x,0y,0z,0qx,0qy,0qz,0qw,0r,1x,...", numbered by XrHandJointEXT.
std::string jointsHeading() {
    std::string heading = "t_s";
    for (int joint = 0; joint < XR_HAND_JOINT_COUNT_EXT; ++joint)
        for (const char* column : {"x", "y", "z", "qx", "qy", "qz", "qw", "r"})
            heading.append(",").append(std::to_string(joint)).append(column);
    return heading;
}

std::vector<JointsKey> readJoints(const Field& field, const ReadContext& context) {
    std::vector<JointsKey> keys;
    if (field.value.is_object()) {
        field.requireObject({"csv"});
        readCsv(field.required("csv"), context.folder, jointsHeading(),
                [&](const std::vector<double>& numbers, const CsvFailure& fail) {
                    JointsKey& key = keys.emplace_back(JointsKey{context.now_s + numbers[0], {}});
                    for (std::size_t i = 0; i < key.joints.size(); ++i)
                        key.joints[i] = makeJoint(&numbers[1 + i * 8], fail);
                });
        return keys;
    }
    forEachKey(field, context, [&](const Field& key, double t_s) {
        key.requireObject({"t_s", "joints"});
        const Field joints = key.required("joints");
        if (joints.arraySize() != XR_HAND_JOINT_COUNT_EXT) joints.fail("26 joints expected");
        JointsKey& read = keys.emplace_back(JointsKey{t_s, {}});
        for (std::size_t i = 0; i < read.joints.size(); ++i) {
            const Field joint = joints.at(i);
            const auto numbers = joint.numbers<8>(-kMaxNumber, kMaxNumber);
            read.joints[i] = makeJoint(numbers.data(), [&](const char* reason) { joint.fail(reason); });
        }
    });
    return keys;
}

// Like splice() for poses: interpolated motion continues from its current value.
template <class Key>
void spliceMoving(std::vector<Key>& keys, std::vector<Key> read, const ReadContext& context,
                  Key (*keyAt)(const std::vector<Key>&, double)) {
    if (context.is_message && !keys.empty()) {
        const Key frozen = keyAt(keys, context.now_s);
        eraseFrom(keys, context.now_s);
        keys.push_back(frozen);
    }
    splice(keys, std::move(read), context);
}

void readHand(const Field& field, const ReadContext& context, TrackedHand& hand) {
    field.requireObject({"poses", "joints", "curls", "tracked"});
    if (field.has("poses")) splice(hand.palms, parsePoses(field.at("poses"), context), context);
    if (field.has("joints")) {
        spliceMoving<JointsKey>(hand.joints, readJoints(field.at("joints"), context), context,
                                [](const std::vector<JointsKey>& keys, double t_s) {
                                    return JointsKey{t_s, jointsAt(keys, t_s)};
                                });
    }
    if (field.has("curls")) {
        spliceMoving<CurlKey>(
            hand.curls, readCurls(field.at("curls"), context), context,
            [](const std::vector<CurlKey>& keys, double t_s) { return CurlKey{t_s, curlsAt(keys, t_s)}; });
    }
    if (!field.has("tracked")) return;
    std::vector<ValueKey> tracked;
    forEachKey(field.at("tracked"), context, [&](const Field& key, double t_s) {
        key.requireObject({"t_s", "tracked"});
        tracked.push_back({t_s, key.required("tracked").boolean() ? 1.0 : 0.0});
    });
    splice(hand.tracked, std::move(tracked), context);
}

}  // namespace

void readControllers(const Field& field, const ReadContext& context, Scenario& scenario) {
    field.requireObject({"profile", "left", "right", "head", "gamepad"});
    if (!context.is_message) {
        for (std::size_t i = 0; i < std::size(kDeviceNames); ++i)
            if (!field.has(kDeviceNames[i]) || !isHand(static_cast<User>(i)))
                scenario.devices[i].profiles = {};
    }
    if (field.has("profile")) {
        for (std::size_t hand = 0; hand < kHandCount; ++hand)
            if (context.is_message) eraseFrom(scenario.devices[hand].profiles, context.now_s);
        switchProfile(scenario.devices, readProfile(field.at("profile"), User::left_hand), context.now_s);
    }
    for (std::size_t i = 0; i < std::size(kDeviceNames); ++i) {
        if (!field.has(kDeviceNames[i])) continue;
        readDevice(field.at(kDeviceNames[i]), context, static_cast<User>(i), scenario.devices[i]);
    }
}

void readHands(const Field& field, const ReadContext& context, Scenario& scenario) {
    field.requireObject({"supported", "left", "right"});
    if (field.has("supported")) scenario.hand_tracking = field.at("supported").boolean();
    for (std::size_t hand = 0; hand < kHandCount; ++hand)
        if (field.has(kDeviceNames[hand]))
            readHand(field.at(kDeviceNames[hand]), context, scenario.hands[hand]);
}

}  // namespace xrmock
