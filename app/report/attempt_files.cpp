#include "app/report/attempt_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/records/samples.h"
#include "base/whole_file.h"

namespace stylet::report {

using nlohmann::json;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostFileBytes = 1u << 30;       // of a file that is read whole
constexpr std::size_t kHeaderBytes = (1u << 20) + 64;  // upper bound of a record's header
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::vector<unsigned char> beginningOf(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw DataError(file, "file", "cannot be read");
    std::vector<unsigned char> bytes(kHeaderBytes);
    stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    bytes.resize(std::size_t(stream.gcount()));
    return bytes;
}

// Reads optional members. A member of the wrong type is an error that names the field.
class Reader {
  public:
    Reader(const json& object, const fs::path& file, std::string field)
        : object_(object), file_(file), field_(std::move(field)) {
        if (!object.is_object()) throw DataError(file_, field_.empty() ? "json" : field_, "is no object");
    }

    std::string text(const char* name) const {
        const json* j = member(name);
        if (!j) return {};
        if (!j->is_string()) refuse(name, "is no text");
        return j->get<std::string>();
    }
    // A missing member returns `otherwise`. So does null, which is how JSON stores NaN.
    double number(const char* name, double otherwise = 0.0) const {
        const json* j = member(name);
        if (!j || j->is_null()) return otherwise;
        if (!j->is_number()) refuse(name, "is no number");
        return j->get<double>();
    }
    std::uint64_t count(const char* name) const {
        const json* j = member(name);
        if (!j) return 0;
        if (!j->is_number_unsigned()) refuse(name, "is no count");
        return j->get<std::uint64_t>();
    }
    bool flag(const char* name) const {
        const json* j = member(name);
        if (!j) return false;
        if (!j->is_boolean()) refuse(name, "is neither true nor false");
        return j->get<bool>();
    }
    Reader part(const char* name) const {
        static const json none = json::object();
        const json* j = member(name);
        return {j ? *j : none, file_, path(name)};
    }
    bool has(const char* name) const { return member(name) != nullptr; }

    template <typename Take>
    void each(const char* name, const Take& take) const {
        const json* j = member(name);
        if (!j) return;
        if (!j->is_array()) refuse(name, "is no list");
        for (const json& element : *j)
            take(Reader(element, file_, path(name)));
    }

  private:
    const json* member(const char* name) const {
        const auto found = object_.find(name);
        return found == object_.end() ? nullptr : &*found;
    }
    std::string path(const char* name) const { return field_.empty() ? name : field_ + "." + name; }
    [[noreturn]] void refuse(const char* name, const char* reason) const {
        throw DataError(file_, path(name), reason);
    }

    const json& object_;
    fs::path file_;
    std::string field_;
};

MomentRow momentOf(const Reader& r) {
    return {r.text("name"), r.count("tick"), r.number("depth_m")};
}

PunctureRow punctureOf(const Reader& r) {
    return {r.text("tissue"),
            r.text("kind"),
            r.text("label"),
            r.count("tick"),
            r.number("border_depth_m"),
            r.number("tenting_m"),
            r.number("force_before_n"),
            r.number("force_after_n")};
}

records::AttemptResult scoreOf(const Reader& summary) {
    records::AttemptResult result;
    const Reader score = summary.part("score");
    result.target_hit = summary.flag("target_hit");
    result.total = score.number("total");
    result.ticks = summary.part("haptics").count("ticks");
    score.each("metrics", [&](const Reader& r) {
        result.metrics.push_back({r.text("id"), r.text("name"), r.text("unit"), r.number("value", kUnknown),
                                  r.number("points"), r.number("most_points")});
    });
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
    json j;
    try {
        j = json::parse(text);
    } catch (const json::exception& e) {
        throw DataError(file, "json", e.what());
    }
    const Reader r(j, file, "");
    const Reader path = r.part("path"), dose = r.part("dose"), haptics = r.part("haptics");
    Summary s;
    s.patient = r.text("patient");
    s.scenario = r.text("scenario");
    s.device = r.text("device");
    s.clock = r.text("clock");
    s.state_hash = r.text("state_hash");
    s.fault_names = haptics.text("fault_names");
    s.seed = r.count("seed");
    s.ticks = haptics.count("ticks");
    s.late_ticks = haptics.count("late_ticks");
    s.target_hit = r.flag("target_hit");
    s.path_length_m = path.number("length_m");
    s.path_quality = path.number("quality");
    s.peak_force_n = r.number("peak_force_n");
    s.lateral_cut_m = r.number("lateral_cut_m");
    s.fluoroscopy_s = dose.number("fluoroscopy_s");
    s.air_kerma_gy = dose.number("air_kerma_gy");
    s.contrast_ml = dose.number("contrast_ml");
    s.max_step_us = haptics.number("max_step_us");
    r.each("moments", [&](const Reader& moment) { s.moments.push_back(momentOf(moment)); });
    r.each("punctures", [&](const Reader& puncture) { s.punctures.push_back(punctureOf(puncture)); });
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
                        "holds neither summary.json nor record/record.json: no attempt");
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
