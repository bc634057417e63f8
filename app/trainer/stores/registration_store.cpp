#include "app/trainer/stores/registration_store.h"

#include <fmt/core.h>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include "app/records/disk_linux.h"
#include "base/fields.h"
#include "base/hash.h"
#include "base/whole_file.h"
#include "patient/package/package.h"

namespace stylet::trainer {

using json = nlohmann::ordered_json;

namespace {

constexpr int kVersion = 1;
constexpr std::size_t kMaxBytes = 64 * 1024;
constexpr std::size_t kMaxTextBytes = 200;
constexpr double kFarthest_m = 100.0, kUnitTolerance = 1e-6;

json listOf(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Pose poseFrom(Fields pose) {
    constexpr double kMaxComponent = 1.0 + kUnitTolerance;
    const auto q = pose.numbers<4>("rotation_wxyz", -kMaxComponent, kMaxComponent);
    const Quat rotation(q[0], q[1], q[2], q[3]);
    if (std::fabs(glm::length(rotation) - 1.0) > kUnitTolerance)
        pose.refuse("rotation_wxyz", "must be a unit quaternion");
    const Pose result{rotation, pose.vector("position_m", -kFarthest_m, kFarthest_m)};
    pose.finish();
    return result;
}

RegistrationKey keyFrom(Fields key) {
    RegistrationKey result{key.nonEmptyText("device", kMaxTextBytes), key.text("unit", kMaxTextBytes),
                           key.nonEmptyText("space", kMaxTextBytes), key.text("generation", kMaxTextBytes)};
    key.finish();
    return result;
}

Registration registrationFrom(Fields r) {
    r.integer("version", kVersion, kVersion);
    Registration result;
    result.key = keyFrom(r.child("key"));
    result.stage_from_device = poseFrom(r.child("stage_from_device"));
    result.scale = r.number("scale", 0.9, 1.1);
    result.stylus_from_tip_m = r.vector("stylus_from_tip_m", -0.1, 0.1);
    result.grip_from_tip_m = r.vector("grip_from_tip_m", -1.0, 1.0);
    result.latency_s = r.number("latency_s", -1.0, 1.0);
    result.fre_m = r.number("fre_m", 0.0, 1.0);
    result.tre_mean_m = r.number("tre_mean_m", 0.0, 1.0);
    result.tre_worst_m = r.number("tre_worst_m", 0.0, 1.0);
    result.centre_m = r.vector("centre_m", -kFarthest_m, kFarthest_m);
    result.points = int(r.integer("points", 3, 1'000'000));
    result.rejected = int(r.integer("rejected", 0, 1'000'000));
    result.date = r.text("date", kMaxTextBytes);
    r.finish();
    return result;
}

// A name that is valid on any file system. The hash distinguishes names that were truncated or had
// characters replaced.
std::string fileName(const RegistrationKey& key) {
    constexpr std::size_t kMaxNameLength = 100;
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
    return name.substr(0, kMaxNameLength) + fmt::format("{:08x}.json", hash.value() & 0xffffffffu);
}

}  // namespace

Registration parseRegistration(std::string_view text, const std::filesystem::path& file) {
    return registrationFrom(parseJson(file, text));
}

Registration loadRegistration(const std::filesystem::path& file) {
    return parseRegistration(readWholeFile(file, kMaxBytes), file);
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
    if (!(found.key == key)) throw DataError(file, "key", "belongs to another device or room");
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
