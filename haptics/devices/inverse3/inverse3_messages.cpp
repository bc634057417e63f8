#include "haptics/devices/inverse3/inverse3_messages.h"

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace stylet::haptics::inverse3 {

namespace {

using Json = nlohmann::json;

// Checks the nesting depth before anything is built.
bool isWithinMaxNesting(std::string_view text) {
    int depth = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\') ++i;
            quoted = c != '"';
        } else if (c == '"') {
            quoted = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxNesting) return false;
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
    return true;
}

// Returns null for a document that is not JSON within the limits.
Json parse(std::string_view text) {
    if (text.size() > kMaxMessageBytes || !isWithinMaxNesting(text)) return {};
    Json document = Json::parse(text, nullptr, false);
    return document.is_discarded() ? Json() : document;
}

const Json& member(const Json& object, const char* name) {
    static const Json kNone;
    const auto found = object.is_object() ? object.find(name) : object.end();
    return object.is_object() && found != object.end() ? *found : kNone;
}

bool readNumber(const Json& object, const char* name, double& value) {
    const Json& number = member(object, name);
    if (!number.is_number()) return false;
    value = number.get<double>();
    return std::isfinite(value);
}

bool readVector(const Json& object, Vec3& v) {
    return readNumber(object, "x", v.x) && readNumber(object, "y", v.y) && readNumber(object, "z", v.z);
}

bool readRotation(const Json& object, Quat& q) {
    if (!readNumber(object, "w", q.w) || !readNumber(object, "x", q.x) || !readNumber(object, "y", q.y) ||
        !readNumber(object, "z", q.z))
        return false;
    // The wire format is half floats, so the length is 1 only within about 1e-3.
    const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    if (!(length > 0.98 && length < 1.02)) return false;
    q = Quat(q.w / length, q.x / length, q.y / length, q.z / length);
    return true;
}

bool readFlag(const Json& object, const char* name, bool otherwise) {
    const Json& value = member(object, name);
    return value.is_boolean() ? value.get<bool>() : otherwise;
}

// True if the id can safely be sent back inside quotes.
bool isSafeId(const std::string& id) {
    for (const char c : id)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_' && c != '.' && c != ':')
            return false;
    return !id.empty() && id.size() <= 64;
}

std::uint32_t readButtons(const Json& state) {
    static constexpr std::array<std::array<const char*, 2>, 4> kNames{
        {{"a", "button_0"}, {"b", "button_1"}, {"c", "button_2"}, {"d", "button_3"}}};
    const Json& buttons = member(state, "buttons");
    std::uint32_t bits = readFlag(state, "button", false) ? 1u : 0u;
    for (std::size_t i = 0; i < kNames.size(); ++i)
        for (const char* name : kNames[i])
            if (readFlag(buttons, name, false)) bits |= 1u << i;
    return bits;
}

// Sets `device` to the list's first element, or to null if the list is missing or empty. Returns false if it
// is no list of devices.
bool findFirst(const Json& document, const char* list, const Json*& device) {
    const Json& devices = member(document, list);
    device = nullptr;
    if (devices.is_null()) return true;
    if (!devices.is_array() || devices.size() > kMaxDevices) return false;
    if (devices.empty()) return true;
    device = &devices.front();
    return device->is_object();
}

bool readCursor(const Json& device, Update& update, std::string& why) {
    const Json& id = member(device, "device_id");
    const Json& status = member(device, "status");
    why = "inverse3: device_id";
    if (!id.is_string() || !isSafeId(id.get_ref<const std::string&>())) return false;
    update.device_id = id.get<std::string>();
    why = "inverse3: state.cursor_position";
    if (!readVector(member(member(device, "state"), "cursor_position"), update.cursor_m)) return false;
    if (glm::length(update.cursor_m) > kFarthest_m) return false;
    update.calibrated = readFlag(status, "calibrated", true);
    update.ready = readFlag(status, "ready", true) && readFlag(status, "started", true);
    update.powered = readFlag(status, "power_supply", true);
    update.present = true;
    return true;
}

bool readGrip(const Json& document, Update& update, std::string& why) {
    for (const char* list : {"wireless_verse_grip", "verse_grip", "custom_verse_grip"}) {
        const Json* grip = nullptr;
        why = list;
        if (!findFirst(document, list, grip)) return false;
        if (grip == nullptr) continue;
        why += ": state.orientation";
        const Json& state = member(*grip, "state");
        if (!readRotation(member(state, "orientation"), update.haply_from_grip)) return false;
        update.buttons = readButtons(state);
        update.grip_present = true;
        return true;
    }
    return true;
}

void appendNumber(std::string& text, double value) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text.append(digits.data(), end);
}

}  // namespace

std::optional<Update> parseUpdate(std::string_view text, std::string& why) {
    const Json document = parse(text);
    if (!document.is_object()) {
        why = "not JSON within the limits";
        return {};
    }
    Update update;
    const Json* device = nullptr;
    why = "inverse3";
    if (!findFirst(document, "inverse3", device)) return {};
    if (device != nullptr && !readCursor(*device, update, why)) return {};
    if (!readGrip(document, update, why)) return {};
    update.has_session = !member(document, "session_id").is_null();
    why.clear();
    return update;
}

std::optional<Spelling> parseSpelling(std::string_view version_document) {
    const Json document = parse(version_document);
    const Json& data = member(document, "data");
    const Json& version = member(data.is_object() ? data : document, "project_version");
    if (!version.is_string()) return {};
    const std::string& text = version.get_ref<const std::string&>();
    int major = 0, minor = 0;
    const char* end = text.data() + text.size();
    const auto dot = std::from_chars(text.data(), end, major);
    if (dot.ec != std::errc() || dot.ptr == end || *dot.ptr != '.') return {};
    if (std::from_chars(dot.ptr + 1, end, minor).ec != std::errc()) return {};
    return major > 3 || (major == 3 && minor >= 5) ? Spelling::vector : Spelling::values;
}

void writeForce(std::string& text, std::string_view device_id, const Vec3& force_n, Spelling spelling) {
    text = R"({"inverse3":[{"device_id":")";
    text += device_id;
    text += R"(","commands":{"set_cursor_force":{")";
    text += spelling == Spelling::vector ? "vector" : "values";
    text += R"(":{"x":)";
    appendNumber(text, force_n.x);
    text += R"(,"y":)";
    appendNumber(text, 0.0 - force_n.z);  // never "-0"
    text += R"(,"z":)";
    appendNumber(text, force_n.y);
    text += "}}}}]}";
}

Pose stylusPose(const Update& update) noexcept {
    // A quarter turn about x maps the stylus' +z to the grip's -y; a quarter turn back maps Haply's z to the
    // device's y.
    constexpr double kHalf = 0.70710678118654752;
    const Quat grip_from_stylus(kHalf, kHalf, 0.0, 0.0), device_from_haply(kHalf, -kHalf, 0.0, 0.0);
    const Vec3& c = update.cursor_m;
    const Vec3 cursor_device_m(c.x, c.z, 0.0 - c.y);
    if (!update.grip_present) return {Quat(1.0, 0.0, 0.0, 0.0), cursor_device_m};
    return {device_from_haply * update.haply_from_grip * grip_from_stylus, cursor_device_m};
}

}  // namespace stylet::haptics::inverse3
