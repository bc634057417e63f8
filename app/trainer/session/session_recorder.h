// Writes what a session observes into the attempt's record: samples tick by tick, events as they occur. A
// crash loses at most the last quarter of a second.
#pragma once

#include <filesystem>
#include <optional>

#include "app/records/record.h"
#include "app/records/samples.h"
#include "app/trainer/session/session.h"

namespace stylet::trainer {

// Session thread. Every function throws DataError if the disk refuses.
class SessionRecorder {
  public:
    // `folder`: of the record. `record` must outlive this object.
    SessionRecorder(std::filesystem::path folder, const records::SamplesHeader&,
                    records::RecordWriter& record);
    // Call after each tick.
    void update(const haptics::TickOutput&, const SessionLog&);
    // Call after an event that must be written without waiting for a tick.
    void writeEvents(const SessionLog&);
    // Completes the record. Everything is on the disk when it returns.
    void finish(const SessionLog&, const records::AttemptResult&);

  private:
    std::filesystem::path folder_;
    records::SamplesHeader header_;
    records::RecordWriter& record_;
    std::optional<records::SampleWriter> samples_;  // created with the first tick
    std::size_t written_events_ = 0;
    std::uint64_t unwritten_ticks_ = 0;
};

}  // namespace stylet::trainer
