#include "app/trainer/session/session_recorder.h"

namespace stylet::trainer {

SessionRecorder::SessionRecorder(std::filesystem::path folder, const records::SamplesHeader& header,
                                 records::RecordWriter& record)
    : folder_(std::move(folder)), header_(header), record_(record) {}

void SessionRecorder::update(const haptics::TickOutput& now, const SessionLog& log) {
    if (!samples_) samples_.emplace(folder_, header_);
    samples_->add(records::makeSample(now, log.progress.clearance_m));
    if (++unwritten_ticks_ >= records::kFrameTicks) writeEvents(log);
}

void SessionRecorder::writeEvents(const SessionLog& log) {
    std::vector<records::EventRow> fresh;
    for (std::size_t i = written_events_; i < log.events.size(); ++i)
        fresh.push_back({log.events[i].tick, log.events[i].kind, log.events[i].text});
    unwritten_ticks_ = 0;
    record_.addEvents(fresh);
    written_events_ += fresh.size();
}

void SessionRecorder::finish(const SessionLog& log, const records::AttemptResult& result) {
    if (samples_) samples_->finish();
    writeEvents(log);
    record_.finish(result);
}

}  // namespace stylet::trainer
