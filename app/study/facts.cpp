#include "app/study/facts.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/whole_file.h"

namespace stylet::study {

using patient::Tissue;

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kPairFormat = "stylet study pair 1";
constexpr const char* kPlanFormat = "stylet study plan 1";
constexpr const char* kStudyFormat = "stylet study 1";
constexpr std::size_t kMaxBytes = 1 << 26;

PackageFacts factsOfPackage(const patient::Package& p, bool (*counts)(const patient::Label&)) {
    PackageFacts f{p.name, p.licence, p.provenance, patient::segmentedShare(p), {}, p.thresholds};
    std::array<std::size_t, 256> voxels{};
    for (const std::uint8_t id : p.labels.voxels)
        ++voxels[id];
    for (const patient::Label& l : p.label_table)
        if (voxels[l.id] > 0)
            f.labels.push_back({l.name, l.provenance, l.tissue, voxels[l.id], !counts || counts(l)});
    return f;
}

// ---- JSON

std::string hexText(std::uint64_t v) {
    char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(v));
    return text;
}

Json packageJson(const PackageFacts& p) {
    const patient::Thresholds& t = p.thresholds;
    Json json = {{"name", p.name},
                 {"licence", p.licence},
                 {"provenance", p.provenance},
                 {"labelled_share", p.labelled_share},
                 {"thresholds_hu", {t.t0_hu, t.t1_hu, t.t2_sensitive_hu, t.t2_specific_hu}},
                 {"labels", Json::array()}};
    for (const LabelFacts& l : p.labels)
        json["labels"].push_back({{"name", l.name},
                                  {"tissue", patient::tissueName(l.tissue)},
                                  {"provenance", l.provenance},
                                  {"voxels", l.voxels},
                                  {"counts", l.counts}});
    return json;
}

Json readJson(const fs::path& file, const char* format) {
    if (!fs::exists(file)) throw DataError(file, "file", "cannot be read: plan and run the study first");
    Json json = Json::parse(readWholeFile(file, kMaxBytes), nullptr, false);
    if (!json.is_object() || json.value("format", Json()) != format)
        throw DataError(file, "format", std::string("not \"") + format + "\"");
    return json;
}

// Reads JSON members. A missing member or one of the wrong type is a DataError with its name.
class Members {
  public:
    Members(const fs::path& file, std::string where, const Json& json)
        : file_(file), where_(std::move(where)), json_(json) {}
    template <typename T>
    T get(const char* key) const {
        try {
            return json_.at(key).get<T>();
        } catch (const Json::exception&) {
            throw DataError(file_, where_ + key, "missing, or not what belongs there");
        }
    }
    Members inside(const char* key) const { return {file_, where_ + key + ".", member(key)}; }
    std::vector<Members> list(const char* key) const {
        std::vector<Members> all;
        for (const Json& one : member(key))
            all.push_back({file_, where_ + key + "[" + std::to_string(all.size()) + "].", one});
        return all;
    }
    Tissue tissue(const char* key) const {
        const auto name = get<std::string>(key);
        for (int t = 0; t < patient::kTissueCount; ++t)
            if (patient::tissueName(Tissue(t)) == name) return Tissue(t);
        throw DataError(file_, where_ + key, "no tissue \"" + name + "\"");
    }
    [[noreturn]] void refuse(const char* key, const std::string& reason) const {
        throw DataError(file_, where_ + key, reason);
    }

  private:
    const Json& member(const char* key) const {
        const auto found = json_.is_object() ? json_.find(key) : json_.end();
        if (found == json_.end() || !found->is_structured())
            refuse(key, "missing, or not what belongs there");
        return *found;
    }

    const fs::path& file_;
    std::string where_;
    const Json& json_;
};

PackageFacts readPackage(const Members& in) {
    PackageFacts p;
    p.name = in.get<std::string>("name");
    p.licence = in.get<std::string>("licence");
    p.provenance = in.get<std::string>("provenance");
    p.labelled_share = in.get<double>("labelled_share");
    const auto hu = in.get<std::array<double, 4>>("thresholds_hu");
    p.thresholds = {hu[0], hu[1], hu[2], hu[3]};
    for (const Members& label : in.list("labels"))
        p.labels.push_back({label.get<std::string>("name"), label.get<std::string>("provenance"),
                            label.tissue("tissue"), label.get<std::size_t>("voxels"),
                            label.get<bool>("counts")});
    return p;
}

}  // namespace

PairFacts factsOf(const Pair& pair, const std::string& own_table) {
    const Grid& grid = pair.reference.ct.grid;
    PairFacts f;
    f.reference = factsOfPackage(pair.reference, nullptr);
    f.found = factsOfPackage(
        pair.found, pair.labels == FoundLabels::partial ? &patient::isInPartialSegmentation : nullptr);
    f.spacing_m = grid.spacing_m;
    f.dims = grid.dims;
    f.tissues = pair.reference.tissues;
    f.own_table = own_table;
    return f;
}

