#include "app/records/export.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/records/record.h"
#include "base/hex.h"
#include "base/whole_file.h"
#include "patient/package/package.h"

namespace stylet::records {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

bool isNumber(const std::string& text) {
    double value = 0.0;
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    return read.ptr == end && read.ec == std::errc();
}

// Spreadsheets evaluate texts that begin with these characters.
bool looksLikeFormula(const std::string& text) {
    return !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos &&
           !isNumber(text);
}

std::string quoted(const std::string& cell) {
    const std::string text = looksLikeFormula(cell) ? "'" + cell : cell;
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text)
        out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + '"';
}

std::string written(double v) {
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%.17g", v);
    return text.data();
}

// A CSV file, written line by line.
class Table {
  public:
    Table(const fs::path& file, const std::vector<std::string>& names) : file_(file) { add(names); }
    void add(const std::vector<std::string>& cells) {
        for (std::size_t i = 0; i < cells.size(); ++i)
            out_ << (i == 0 ? "" : ",") << quoted(cells[i]);
        out_ << "\r\n";
    }
    void close() { writeWholeFile(file_, out_.view()); }

  private:
    fs::path file_;
    std::ostringstream out_;
};

ordered_json numberJson(double v) {
    return std::isfinite(v) ? ordered_json(v) : ordered_json(nullptr);
}

ordered_json attemptJson(const StoredAttempt& a) {
    ordered_json j{{"id", a.id},
                   {"trainee", a.info.trainee},
                   {"started_utc", a.started_utc},
                   {"state", stateName(a.state)},
                   {"device", a.info.device},
                   {"patient", a.info.patient},
                   {"patient_digest", hexText(a.info.patient_digest)},
                   {"scenario", a.info.scenario},
                   {"difficulty", a.info.difficulty},
                   {"program_version", a.info.program_version},
                   {"seed", a.info.seed},
                   {"dt_s", a.info.dt_s},
                   {"device_gain", a.info.device_gain},
                   {"registration_rms_m", a.info.registration_rms_m ? ordered_json(*a.info.registration_rms_m)
                                                                    : ordered_json(nullptr)}};
    ordered_json metrics = ordered_json::array(), events = ordered_json::array();
    if (a.result) {
        j["target_hit"] = a.result->target_hit;
        j["total"] = numberJson(a.result->total);
        j["ticks"] = a.result->ticks;
        for (const MetricRow& m : a.result->metrics)
            metrics.push_back({{"id", m.id},
                               {"name", m.name},
                               {"unit", m.unit},
                               {"value", numberJson(m.value)},
                               {"points", numberJson(m.points)},
                               {"most_points", numberJson(m.most_points)}});
    }
    for (const EventRow& e : a.events)
        events.push_back({{"tick", e.tick}, {"kind", e.kind}, {"text", e.text}});
    j["metrics"] = metrics;
    j["events"] = events;
    return j;
}

void copyFiles(const Store& store, const StoredAttempt& attempt, const fs::path& to, Exported& exported) {
    fs::create_directories(to);
    for (const StoredFile& stored : store.files(attempt.id)) {
        const fs::path from = attempt.folder / stored.file;
        if (!fs::exists(from)) {
            exported.damage.push_back(from.string() + ": is gone");
            continue;
        }
        fs::create_directories((to / stored.file).parent_path());
        fs::copy_file(from, to / stored.file);
        const StoredFile copied = sumOf(to, stored.file);
        if (copied.bytes != stored.bytes || copied.crc32 != stored.crc32)
            exported.damage.push_back(from.string() + ": its checksum does not match");
    }
    writeWholeFile(to / "attempt.json",
                   attemptJson(attempt).dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n');
}

void writeTables(const std::vector<StoredAttempt>& attempts, const fs::path& folder) {
    Table index(folder / "attempts.csv",
                {"id", "trainee", "started_utc", "state", "device", "patient", "patient_digest", "scenario",
                 "difficulty", "program_version", "seed", "dt_s", "device_gain", "registration_rms_m",
                 "target_hit", "total", "ticks"});
    Table metrics(folder / "metrics.csv",
                  {"attempt", "id", "name", "unit", "value", "points", "most_points"});
    Table events(folder / "events.csv", {"attempt", "tick", "kind", "text"});
    for (const StoredAttempt& a : attempts) {
        index.add({a.id, a.info.trainee, a.started_utc, std::string(stateName(a.state)), a.info.device,
                   a.info.patient, hexText(a.info.patient_digest), a.info.scenario, a.info.difficulty,
                   a.info.program_version, std::to_string(a.info.seed), written(a.info.dt_s),
                   written(a.info.device_gain),
                   a.info.registration_rms_m ? written(*a.info.registration_rms_m) : "",
                   a.result ? (a.result->target_hit ? "1" : "0") : "",
                   a.result ? written(a.result->total) : "",
                   a.result ? std::to_string(a.result->ticks) : ""});
        for (const MetricRow& m : a.result ? a.result->metrics : std::vector<MetricRow>{})
            metrics.add(
                {a.id, m.id, m.name, m.unit, written(m.value), written(m.points), written(m.most_points)});
        for (const EventRow& e : a.events)
            events.add({a.id, std::to_string(e.tick), e.kind, e.text});
    }
    index.close(), metrics.close(), events.close();
}

void writeChecksums(const fs::path& folder) {
    std::vector<StoredFile> sums = sumsOf(folder);
    Table table(folder / "checksums.csv", {"path", "bytes", "crc32"});
    for (const StoredFile& sum : sums) {
        std::array<char, 16> hex{};
        std::snprintf(hex.data(), hex.size(), "%08x", unsigned(sum.crc32));
        table.add({sum.file.generic_string(), std::to_string(sum.bytes), hex.data()});
    }
    table.close();
}

}  // namespace

Exported exportAttempts(const Store& store, const std::string& trainee, const fs::path& folder) {
    try {
        fs::create_directories(folder);
        if (!fs::is_empty(folder)) throw DataError(folder, "folder", "is not empty");
        Exported exported;
        std::vector<StoredAttempt> attempts = store.attempts(trainee);
        for (const StoredAttempt& attempt : attempts)
            if (attempt.state == AttemptState::running) exported.left_out.push_back(attempt.id);
        std::erase_if(attempts, [](const StoredAttempt& a) { return a.state == AttemptState::running; });
        for (const StoredAttempt& attempt : attempts)
            copyFiles(store, attempt, folder / "attempts" / attempt.id, exported);
        writeTables(attempts, folder);
        writeChecksums(folder);
        exported.attempts = attempts.size();
        return exported;
    } catch (const fs::filesystem_error& e) {
        throw DataError(e.path1(), "file", e.code().message());
    }
}

}  // namespace stylet::records
