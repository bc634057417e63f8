#include "app/report/attempt_files.h"

#include <fmt/core.h>

#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>

#include "app/records/samples.h"
#include "base/csv.h"
#include "base/fields.h"
#include "base/text.h"
#include "base/whole_file.h"

namespace stylet::report {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMaxFileBytes = 1u << 30;        // of a file that is read whole
constexpr std::size_t kHeaderBytes = (1u << 20) + 64;  // upper bound of a record's header
constexpr std::size_t kMaxRows = 1 << 20;              // of a list in a summary
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::vector<unsigned char> readBeginning(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw DataError(file, "file", "cannot be read");
    std::vector<unsigned char> bytes(kHeaderBytes);
    stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    bytes.resize(std::size_t(stream.gcount()));
    return bytes;
}

// Every field of a summary is optional, but one of the wrong type is an error.
std::string readText(Fields& in, const char* key) {
    return in.textOr(key, "");
}

// Returns `absent` if the number is missing or null. JSON stores NaN as null.
double readNumber(Fields& in, const char* key, double absent = 0.0) {
    const FieldKind kind = in.kind(key);
    return kind == FieldKind::absent || kind == FieldKind::null ? absent : in.number(key);
}

std::uint64_t readCount(Fields& in, const char* key) {
    return in.has(key) ? in.count(key) : 0;
}

bool readFlag(Fields& in, const char* key) {
    return in.has(key) && in.flag(key);
}

CaptureRow parseCapture(Fields& r) {
    return {readText(r, "name"), readCount(r, "tick"), readNumber(r, "depth_m")};
}

PunctureRow parsePuncture(Fields& r) {
    return {readText(r, "tissue"),
            readText(r, "kind"),
            readText(r, "label"),
            readCount(r, "tick"),
            readNumber(r, "border_depth_m"),
            readNumber(r, "tenting_m"),
            readNumber(r, "force_before_n"),
            readNumber(r, "force_after_n")};
}

records::AttemptResult parseScore(Fields& summary) {
    records::AttemptResult result;
    Fields score = summary.childOrEmpty("score"), haptics = summary.childOrEmpty("haptics");
    result.target_hit = readFlag(summary, "target_hit");
    result.total = readNumber(score, "total");
    result.ticks = readCount(haptics, "ticks");
    for (Fields& r : score.childrenOrNone("metrics", kMaxRows))
        result.metrics.push_back({readText(r, "id"), readText(r, "name"), readText(r, "unit"),
                                  readNumber(r, "value", kUnknown), readNumber(r, "points"),
                                  readNumber(r, "most_points")});
    return result;
}

// Runs `read`. An error becomes a warning.
template <typename Read>
void tryRead(std::vector<std::string>& warnings, const Read& read) {
    try {
        read();
    } catch (const DataError& e) {
        warnings.emplace_back(e.what());
    }
}

CourseRow makeCourseRow(const records::Sample& s, double dt_s) {
    CourseRow row;
    row.t_s = double(s.tick) * dt_s;
    row.in_body = s.phase != haptics::Phase::outside;
    row.depth_m = s.depth_m, row.force_n = s.force_n;
    row.sent_n = glm::length(s.sent_n);
    row.breath_v = s.breath_v;
    row.clearance_m = s.clearance_m;
    row.tip_m = s.tip_m, row.axis = s.axis;
    row.tool = s.tool, row.tissue = s.tissue;
    row.breath_held = s.breath_held;
    row.faults = s.faults;
    return row;
}

// Reads tick duration and patient of an attempt outside a store, from the record's header or else the
// samples'.
void readHeader(records::AttemptInfo& info, const fs::path& record, std::vector<std::string>& warnings) {
    const fs::path inputs = record / "inputs.bin", samples = record / "samples.bin";
    bool found = false;
    tryRead(warnings, [&] {
        if (!fs::exists(inputs)) return;
        records::Record beginning;
        records::parseInputs(readBeginning(inputs), inputs, beginning);
        info.dt_s = beginning.header.settings.dt_s;
        info.patient_digest = beginning.header.package_digest;
        found = true;
    });
    std::vector<std::string> reported_by_read_course;  // readCourse() reports the errors of the same file
    tryRead(reported_by_read_course, [&] {
        if (found || !fs::exists(samples)) return;
        const records::SamplesHeader header = records::parseSamples(readBeginning(samples), samples).header;
        info.dt_s = header.dt_s;
        info.patient_digest = header.package_digest;
    });
}

// Reads every tick from the samples, or without samples the ticks inside the body from the curve.
void readCourse(AttemptFiles& files) {
    const fs::path record = files.stored.folder / "record", curve = files.stored.folder / "force-depth.csv";
    tryRead(files.warnings, [&] {
        if (!fs::exists(record / "samples.bin")) return;
        const records::Samples samples = records::loadSamples(record);
        files.course.reserve(samples.samples.size());
        for (const records::Sample& sample : samples.samples)
            files.course.push_back(makeCourseRow(sample, samples.header.dt_s));
        if (samples.torn_bytes > 0)
            files.warnings.push_back(fmt::format("{}: {} bytes behind the last whole frame are left out",
                                                 (record / "samples.bin").string(), samples.torn_bytes));
        files.has_samples = !files.course.empty();
    });
    tryRead(files.warnings, [&] {
        if (!files.has_samples && fs::exists(curve))
            files.course = parseCurve(readWholeFile(curve, kMaxFileBytes), curve);
    });
}

}  // namespace