void writeFacts(const fs::path& file, const PairFacts& f) {
    Json json = {{"format", kPairFormat},
                 {"reference", packageJson(f.reference)},
                 {"found", packageJson(f.found)},
                 {"spacing_m", {f.spacing_m.x, f.spacing_m.y, f.spacing_m.z}},
                 {"dims", {f.dims.x, f.dims.y, f.dims.z}},
                 {"own_table", f.own_table},
                 {"run", hexText(f.run)},
                 {"paths", f.paths},
                 {"tissues", Json::array()}};
    for (std::size_t t = 0; t < f.tissues.size(); ++t) {
        const patient::TissueRow& row = f.tissues[t];
        json["tissues"].push_back({{"tissue", patient::tissueName(Tissue(t))},
                                   // JSON has no infinity: the value of bone is null.
                                   {"cut_force_n", row.cut_force_n},
                                   {"friction_n", row.friction_n},
                                   {"stiffness_n_per_m", row.stiffness_n_per_m}});
    }
    writeWholeFile(file, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

PairFacts readFacts(const fs::path& file) {
    const Json json = readJson(file, kPairFormat);
    const Members in(file, "", json);
    PairFacts f;
    f.reference = readPackage(in.inside("reference"));
    f.found = readPackage(in.inside("found"));
    const auto spacing = in.get<std::array<double, 3>>("spacing_m");
    const auto dims = in.get<std::array<int, 3>>("dims");
    f.spacing_m = {spacing[0], spacing[1], spacing[2]};
    f.dims = {dims[0], dims[1], dims[2]};
    f.own_table = in.get<std::string>("own_table");
    f.run = std::strtoull(in.get<std::string>("run").c_str(), nullptr, 16);
    f.paths = in.get<std::size_t>("paths");
    constexpr std::size_t kMostPaths = 100'000;  // the same limit as paths.json
    if (f.paths > kMostPaths) in.refuse("paths", "more than 100000");
    const std::vector<Members> rows = in.list("tissues");
    if (rows.size() != f.tissues.size()) in.refuse("tissues", "not one row a tissue");
    for (std::size_t t = 0; t < rows.size(); ++t) {
        const auto cut_n = rows[t].get<Json>("cut_force_n");
        f.tissues[t].cut_force_n = cut_n.is_null() ? INFINITY : rows[t].get<double>("cut_force_n");
        f.tissues[t].friction_n = rows[t].get<double>("friction_n");
        f.tissues[t].stiffness_n_per_m = rows[t].get<double>("stiffness_n_per_m");
    }
    return f;
}

PlanFacts readPlanFacts(const fs::path& file) {
    const Json json = readJson(file, kPlanFormat);
    const Members in(file, "", json);
    using Bins = std::vector<std::size_t>;
    PlanFacts f{1e-3 * in.get<double>("skin_spacing_mm"),
                1e-3 * in.get<double>("target_spacing_mm"),
                in.get<int>("breaths"),
                in.get<std::size_t>("candidates"),
                in.get<std::size_t>("skipped"),
                in.get<std::size_t>("blocked"),
                in.get<std::size_t>("too_long"),
                in.get<std::size_t>("poor"),
                in.get<std::size_t>("kept"),
                in.get<Bins>("c3"),
                in.get<Bins>("c4"),
                in.get<Bins>("quality"),
                json.contains("worst_quality") ? in.get<Bins>("worst_quality") : Bins()};
    if (f.c3.empty() || f.c3.size() != f.c4.size() || f.c3.size() != f.quality.size() ||
        (!f.worst_quality.empty() && f.worst_quality.size() != f.c3.size()))
        in.refuse("c3", "not as many bins as of the other scores");
    return f;
}

RunFacts readRunFacts(const fs::path& file) {
    const Json json = readJson(file, kStudyFormat);
    const Members in(file, "", json), settings = in.inside("settings");
    RunFacts f;
    for (const Members& patient : in.list("patients")) {
        f.names.push_back(patient.get<std::string>("name"));
        if (!isPairName(f.names.back())) patient.refuse("name", "cannot be a folder's name");
    }
    SteeringSettings& s = f.settings.steering;
    s.samples = settings.get<int>("samples");
    s.max_spacing_m = 1e-3 * settings.get<double>("max_spacing_mm");
    s.needle.a1_share = settings.get<double>("a1_share");
    s.needle.cut_reach_m = 1e-3 * settings.get<double>("cut_reach_mm");
    s.needle.max_force_n = settings.get<double>("max_force_n");
    s.breathing = settings.get<bool>("breathing");
    s.speed_m_s = 1e-3 * settings.get<double>("speed_mm_per_s");
    f.settings.measure.event_window_m = 1e-3 * settings.get<double>("event_window_mm");
    if (settings.get<std::string>("found_labels") == "all") f.labels = FoundLabels::all;
    return f;
}

}  // namespace stylet::study
