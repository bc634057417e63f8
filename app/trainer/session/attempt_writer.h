// Writes a trainee's attempt to the store while it runs: samples tick by tick, events as they occur, result
// and metrics at the end (records/store.h). A crash loses at most the last quarter of a second.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "app/records/outbox.h"
#include "app/records/samples.h"
#include "app/records/store.h"
#include "app/trainer/session/session.h"

namespace stylet::trainer {

class AttemptWriter {
  public:
    // Opens the store and reports attempts that were cut short. If `database` is not empty, sends to it
    // from a thread of its own. Throws DataError.
    AttemptWriter(const std::filesystem::path& store, const std::string& database,
                  const std::function<void(const std::string&)>& say);
    ~AttemptWriter();  // discards an attempt without any tick
    AttemptWriter(const AttemptWriter&) = delete;
    AttemptWriter& operator=(const AttemptWriter&) = delete;

    // True if the store has no attempt of this trainee.
    bool isNew(const std::string& trainee) const { return store_.attempts(trainee).empty(); }
    // Begins an attempt. Returns the folder for its files.
    std::filesystem::path begin(const records::AttemptInfo&);
    // Working time since the trainee's last rest, according to the store.
    double sinceRest_s(const std::string& trainee) const;
    // Session thread. Call after each tick.
    void update(const haptics::TickOutput&, const SessionLog&);
    // Session thread. Call after an event that must be stored without waiting for a tick. With `at_once`,
    // never waits for another process: events that cannot be stored now are stored by the next call.
    void storeEvents(const SessionLog&, bool at_once = true);
    // Call when all files of the folder are written. Returns the attempt's id. Everything is on disk when it
    // returns.
    const std::string& finish(const SessionLog&);
    // Sends to the training centre for at most 10 s. Returns the number of entries still unsent.
    std::size_t send();

  private:
    records::Store store_;
    std::optional<records::BackgroundSender> sender_;
    std::string id_;
    records::SamplesHeader header_;
    std::optional<records::SampleWriter> samples_;  // created with the first tick
    bool finished_ = false;
    std::size_t stored_events_ = 0;
    std::uint64_t unstored_ticks_ = 0;
};

}  // namespace stylet::trainer
