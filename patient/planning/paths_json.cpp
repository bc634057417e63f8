#include "patient/planning/paths_json.h"

#include <array>
#include <nlohmann/json.hpp>

#include "base/fields.h"
#include "base/hex.h"
#include "base/whole_file.h"

namespace stylet::patient {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kPathsFormat = "stylet paths 2";
constexpr std::size_t kMaxBytes = 64 << 20;
constexpr int kMaxPlannerVersion = 1 << 20;
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

PlannedPath readPath(Fields& in) {
    PlannedPath p;
    p.entry_m = in.vector("entry_m", -kPathReach_m, kPathReach_m);
    p.target_m = in.vector("target_m", -kPathReach_m, kPathReach_m);
    p.entry_reference_m = in.vector("entry_reference_m", -kPathReach_m, kPathReach_m);
    p.target_reference_m = in.vector("target_reference_m", -kPathReach_m, kPathReach_m);
    p.breath.v = in.number("breath_v", -2.0, 3.0);
    p.breath.rate_per_s = in.number("breath_rate_per_s", -100.0, 100.0);
    p.length_m = in.number("length_m", 0.0, kPathReach_m);
    p.clearance_score = in.number("clearance_score", 0.0, 1.0);
    p.target_score = in.number("target_score", 0.0, 1.0);
    p.quality = in.number("quality", 0.0, 1.0);
    in.finish();
    return p;
}

}  // namespace

StoredPaths parsePaths(const std::filesystem::path& file, std::string_view text) {
    Fields in = parseJson(file, text);
    if (in.text("format") != kPathsFormat) in.refuse("format", std::string("not ") + kPathsFormat);
    StoredPaths stored;
    stored.patient_digest = in.hex("patient_digest");
    stored.planner_version = int(in.integer("planner_version", 0, kMaxPlannerVersion));
    for (Fields& path : in.children("paths", kMaxStoredPaths))
        stored.paths.push_back(readPath(path));
    in.finish();
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
                              {"patient_digest", hexText(stored.patient_digest)},
                              {"planner_version", stored.planner_version},
                              {"paths", list}}
                                 .dump(1) +
                             '\n');
}

}  // namespace stylet::patient
