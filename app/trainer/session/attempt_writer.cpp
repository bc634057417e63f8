#include "app/trainer/session/attempt_writer.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "app/trainer/session/input_names.h"
#include "app/trainer/session/rest.h"
#include "app/training/difficulty.h"
#include "app/training/metric_table.h"

namespace stylet::trainer {

namespace {

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
    if (id_.empty() || begun_ || finished_) return;
    try {
        store_.abandon(id_);
    } catch (const std::exception&) {
        // The store reports this attempt as cut short when it is opened next.
    }
}

namespace {

// A guided attempt with at least this share of the procedure done is completed. The store's index contains
// only this share, not the steps.
constexpr double kGuidedEnough = 80.0;  // %

bool isCompleted(const records::AttemptResult& result) {
    const training::Metric& procedure = training::kMetricTable[std::size_t(training::MetricId::procedure)];
    return std::any_of(result.metrics.begin(), result.metrics.end(), [&](const records::MetricRow& row) {
        return row.id == procedure.id && row.value >= kGuidedEnough;
    });
}

}  // namespace

bool AttemptWriter::needsGuidance(const std::string& trainee) const {
    const std::vector<records::StoredAttempt> attempts = store_.attempts(trainee);
    return std::none_of(attempts.begin(), attempts.end(), [](const records::StoredAttempt& a) {
        return records::countsInStatistics(a) && isCompleted(*a.result) &&
               a.info.difficulty == training::difficultyName(training::Difficulty::guided) &&
               a.info.device != kScriptedDevice && a.info.device != kReplayDevice;
    });
}

records::StoredAttempt AttemptWriter::begin(const records::AttemptInfo& info) {
    id_ = store_.begin(info);
    return store_.attempt(id_);
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

const std::string& AttemptWriter::finish() {
    store_.finish(id_);
    finished_ = true;
    return id_;
}

std::size_t AttemptWriter::send() {
    constexpr std::chrono::seconds kAtMost{10};
    return sender_ ? sender_->drain(kAtMost) : 0;
}

}  // namespace stylet::trainer
