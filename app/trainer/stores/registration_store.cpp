#include "app/trainer/stores/registration_store.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/gtc/quaternion.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/records/disk_linux.h"
#include "base/hash.h"
#include "base/whole_file.h"
#include "patient/package/package.h"

namespace stylet::trainer {

using json = nlohmann::ordered_json;

namespace {

constexpr int kVersion = 1;
constexpr std::size_t kMostBytes = 64 * 1024;
constexpr std::size_t kMostText = 200;
constexpr double kFarthest_m = 100.0, kUnitTolerance = 1e-6;

// Strict reader of a JSON object. Fields are read by name; a field that was not read is refused.
class Reader {
  public:
    Reader(const json& object, const std::filesystem::path& file, std::string where)
        : object_(object), file_(file), where_(std::move(where)) {
        if (!object.is_object()) refuse("", "must be an object");
    }
    [[noreturn]] void refuse(const std::string& field, const std::string& reason) const {
        const std::string dot = where_.empty() || field.empty() ? "" : ".";
        const std::string name = where_ + dot + field;
        throw DataError(file_, name.empty() ? "json" : name, reason);
    }
    const json& at(const std::string& field) {
        const auto found = object_.find(field);
        if (found == object_.end()) refuse(field, "missing");
        taken_.push_back(field);
        return *found;
    }
    Reader object(const std::string& field) {
        return {at(field), file_, where_.empty() ? field : where_ + "." + field};
    }
    double number(const std::string& field, double least, double most) {
        return within(at(field), field, least, most);
    }
    int count(const std::string& field, int least, int most) {
        const json& value = at(field);
        if (!value.is_number_integer()) refuse(field, "must be a whole number");
        return int(within(value, field, least, most));
    }
    std::string text(const std::string& field) {
        const json& value = at(field);
        if (!value.is_string()) refuse(field, "must be text");
        const auto& text = value.get_ref<const std::string&>();
        if (text.size() > kMostText) refuse(field, "longer than 200 bytes");
        return text;
    }
    template <std::size_t N>
    std::array<double, N> numbers(const std::string& field, double most) {
        const json& value = at(field);
        if (!value.is_array() || value.size() != N)
            refuse(field, "must be " + std::to_string(N) + " numbers");
        std::array<double, N> result{};
        for (std::size_t i = 0; i < N; ++i)
            result[i] = within(value[i], field, -most, most);
        return result;
    }
    Vec3 point(const std::string& field, double most_m) {
        const auto v = numbers<3>(field, most_m);
        return {v[0], v[1], v[2]};
    }
    void nothingElse() const {
        for (const auto& [name, value] : object_.items())
            if (std::find(taken_.begin(), taken_.end(), name) == taken_.end()) refuse(name, "unknown");
    }

  private:
    double within(const json& value, const std::string& field, double least, double most) const {
        if (!value.is_number()) refuse(field, "must be a number");
        const double number = value.get<double>();
        if (!(number >= least && number <= most))
            refuse(field, "must be from " + json(least).dump() + " to " + json(most).dump());
        return number;
    }

