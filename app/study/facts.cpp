#include "app/study/facts.h"

#include <array>
#include <climits>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/fields.h"
#include "base/hex.h"
#include "base/whole_file.h"
#include "patient/package/origin.h"

namespace stylet::study {

using patient::Tissue;

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kPairFormat = "stylet study pair 3";
constexpr const char* kPlanFormat = "stylet study plan 1";
constexpr const char* kStudyFormat = "stylet study 1";
constexpr std::size_t kMaxBytes = 1 << 26, kMaxBins = 1 << 20, kMaxPatients = 10'000, kMaxVerdicts = 2;

PackageFacts makePackageFacts(const patient::Package& p, bool (*counts)(const patient::Label&)) {
    PackageFacts f{p.name, p.licence,   patient::describeOrigin(p), patient::segmentedShare(p),
                   {},     p.thresholds};
    std::array<std::size_t, 256> voxels{};
    for (const std::uint8_t id : p.labels.voxels)
        ++voxels[id];
    for (const patient::Label& l : p.label_table)
        if (voxels[l.id] > 0)
            f.labels.push_back({l.id, l.name, l.provenance, l.tissue, voxels[l.id], !counts || counts(l)});
    return f;
}

// ---- JSON

Json packageJson(const PackageFacts& p) {
    const patient::Thresholds& t = p.thresholds;
    Json json = {{"name", p.name},
                 {"licence", p.licence},
                 {"provenance", p.provenance},
                 {"labelled_share", p.labelled_share},
                 {"thresholds_hu", {t.t0_hu, t.t1_hu, t.t2_sensitive_hu, t.t2_specific_hu}},
                 {"labels", Json::array()}};
    for (const LabelFacts& l : p.labels)
        json["labels"].push_back({{"id", l.id},
                                  {"name", l.name},
                                  {"tissue", patient::tissueName(l.tissue)},
                                  {"provenance", l.provenance},
                                  {"voxels", l.voxels},
                                  {"counts", l.counts}});
    return json;
}

Fields readJson(const fs::path& file, const char* format) {
    if (!fs::exists(file)) throw DataError(file, "file", "cannot be read: plan and run the study first");
    Fields in = parseJson(file, readWholeFile(file, kMaxBytes));
    if (in.text("format") != format) in.refuse("format", std::string("not \"") + format + "\"");
    return in;
}

Tissue readTissue(Fields& in, const char* key) {
    return in.choice<Tissue>(key, patient::kTissueNames);
}

double readMm(Fields& in, const char* key) {
    return 1e-3 * in.number(key);
}

std::vector<std::size_t> readBins(Fields& in, const char* key) {
    const std::vector<std::int64_t> bins = in.integers(key, 0, INT64_MAX, kMaxBins);
    return {bins.begin(), bins.end()};
}

PackageFacts readPackage(Fields in) {
    PackageFacts p;
    p.name = in.text("name");
    p.licence = in.text("licence");
    p.provenance = in.text("provenance");
    p.labelled_share = in.number("labelled_share");
    const auto hu = in.numbers<4>("thresholds_hu");
    p.thresholds = {hu[0], hu[1], hu[2], hu[3]};
    for (Fields& label : in.children("labels", 255))
        p.labels.push_back({std::uint8_t(label.integer("id", 1, 255)), label.text("name"),
                            label.text("provenance"), readTissue(label, "tissue"), label.count("voxels"),
                            label.flag("counts")});
    return p;
}

}  // namespace

PairFacts makePairFacts(const Pair& pair, const std::string& own_table) {
    const Grid& grid = pair.reference.ct.grid;
    PairFacts f;
    f.reference = makePackageFacts(pair.reference, nullptr);
    f.found = makePackageFacts(
        pair.found, pair.labels == FoundLabels::partial ? &patient::isInPartialSegmentation : nullptr);
    f.spacing_m = grid.spacing_m;
    f.dims = grid.dims;
    f.tissues = pair.reference.tissues;
    f.own_table = own_table;
    f.implausible = pair.implausible;
    return f;
}

