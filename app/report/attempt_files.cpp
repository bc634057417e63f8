#include "app/report/attempt_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>

#include "app/records/samples.h"
#include "base/fields.h"
#include "base/whole_file.h"

namespace stylet::report {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostFileBytes = 1u << 30;       // of a file that is read whole
constexpr std::size_t kHeaderBytes = (1u << 20) + 64;  // upper bound of a record's header
constexpr std::size_t kMostRows = 1 << 20;             // of a list in a summary
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::vector<unsigned char> beginningOf(const fs::path& file) {
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

// A missing number is `absent`. So is null, which is how JSON stores NaN.
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

MomentRow momentOf(Fields& r) {
    return {readText(r, "name"), readCount(r, "tick"), readNumber(r, "depth_m")};
}

PunctureRow punctureOf(Fields& r) {
    return {readText(r, "tissue"),
            readText(r, "kind"),
            readText(r, "label"),
            readCount(r, "tick"),
            readNumber(r, "border_depth_m"),
            readNumber(r, "tenting_m"),
            readNumber(r, "force_before_n"),
            readNumber(r, "force_after_n")};
}

records::AttemptResult scoreOf(Fields& summary) {
    records::AttemptResult result;
    Fields score = summary.childOrEmpty("score"), haptics = summary.childOrEmpty("haptics");
    result.target_hit = readFlag(summary, "target_hit");
    result.total = readNumber(score, "total");
    result.ticks = readCount(haptics, "ticks");
    for (Fields& r : score.childrenOrNone("metrics", kMostRows))
        result.metrics.push_back({readText(r, "id"), readText(r, "name"), readText(r, "unit"),
                                  readNumber(r, "value", kUnknown), readNumber(r, "points"),
                                  readNumber(r, "most_points")});
    return result;
}

// Returns the next field of a CSV line without quotes, and advances `line` behind it.
std::string_view field(std::string_view& line) {
    const std::size_t comma = std::min(line.find(','), line.size());
    const std::string_view found = line.substr(0, comma);
    line.remove_prefix(std::min(comma + 1, line.size()));
    return found;
}

double finite(std::string_view text, const fs::path& file, std::size_t row, const char* name) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        throw DataError(file, "row " + std::to_string(row) + ", " + name, "is no number");
    return value;
}

void note(AttemptFiles& files, const std::exception& e) {
    files.complaints.emplace_back(e.what());
}

CourseRow rowOf(const records::Sample& s, double dt_s) {
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
void readHeader(records::AttemptInfo& info, const fs::path& record, std::vector<std::string>& complaints) {
    const fs::path inputs = record / "inputs.bin", samples = record / "samples.bin";
    try {
        if (fs::exists(inputs)) {
            records::Record beginning;
            records::parseInputs(beginningOf(inputs), inputs, beginning);
            info.dt_s = beginning.header.settings.dt_s;
            info.patient_digest = beginning.header.package_digest;
            return;
        }
    } catch (const DataError& e) {
        complaints.emplace_back(e.what());
    }
    try {
        if (!fs::exists(samples)) return;
        const records::SamplesHeader header = records::parseSamples(beginningOf(samples), samples).header;
        info.dt_s = header.dt_s;
        info.patient_digest = header.package_digest;
    } catch (const DataError&) {
        // readCourse() reads the same file and reports the error
    }
}

// Reads every tick from the samples, or without samples the ticks inside the body from the curve.
void readCourse(AttemptFiles& files) {
    const fs::path folder = files.stored.folder;
    const fs::path curve = folder / "force-depth.csv";
    try {
        if (fs::exists(folder / "record" / "samples.bin")) {
            const records::Samples samples = records::loadSamples(folder / "record");
            files.course.reserve(samples.samples.size());
            for (const records::Sample& sample : samples.samples)
                files.course.push_back(rowOf(sample, samples.header.dt_s));
            if (samples.torn_bytes > 0)
                files.complaints.push_back((folder / "record" / "samples.bin").string() + ": " +
                                           std::to_string(samples.torn_bytes) +
                                           " bytes behind the last whole frame are left out");
            files.sampled = !files.course.empty();
            if (files.sampled) return;
        }
    } catch (const DataError& e) {
        note(files, e);
    }
    try {
        if (fs::exists(curve)) files.course = parseCurve(readWholeFile(curve, kMostFileBytes), curve);
    } catch (const DataError& e) {
        note(files, e);
    }
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
    for (Fields& moment : r.childrenOrNone("moments", kMostRows))
        s.moments.push_back(momentOf(moment));
    for (Fields& puncture : r.childrenOrNone("punctures", kMostRows))
        s.punctures.push_back(punctureOf(puncture));
    if (r.has("score")) s.score = scoreOf(r);
    return s;
}

std::vector<CourseRow> parseCurve(std::string_view csv, const fs::path& file) {
    std::vector<CourseRow> rows;
    std::size_t number = 0;
    while (!csv.empty()) {
        const std::size_t end = std::min(csv.find('\n'), csv.size());
        std::string_view line = csv.substr(0, end);
        csv.remove_prefix(std::min(end + 1, csv.size()));
        if (++number == 1) {
            if (line != "tick,time_s,depth_m,force_n,phase,tissue,breath_held")
                throw DataError(file, "header", "is not that of a force-depth curve");
            continue;
        }
        field(line);  // skip the tick: the time is enough
        CourseRow row;
        row.in_body = true;
        row.clearance_m = kUnknown, row.breath_v = kUnknown, row.sent_n = kUnknown;
        row.t_s = finite(field(line), file, number, "time_s");
        row.depth_m = finite(field(line), file, number, "depth_m");
        row.force_n = finite(field(line), file, number, "force_n");
        field(line);  // skip the phase
        const std::string_view tissue = field(line);
        bool known = false;
        for (int t = 0; t < patient::kTissueCount; ++t)
            if (patient::tissueName(patient::Tissue(t)) == tissue)
                row.tissue = patient::Tissue(t), known = true;
        if (!known) throw DataError(file, "row " + std::to_string(number) + ", tissue", "is unknown");
        if (line != "0" && line != "1")
            throw DataError(file, "row " + std::to_string(number) + ", breath_held", "is neither 0 nor 1");
        row.breath_held = line == "1";
        if (!rows.empty() && row.t_s < rows.back().t_s)
            throw DataError(file, "row " + std::to_string(number) + ", time_s", "runs backward");
        rows.push_back(row);
    }
    return rows;
}

AttemptFiles readAttempt(const records::StoredAttempt& stored) {
    AttemptFiles files;
    files.stored = stored;
    const fs::path summary = stored.folder / "summary.json",
                   record = stored.folder / "record" / "record.json";
    if (!fs::exists(summary) && !fs::exists(record))
        throw DataError(stored.folder, "folder",
                        "holds neither summary.json nor record/record.json, so it is not an attempt");
    try {
        if (fs::exists(record))
            files.record = records::parseInfo(readWholeFile(record, kMostFileBytes), record);
    } catch (const DataError& e) {
        note(files, e);
    }
    try {
        if (fs::exists(summary))
            files.summary = parseSummary(readWholeFile(summary, kMostFileBytes), summary),
            files.summarised = true;
    } catch (const DataError& e) {
        note(files, e);
    }
    readCourse(files);
    return files;
}

AttemptFiles readFolder(const fs::path& folder) {
    records::StoredAttempt stored;
    stored.folder = folder;
    const fs::path whole = fs::weakly_canonical(folder);
    stored.id = whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
    std::vector<std::string> complaints;
    readHeader(stored.info, folder / "record", complaints);
    AttemptFiles files = readAttempt(stored);
    files.complaints.insert(files.complaints.begin(), complaints.begin(), complaints.end());
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
    s.state = files.summarised ? records::AttemptState::done : records::AttemptState::cut_short;
    if (files.summary.score) s.result = files.summary.score;
    return files;
}

}  // namespace stylet::report
