#include "patient/planning/paths_json.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/toml_reader.h"
#include "base/whole_file.h"

namespace stylet::patient {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kPathsFormat = "stylet paths 2";
constexpr std::size_t kMaxBytes = 64 << 20;
constexpr int kMaxDepth = 8;
constexpr int kMaxPlannerVersion = 1 << 20;
constexpr std::size_t kDigestDigits = 16;
constexpr double kPathReach_m = 10.0;

Json toJson(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Json toJson(const PlannedPath& p) {
    return {{"entry_m", toJson(p.entry_m)},
            {"target_m", toJson(p.target_m)},
            {"entry_reference_m", toJson(p.entry_reference_m)},
            {"target_reference_m", toJson(p.target_reference_m)},
            {"breath_v", p.breath.v},
            {"breath_rate_per_s", p.breath.rate_per_s},
            {"length_m", p.length_m},
            {"clearance_score", p.clearance_score},
            {"target_score", p.target_score},
            {"quality", p.quality}};
}

// Reads the members of one path. All are required and no others are allowed.
class PathReader {
  public:
    PathReader(const std::filesystem::path& file, std::string field, const Json& json)
        : file_(file), field_(std::move(field)), json_(json) {
        if (!json.is_object()) throw DataError(file_, field_, "not an object");
    }
    double number(const char* key, double low, double high) { return checked(key, member(key), low, high); }
    Vec3 point(const char* key) {
        const Json& value = member(key);
        if (!value.is_array() || value.size() != 3) refuse(key, "not three numbers");
        return {checked(key, value[0], -kPathReach_m, kPathReach_m),
                checked(key, value[1], -kPathReach_m, kPathReach_m),
                checked(key, value[2], -kPathReach_m, kPathReach_m)};
    }
    void finish() const {
        for (const auto& [key, value] : json_.items())
            if (!taken_.contains(key)) refuse(key, "unknown key");
    }

  private:
    [[noreturn]] void refuse(const std::string& key, const std::string& reason) const {
        throw DataError(file_, field_ + "." + key, reason);
    }
    const Json& member(const char* key) {
        const auto found = json_.find(key);
        if (found == json_.end()) refuse(key, "missing");
        taken_.emplace(key);
        return *found;
    }
    double checked(const char* key, const Json& value, double low, double high) const {
        if (!value.is_number()) refuse(key, "not a number");
        const double v = value.get<double>();
        if (!(v >= low && v <= high)) refuse(key, "out of range");
        return v;
    }

    const std::filesystem::path& file_;
    std::string field_;
    const Json& json_;
    std::set<std::string, std::less<>> taken_;
};

PlannedPath readPath(PathReader in) {
    PlannedPath p;
    p.entry_m = in.point("entry_m");
    p.target_m = in.point("target_m");
    p.entry_reference_m = in.point("entry_reference_m");
    p.target_reference_m = in.point("target_reference_m");
    p.breath.v = in.number("breath_v", -2.0, 3.0);
    p.breath.rate_per_s = in.number("breath_rate_per_s", -100.0, 100.0);
    p.length_m = in.number("length_m", 0.0, kPathReach_m);
    p.clearance_score = in.number("clearance_score", 0.0, 1.0);
    p.target_score = in.number("target_score", 0.0, 1.0);
    p.quality = in.number("quality", 0.0, 1.0);
    in.finish();
    return p;
}

std::string digestText(std::uint64_t digest) {
    std::array<char, kDigestDigits + 1> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(digest));
    return text.data();
}

std::uint64_t readDigest(const std::filesystem::path& file, const Json& value) {
    const std::string text = value.is_string() ? value.get<std::string>() : "";
    std::uint64_t digest = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), digest, 16);
    if (text.size() != kDigestDigits || error != std::errc() || end != text.data() + text.size())
        throw DataError(file, "patient_digest", "not 16 hexadecimal digits");
    return digest;
}

int readVersion(const std::filesystem::path& file, const Json& value) {
    const double version = value.is_number_integer() ? value.get<double>() : -1.0;
    if (!(version >= 0.0 && version <= double(kMaxPlannerVersion)))
        throw DataError(file, "planner_version", "not a whole number in range");
    return int(version);
}

Json parseBounded(const std::filesystem::path& file, std::string_view text) {
    const auto checkDepth = [&](int depth, Json::parse_event_t, Json&) {
        if (depth > kMaxDepth) throw DataError(file, "json", "nested too deeply");
        return true;
    };
    try {
        return Json::parse(text, checkDepth);
    } catch (const Json::exception& e) {
        throw DataError(file, "json", e.what());
    }
}

}  // namespace

StoredPaths parsePaths(const std::filesystem::path& file, std::string_view text) {
    const Json json = parseBounded(file, text);
    if (!json.is_object()) throw DataError(file, "json", "not an object");
    if (json.value("format", Json()) != kPathsFormat)
        throw DataError(file, "format", std::string("not ") + kPathsFormat);
    if (json.size() != 4)
        throw DataError(file, "json", "not {format, patient_digest, planner_version, paths}");
    StoredPaths stored;
    stored.patient_digest = readDigest(file, json.value("patient_digest", Json()));
    stored.planner_version = readVersion(file, json.value("planner_version", Json()));
    const auto list = json.find("paths");
    if (list == json.end() || !list->is_array()) throw DataError(file, "paths", "not an array");
    if (list->size() > kMaxStoredPaths) throw DataError(file, "paths", "more than 100000");
    for (const Json& entry : *list)
        stored.paths.push_back(readPath({file, "paths[" + std::to_string(stored.paths.size()) + "]", entry}));
    return stored;
}

StoredPaths loadPaths(const std::filesystem::path& json) {
    return parsePaths(json, readWholeFile(json, kMaxBytes));
}

void savePaths(const StoredPaths& stored, const std::filesystem::path& json) {
    Json list = Json::array();
    for (const PlannedPath& path : stored.paths)
        list.push_back(toJson(path));
    writeWholeFile(json, Json{{"format", kPathsFormat},
                              {"patient_digest", digestText(stored.patient_digest)},
                              {"planner_version", stored.planner_version},
                              {"paths", list}}
                                 .dump(1) +
                             '\n');
}

}  // namespace stylet::patient