void writeFacts(const fs::path& file, const PairFacts& f) {
    Json json = {{"format", kPairFormat},
                 {"reference", packageJson(f.reference)},
                 {"found", packageJson(f.found)},
                 {"spacing_m", {f.spacing_m.x, f.spacing_m.y, f.spacing_m.z}},
                 {"dims", {f.dims.x, f.dims.y, f.dims.z}},
                 {"own_table", f.own_table},
                 {"implausible", f.implausible},
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
    Fields in = readJson(file, kPairFormat);
    PairFacts f;
    f.reference = readPackage(in.child("reference"));
    f.found = readPackage(in.child("found"));
    f.spacing_m = in.vector("spacing_m");
    const std::vector<std::int64_t> dims = in.integers("dims", 0, INT_MAX, 3);
    if (dims.size() != 3) in.refuse("dims", "must be three integers");
    f.dims = {dims[0], dims[1], dims[2]};
    f.own_table = in.text("own_table");
    // Absent in the results of older versions.
    if (in.has("implausible")) f.implausible = in.texts("implausible", kMaxVerdicts);
    f.run = in.hex("run");
    f.paths = std::size_t(in.integer("paths", 0, patient::kMaxStoredPaths));
    std::vector<Fields> rows = in.children("tissues", f.tissues.size());
    if (rows.size() != f.tissues.size()) in.refuse("tissues", "must have one row per tissue");
    for (std::size_t t = 0; t < rows.size(); ++t) {
        const bool infinite = rows[t].kind("cut_force_n") == FieldKind::null;
        f.tissues[t].cut_force_n = infinite ? INFINITY : rows[t].number("cut_force_n");
        f.tissues[t].friction_n = rows[t].number("friction_n");
        f.tissues[t].stiffness_n_per_m = rows[t].number("stiffness_n_per_m");
    }
    return f;
}

PlanFacts readPlanFacts(const fs::path& file) {
    Fields in = readJson(file, kPlanFormat);
    PlanFacts f{readMm(in, "skin_spacing_mm"),
                readMm(in, "target_spacing_mm"),
                int(in.integer("breaths", INT_MIN, INT_MAX)),
                in.count("candidates"),
                in.count("skipped"),
                in.count("blocked"),
                in.count("too_long"),
                in.count("poor"),
                in.count("kept"),
                readBins(in, "c3"),
                readBins(in, "c4"),
                readBins(in, "quality"),
                in.has("worst_quality") ? readBins(in, "worst_quality") : std::vector<std::size_t>()};
    if (f.c3.empty() || f.c3.size() != f.c4.size() || f.c3.size() != f.quality.size() ||
        (!f.worst_quality.empty() && f.worst_quality.size() != f.c3.size()))
        in.refuse("c3", "has another number of bins than the other scores");
    return f;
}

RunFacts readRunFacts(const fs::path& file) {
    Fields in = readJson(file, kStudyFormat), settings = in.child("settings");
    RunFacts f;
    for (Fields& patient : in.children("patients", kMaxPatients)) {
        f.names.push_back(patient.text("name"));
        if (!isPairName(f.names.back())) patient.refuse("name", "cannot be a folder's name");
    }
    SteeringSettings& s = f.settings.steering;
    s.samples = int(settings.integer("samples", INT_MIN, INT_MAX));
    s.max_spacing_m = readMm(settings, "max_spacing_mm");
    s.needle.a1_share = settings.number("a1_share");
    s.needle.cut_reach_m = readMm(settings, "cut_reach_mm");
    s.needle.max_force_n = settings.number("max_force_n");
    s.breathing = settings.flag("breathing");
    s.speed_m_s = readMm(settings, "speed_mm_per_s");
    f.settings.measure.event_window_m = readMm(settings, "event_window_mm");
    if (settings.text("found_labels") == "all") f.labels = FoundLabels::all;
    return f;
}

}  // namespace stylet::study
