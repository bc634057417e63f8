#include "app/records/attempt_rows.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "app/records/record.h"
#include "base/hex.h"
#include "base/text.h"

namespace stylet::records {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::string_view, 3> kStates{"running", "done", "cut_short"};

AttemptState parseState(const std::string& name) {
    if (const auto state = findEnum<AttemptState>(kStates, name)) return *state;
    throw std::invalid_argument("no attempt has the state \"" + name + '"');
}

// An id names a folder that is deleted together with its trainee, so it must not be any other path.
std::string checkedId(const std::string& text) {
    if (!isAttemptId(text)) throw std::invalid_argument("\"" + text + "\" is no attempt's id");
    return text;
}

double numberOrNan(const SQLite::Column& column) {
    return column.isNull() ? std::numeric_limits<double>::quiet_NaN() : column.getDouble();
}

std::vector<MetricRow> readMetrics(SQLite::Database& database, std::int64_t number) {
    SQLite::Statement rows(
        database,
        "SELECT id, name, unit, value, points, most_points FROM metric WHERE attempt = ? ORDER BY place");
    rows.bind(1, number);
    std::vector<MetricRow> metrics;
    while (rows.executeStep())
        metrics.push_back({rows.getColumn(0).getString(), rows.getColumn(1).getString(),
                           rows.getColumn(2).getString(), numberOrNan(rows.getColumn(3)),
                           numberOrNan(rows.getColumn(4)), numberOrNan(rows.getColumn(5))});
    return metrics;
}

std::vector<EventRow> readEvents(SQLite::Database& database, std::int64_t number) {
    SQLite::Statement rows(database, "SELECT tick, kind, text FROM event WHERE attempt = ? ORDER BY place");
    rows.bind(1, number);
    std::vector<EventRow> events;
    while (rows.executeStep())
        events.push_back({std::uint64_t(rows.getColumn(0).getInt64()), rows.getColumn(1).getString(),
                          rows.getColumn(2).getString()});
    return events;
}

}  // namespace

StoredAttempt readAttemptRow(SQLite::Database& database, SQLite::Statement& r, const fs::path& folder) {
    StoredAttempt attempt;
    const std::int64_t number = r.getColumn(0).getInt64();
    attempt.id = checkedId(r.getColumn(1).getString());
    attempt.info.trainee = r.getColumn(2).getString();
    attempt.started_utc = r.getColumn(3).getString();
    attempt.state = parseState(r.getColumn(4).getString());
    attempt.info.device = r.getColumn(5).getString();
    attempt.info.patient = r.getColumn(6).getString();
    attempt.info.patient_digest = std::stoull(r.getColumn(7).getString(), nullptr, 16);
    attempt.info.scenario = r.getColumn(8).getString();
    attempt.info.difficulty = r.getColumn(9).getString();
    attempt.info.program_version = r.getColumn(10).getString();
    attempt.info.seed = std::stoull(r.getColumn(11).getString());
    attempt.info.dt_s = r.getColumn(12).getDouble();
    attempt.info.device_gain = r.getColumn(13).getDouble();
    if (!r.getColumn(14).isNull()) attempt.info.registration_rms_m = r.getColumn(14).getDouble();
    if (attempt.state == AttemptState::done)
        attempt.result = AttemptResult{r.getColumn(15).getInt() != 0,
                                       numberOrNan(r.getColumn(16)),
                                       std::uint64_t(r.getColumn(17).getInt64()),
                                       readMetrics(database, number),
                                       r.getColumn(18).getInt() != 0,
                                       std::uint64_t(r.getColumn(19).getInt64())};
    attempt.events = readEvents(database, number);
    attempt.folder = folder / attempt.id;
    return attempt;
}

StoredAttempt makeStoredAttempt(const Record& record, const fs::path& folder) {
    const RecordInfo& info = record.info;
    StoredAttempt attempt;
    attempt.id = info.id;
    attempt.info = {info.trainee,
                    info.device,
                    info.patient_name,
                    info.scenario,
                    info.difficulty,
                    info.program_version,
                    record.header.package_digest,
                    info.seed,
                    record.header.settings.dt_s,
                    info.gain,
                    info.registration_rms_m};
    attempt.started_utc = info.started_utc;
    attempt.state = info.result ? AttemptState::done : AttemptState::cut_short;
    attempt.result = info.result;
    attempt.events = info.events;
    attempt.folder = folder;
    return attempt;
}

std::uint32_t computeRowsChecksum(const StoredAttempt& a) {
    std::string text;
    const auto add = [&](const std::string& part) { text += std::to_string(part.size()) + ':' + part; };
    const auto number = [&](double v) {
        std::array<char, 48> digits{};
        std::snprintf(digits.data(), digits.size(), "%a", v);
        add(std::isnan(v) ? "nan" : digits.data());
    };
    for (const std::string& part :
         {a.id, a.info.trainee, a.started_utc, std::string(stateName(a.state)), a.info.device, a.info.patient,
          hexText(a.info.patient_digest), a.info.scenario, a.info.difficulty, a.info.program_version,
          std::to_string(a.info.seed)})
        add(part);
    number(a.info.dt_s), number(a.info.device_gain), number(a.info.registration_rms_m.value_or(-1.0));
    if (a.result) {
        add(std::to_string(a.result->target_hit) + std::to_string(a.result->ticks));
        number(a.result->total);
        // Only if they differ from the default, because older rows were stored without them.
        if (a.result->aborted) add("aborted");
        if (a.result->score_version != 1) add(std::to_string(a.result->score_version));
        for (const MetricRow& m : a.result->metrics) {
            add(m.id), add(m.name), add(m.unit);
            number(m.value), number(m.points), number(m.max_points);
        }
    }
    for (const EventRow& e : a.events)
        add(std::to_string(e.tick)), add(e.kind), add(e.text);
    return std::uint32_t(crc32_z(0, reinterpret_cast<const unsigned char*>(text.data()), text.size()));
}

bool isAttemptId(std::string_view text) {
    return !text.empty() && text != "." && text != ".." &&
           text.find_first_of(std::string_view("/\0", 2)) == text.npos;
}

std::string_view stateName(AttemptState state) {
    return enumName(kStates, state);
}

std::string_view stateText(const StoredAttempt& attempt) {
    if (attempt.state == AttemptState::cut_short) return "cut short";
    return attempt.result && attempt.result->aborted ? "aborted" : stateName(attempt.state);
}

}  // namespace stylet::records
