#include "app/trainer/keeper.h"

namespace stylet::trainer {

namespace {

records::AttemptResult resultOf(const SessionLog& log) {
    records::AttemptResult result{log.target_hit(), log.score.total, log.ticks, {}};
    const auto table = training::metricTable();
    for (std::size_t i = 0; i < table.size(); ++i)
        result.metrics.push_back({std::string(table[i].id), std::string(table[i].name),
                                  std::string(table[i].unit), log.score.values[i], log.score.points[i],
                                  log.score.most_points[i]});
    return result;
}

}  // namespace

Keeper::Keeper(const std::filesystem::path& store, const std::string& database,
               const std::function<void(const std::string&)>& say)
    : store_(store) {
    for (const records::Recovered& cut : store_.recovered())
        say(records::describe(cut));
    if (!database.empty()) sender_.emplace(store, database, say);
}

std::filesystem::path Keeper::begin(const records::AttemptInfo& info) {
    id_ = store_.begin(info);
    header_ = {info.patient_digest, info.dt_s};
    return store_.folderOf(id_);
}

void Keeper::take(const haptics::TickOutput& now, const SessionLog& log) {
    if (!samples_) {
        std::filesystem::create_directories(store_.folderOf(id_) / "record");
        samples_.emplace(store_.folderOf(id_) / "record", header_);
    }
    samples_->add(records::sampleOf(now, log.progress.clearance_m));
    if (++unstored_ticks_ >= records::kFrameTicks) storeEvents(log);
}

void Keeper::storeEvents(const SessionLog& log) {
    std::vector<records::EventRow> fresh;
    for (; stored_events_ < log.events.size(); ++stored_events_) {
        const training::SessionEvent& event = log.events[stored_events_];
        fresh.push_back({event.tick, event.kind, event.text});
    }
    store_.add(id_, fresh);
    unstored_ticks_ = 0;
}

const std::string& Keeper::finish(const SessionLog& log) {
    if (samples_) samples_->finish();
    storeEvents(log);
    store_.finish(id_, resultOf(log));
    return id_;
}

}  // namespace stylet::trainer
