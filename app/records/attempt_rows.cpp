#include "app/records/attempt_rows.h"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "app/records/attempt_files.h"
#include "app/records/record.h"
#include "app/training/difficulty.h"
#include "app/training/progress.h"
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
    attempt.imported = r.getColumn(20).getInt() != 0;
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
    attempt.imported = fs::exists(folder / kImportedMark);
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
    if (a.imported) add("imported");
    return std::uint32_t(crc32_z(0, reinterpret_cast<const unsigned char*>(text.data()), text.size()));
}

bool isAttemptId(std::string_view text) {
    return !text.empty() && text != "." && text != ".." &&
           text.find_first_of(std::string_view("/\0", 2)) == text.npos;
}

std::string_view stateName(AttemptState state) {
    return enumName(kStates, state);
}

bool isRestarted(const StoredAttempt& attempt) {
    return std::ranges::any_of(attempt.events, [](const EventRow& e) { return e.kind == "retry"; });
}

bool countsInStatistics(const StoredAttempt& attempt) {
    return attempt.state == AttemptState::done && attempt.result && !attempt.result->aborted &&
           !attempt.imported && !isRestarted(attempt);
}

bool isUnfinishedExam(const StoredAttempt& attempt) {
    const auto hasEvent = [&](const auto& wanted) { return std::ranges::any_of(attempt.events, wanted); };
    // The instructor may have made the exam easier.
    return attempt.state == AttemptState::cut_short &&
           attempt.info.difficulty == training::difficultyName(training::Difficulty::exam) &&
           !hasEvent([](const EventRow& e) { return e.kind == "difficulty"; }) &&
           hasEvent([](const EventRow& e) { return training::isDecisive(e.kind, e.text, true); });
}

std::string_view stateText(const StoredAttempt& attempt) {
    if (attempt.state == AttemptState::cut_short)
        return isUnfinishedExam(attempt) ? "cut short, not passed" : "cut short";
    if (attempt.state == AttemptState::running) return stateName(attempt.state);
    if (attempt.imported) return "imported";
    if (attempt.result && attempt.result->aborted) return "aborted";
    return isRestarted(attempt) ? "restarted" : stateName(attempt.state);
}

namespace {

// Returns "score 99.9 is 1.4 in its record" for the first fact that differs, or nothing.
std::string describeDifference(const StoredAttempt& row, const StoredAttempt& record) {
    std::string found;
    const auto compare = [&](const char* what, const auto& listed, const auto& recorded) {
        if (found.empty() && listed != recorded)
            found = fmt::format("{} {} is {} in its record", what, listed, recorded);
    };
    const auto compareNumber = [&](const std::string& what, double listed, double recorded) {
        if (!(std::isnan(listed) && std::isnan(recorded))) compare(what.c_str(), listed, recorded);
    };
    compare("state", stateName(row.state), stateName(record.state));
    if (row.imported != record.imported)
        found = record.imported ? "listed as recorded by this store, its folder is marked as imported"
                                : "listed as imported, its folder has no such mark";
    compare("trainee", row.info.trainee, record.info.trainee);
    compare("difficulty", row.info.difficulty, record.info.difficulty);
    compare("device", row.info.device, record.info.device);
    compare("scenario", row.info.scenario, record.info.scenario);
    compare("start", row.started_utc, record.started_utc);
    compare("number of events", row.events.size(), record.events.size());
    for (std::size_t i = 0; found.empty() && i < row.events.size(); ++i) {
        const EventRow &listed = row.events[i], &recorded = record.events[i];
        compare("event", fmt::format("{} \"{}\"", listed.kind, listed.text),
                fmt::format("{} \"{}\"", recorded.kind, recorded.text));
        compare("an event's tick", listed.tick, recorded.tick);
    }
    if (!found.empty() || !row.result || !record.result) return found;
    const AttemptResult &listed = *row.result, &recorded = *record.result;
    compareNumber("score", listed.total, recorded.total);
    compare("target hit", listed.target_hit, recorded.target_hit);
    compare("aborted", listed.aborted, recorded.aborted);
    compare("ticks", listed.ticks, recorded.ticks);
    compare("score table", listed.score_version, recorded.score_version);
    compare("number of metrics", listed.metrics.size(), recorded.metrics.size());
    for (std::size_t i = 0; found.empty() && i < listed.metrics.size(); ++i) {
        const MetricRow &a = listed.metrics[i], &b = recorded.metrics[i];
        compare("metric", a.id, b.id);
        compareNumber(a.id, a.value, b.value);
        compareNumber(a.id + " points", a.points, b.points);
    }
    return found;
}

}  // namespace

std::vector<std::string> findAlteredRows(const std::vector<StoredAttempt>& attempts) {
    std::vector<std::string> lines;
    std::string first_unreadable;
    std::size_t unreadable = 0;
    for (const StoredAttempt& row : attempts) {
        if (row.state == AttemptState::running) continue;
        if (row.state == AttemptState::cut_short && !fs::exists(recordFile(row.folder))) {
            if (row.info.difficulty == training::difficultyName(training::Difficulty::exam))
                lines.push_back(
                    fmt::format("attempt {}: an exam that was cut short; it has no record", row.id));
            continue;
        }
        try {
            const std::string difference =
                describeDifference(row, makeStoredAttempt(loadAttemptHead(row.folder), row.folder));
            if (!difference.empty())
                lines.push_back(
                    fmt::format("attempt {}: the index or the record was altered: {}", row.id, difference));
        } catch (const std::exception& e) {
            if (unreadable++ == 0) first_unreadable = e.what();
        }
    }
    if (unreadable > 0)
        lines.push_back(
            fmt::format("{} not compared with {}: {}",
                        unreadable == 1 ? "1 attempt was" : std::to_string(unreadable) + " attempts were",
                        unreadable == 1 ? "its record" : "their records", first_unreadable));
    return lines;
}

}  // namespace stylet::records