    const json& object_;
    const std::filesystem::path& file_;
    std::string where_;
    std::vector<std::string> taken_;
};

json listOf(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Pose poseFrom(Reader pose) {
    const auto q = pose.numbers<4>("rotation_wxyz", 1.0 + kUnitTolerance);
    const Quat rotation(q[0], q[1], q[2], q[3]);
    if (std::fabs(glm::length(rotation) - 1.0) > kUnitTolerance)
        pose.refuse("rotation_wxyz", "must be a unit quaternion");
    const Pose result{rotation, pose.point("position_m", kFarthest_m)};
    pose.nothingElse();
    return result;
}

RegistrationKey keyFrom(Reader key) {
    RegistrationKey result{key.text("device"), key.text("unit"), key.text("space"), key.text("generation")};
    if (result.device.empty()) key.refuse("device", "must not be empty");
    if (result.space.empty()) key.refuse("space", "must not be empty");
    key.nothingElse();
    return result;
}

Registration registrationFrom(Reader r) {
    r.count("version", kVersion, kVersion);
    Registration result;
    result.key = keyFrom(r.object("key"));
    result.stage_from_device = poseFrom(r.object("stage_from_device"));
    result.scale = r.number("scale", 0.9, 1.1);
    result.stylus_from_tip_m = r.point("stylus_from_tip_m", 0.1);
    result.grip_from_tip_m = r.point("grip_from_tip_m", 1.0);
    result.latency_s = r.number("latency_s", -1.0, 1.0);
    result.fre_m = r.number("fre_m", 0.0, 1.0);
    result.tre_mean_m = r.number("tre_mean_m", 0.0, 1.0);
    result.tre_worst_m = r.number("tre_worst_m", 0.0, 1.0);
    result.centre_m = r.point("centre_m", kFarthest_m);
    result.points = r.count("points", 3, 1'000'000);
    result.rejected = r.count("rejected", 0, 1'000'000);
    result.date = r.text("date");
    r.nothingElse();
    return result;
}

// A name that is valid on any file system. The hash distinguishes names that were truncated or had
// characters replaced.
std::string fileName(const RegistrationKey& key) {
    constexpr std::size_t kMostName = 100;
    StateHash hash;
    std::string name;
    for (const std::string* part : {&key.device, &key.unit, &key.space, &key.generation}) {
        hash.add(std::string_view(*part));
        for (const char c : *part) {
            const bool kept = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
            name += kept ? c : '_';
        }
        name += '-';
    }
    std::array<char, 24> digits{};
    std::snprintf(digits.data(), digits.size(), "%08llx.json",
                  static_cast<unsigned long long>(hash.value() & 0xffffffffu));
    return name.substr(0, kMostName) + digits.data();
}

}  // namespace

Registration parseRegistration(std::string_view text, const std::filesystem::path& file) {
    json whole;
    try {
        whole = json::parse(text);
    } catch (const json::exception& e) {
        throw DataError(file, "json", e.what());
    }
    return registrationFrom({whole, file, ""});
}

Registration loadRegistration(const std::filesystem::path& file) {
    return parseRegistration(readWholeFile(file, kMostBytes), file);
}

std::string registrationText(const Registration& r) {
    const Quat& q = r.stage_from_device.rotation;
    const json whole{
        {"version", kVersion},
        {"key",
         {{"device", r.key.device},
          {"unit", r.key.unit},
          {"space", r.key.space},
          {"generation", r.key.generation}}},
        {"stage_from_device",
         {{"rotation_wxyz", {q.w, q.x, q.y, q.z}}, {"position_m", listOf(r.stage_from_device.position_m)}}},
        {"scale", r.scale},
        {"stylus_from_tip_m", listOf(r.stylus_from_tip_m)},
        {"grip_from_tip_m", listOf(r.grip_from_tip_m)},
        {"latency_s", r.latency_s},
        {"fre_m", r.fre_m},
        {"tre_mean_m", r.tre_mean_m},
        {"tre_worst_m", r.tre_worst_m},
        {"centre_m", listOf(r.centre_m)},
        {"points", r.points},
        {"rejected", r.rejected},
        {"date", r.date}};
    return whole.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

void saveRegistration(const Registration& registration, const std::filesystem::path& file) {
    const std::string text = registrationText(registration);
    // Refuse a registration that could not be read back unchanged.
    if (!(parseRegistration(text, file).key == registration.key))
        throw DataError(file, "key", "is not UTF-8");
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw DataError(folder, "folder", error.message());
    const std::filesystem::path fresh = file.string() + ".new";
    {
        records::DiskFile out(fresh);
        out.write({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
        out.sync();
    }
    std::filesystem::rename(fresh, file, error);
    if (error) {
        std::error_code ignored;
        std::filesystem::remove(fresh, ignored);
        throw DataError(file, "file", error.message());
    }
    records::syncFolder(folder);
}

std::filesystem::path registrationFile(const std::filesystem::path& folder, const RegistrationKey& key) {
    return folder / fileName(key);
}

std::optional<Registration> findRegistration(const std::filesystem::path& folder,
                                             const RegistrationKey& key) {
    const std::filesystem::path file = registrationFile(folder, key);
    std::error_code error;
    if (!std::filesystem::exists(file, error)) return std::nullopt;
    Registration found = loadRegistration(file);
    if (!(found.key == key)) throw DataError(file, "key", "is of another device or room");
    return found;
}

std::optional<Registration> newestRegistration(const std::filesystem::path& folder, const std::string& device,
                                               const std::string& unit) {
    std::optional<Registration> newest;
    std::optional<DataError> bad;  // may belong to another device
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
        if (entry.path().extension() != ".json") continue;
        try {
            Registration found = loadRegistration(entry.path());
            if (found.key.device != device || found.key.unit != unit) continue;
            if (!newest || newest->date < found.date) newest = std::move(found);
        } catch (const DataError& e) {
            bad = e;
        }
    }
    if (!newest && bad) throw *bad;
    return newest;
}

}  // namespace stylet::trainer