Summary parseSummary(std::string_view text, const fs::path& file) {
    Fields r = parseJson(file, text);
    Fields path = r.childOrEmpty("path"), dose = r.childOrEmpty("dose"), haptics = r.childOrEmpty("haptics");
    Summary s;
    s.patient = readText(r, "patient");
    s.scenario = readText(r, "scenario");
    s.device = readText(r, "device");
    s.clock = readText(r, "clock");
    s.state_hash = readText(r, "state_hash");
    s.fault_names = readText(haptics, "fault_names");
    s.seed = readCount(r, "seed");
    s.ticks = readCount(haptics, "ticks");
    s.late_ticks = readCount(haptics, "late_ticks");
    s.target_hit = readFlag(r, "target_hit");
    s.path_length_m = readNumber(path, "length_m");
    s.path_quality = readNumber(path, "quality");
    s.peak_force_n = readNumber(r, "peak_force_n");
    s.lateral_cut_m = readNumber(r, "lateral_cut_m");
    s.fluoroscopy_s = readNumber(dose, "fluoroscopy_s");
    s.air_kerma_gy = readNumber(dose, "air_kerma_gy");
    s.contrast_ml = readNumber(dose, "contrast_ml");
    s.max_step_us = readNumber(haptics, "max_step_us");
    for (Fields& moment : r.childrenOrNone("moments", kMaxRows))
        s.captures.push_back(parseCapture(moment));
    for (Fields& puncture : r.childrenOrNone("punctures", kMaxRows))
        s.punctures.push_back(parsePuncture(puncture));
    if (r.has("score")) s.score = parseScore(r);
    return s;
}

std::vector<CourseRow> parseCurve(std::string_view csv, const fs::path& file) {
    std::vector<CourseRow> course;
    CsvReader rows(file, csv, "tick,time_s,depth_m,force_n,phase,tissue,breath_held");
    while (rows.next()) {
        rows.text();  // the tick; the time replaces it
        CourseRow row;
        row.in_body = true;
        row.clearance_m = kUnknown, row.breath_v = kUnknown, row.sent_n = kUnknown;
        row.t_s = rows.number<double>();
        if (!course.empty() && row.t_s < course.back().t_s) rows.refuse("is earlier than in the row before");
        row.depth_m = rows.number<double>();
        row.force_n = rows.number<double>();
        rows.text();  // the phase
        const auto tissue = findEnum<patient::Tissue>(patient::kTissueNames, rows.text());
        if (!tissue) rows.refuse("is not a tissue");
        row.tissue = *tissue;
        row.breath_held = rows.number<int>(0, 1) == 1;
        course.push_back(row);
    }
    return course;
}

AttemptFiles readAttempt(const records::StoredAttempt& stored) {
    AttemptFiles files;
    files.stored = stored;
    const fs::path summary = stored.folder / "summary.json",
                   record = stored.folder / "record" / "record.json";
    if (!fs::exists(summary) && !fs::exists(record))
        throw DataError(stored.folder, "folder",
                        "holds neither summary.json nor record/record.json, so it is not an attempt");
    tryRead(files.warnings, [&] {
        if (fs::exists(record))
            files.record = records::parseInfo(readWholeFile(record, kMaxFileBytes), record);
    });
    tryRead(files.warnings, [&] {
        if (fs::exists(record.parent_path() / "inputs.bin"))
            files.needle = records::loadHeader(record.parent_path()).settings.tools.needle;
    });
    tryRead(files.warnings, [&] {
        if (!fs::exists(summary)) return;
        files.summary = parseSummary(readWholeFile(summary, kMaxFileBytes), summary);
        files.has_summary = true;
    });
    readCourse(files);
    return files;
}

AttemptFiles readFolder(const fs::path& folder) {
    records::StoredAttempt stored;
    stored.folder = folder;
    const fs::path whole = fs::weakly_canonical(folder);
    stored.id = whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
    std::vector<std::string> warnings;
    readHeader(stored.info, folder / "record", warnings);
    AttemptFiles files = readAttempt(stored);
    files.warnings.insert(files.warnings.begin(), warnings.begin(), warnings.end());
    records::StoredAttempt& s = files.stored;
    s.info.patient = files.summary.patient;
    s.info.scenario = files.summary.scenario;
    s.info.device = files.summary.device;
    s.info.seed = files.summary.seed;
    if (files.record) {
        s.info.program_version = files.record->program_version;
        s.info.device_gain = files.record->gain;
        s.info.seed = files.record->seed;
        if (s.info.patient.empty()) s.info.patient = files.record->patient_name;
        if (s.info.scenario.empty()) s.info.scenario = files.record->scenario;
    }
    s.state = files.has_summary ? records::AttemptState::done : records::AttemptState::cut_short;
    if (files.summary.score) s.result = files.summary.score;
    return files;
}

}  // namespace stylet::report
