#include "app/trainer/session/attempt_writer.h"

#include <chrono>
#include <cstdio>

#include "app/trainer/session/rest.h"

namespace stylet::trainer {

namespace {

records::AttemptResult makeResult(const SessionLog& log) {
    records::AttemptResult result{log.target_hit(), log.score.total, log.ticks, {}};
    const auto table = training::metricTable();
    for (std::size_t i = 0; i < table.size(); ++i)
        result.metrics.push_back({std::string(table[i].id), std::string(table[i].name),
                                  std::string(table[i].unit), log.score.values[i], log.score.points[i],
                                  log.score.max_points[i]});
    return result;
}

// Converts "2026-11-21T20:15:00.123Z" to seconds since 1970. Returns nothing for other text.
std::optional<double> secondsOf(const std::string& utc) {
    int year = 0, month = 0, day = 0, hour = 0, minute = 0;
    double second = 0.0;
    if (std::sscanf(utc.c_str(), "%d-%d-%dT%d:%d:%lfZ", &year, &month, &day, &hour, &minute, &second) != 6)
        return std::nullopt;
    const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(unsigned(month)),
                                           std::chrono::day(unsigned(day))};
    if (!date.ok()) return std::nullopt;
    const auto days = std::chrono::sys_days(date).time_since_epoch();
    return 86400.0 * double(days.count()) + 3600.0 * hour + 60.0 * minute + second;
}

}  // namespace

AttemptWriter::AttemptWriter(const std::filesystem::path& store, const std::string& database,
                             const std::function<void(const std::string&)>& say)
    : store_(store) {
    for (const std::string& line : store_.openingMessages())
        say(line);
    if (!database.empty()) sender_.emplace(store, database, say);
}

AttemptWriter::~AttemptWriter() {
    if (id_.empty() || samples_ || finished_) return;
    try {
        store_.abandon(id_);
    } catch (const std::exception&) {
        // The store reports this attempt as cut short when it is opened next.
    }
}

std::filesystem::path AttemptWriter::begin(const records::AttemptInfo& info) {
    id_ = store_.begin(info);
    header_ = {info.patient_digest, info.dt_s};
    return store_.attemptFolder(id_);
}

double AttemptWriter::sinceRest_s(const std::string& trainee) const {
    std::vector<WorkPeriod> work;
    for (const records::StoredAttempt& attempt : store_.attempts(trainee)) {
        const std::optional<double> begin_s = secondsOf(attempt.started_utc);
        if (!begin_s || !attempt.result) continue;
        work.push_back({*begin_s, *begin_s + double(attempt.result->ticks) * attempt.info.dt_s});
    }
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return trainer::sinceRest_s(work, std::chrono::duration<double>(now).count());
}

void AttemptWriter::update(const haptics::TickOutput& now, const SessionLog& log) {
    if (!samples_) {
        records::createPrivateFolders(store_.attemptFolder(id_) / "record");
        samples_.emplace(store_.attemptFolder(id_) / "record", header_);
    }
    samples_->add(records::makeSample(now, log.progress.clearance_m));
    if (++unstored_ticks_ >= records::kFrameTicks) storeEvents(log);
}

void AttemptWriter::storeEvents(const SessionLog& log, bool at_once) {
    std::vector<records::EventRow> fresh;
    for (std::size_t i = stored_events_; i < log.events.size(); ++i)
        fresh.push_back({log.events[i].tick, log.events[i].kind, log.events[i].text});
    unstored_ticks_ = 0;
    if (!at_once)
        store_.add(id_, fresh);
    else if (!store_.tryAdd(id_, fresh))
        return;  // retried with the next events
    stored_events_ += fresh.size();
}

const std::string& AttemptWriter::finish(const SessionLog& log) {
    if (samples_) samples_->finish();
    storeEvents(log, false);
    store_.finish(id_, makeResult(log));
    finished_ = true;
    return id_;
}

std::size_t AttemptWriter::send() {
    constexpr std::chrono::seconds kAtMost{10};
    return sender_ ? sender_->drain(kAtMost) : 0;
}

}  // namespace stylet::trainer
