// An attempt of a trainee, kept in the store while it runs: samples tick by tick, events as they come, result
// and metrics at its end (records/store.h). A kill costs the last quarter of a second.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "app/records/outbox.h"
#include "app/records/samples.h"
#include "app/records/store.h"
#include "app/trainer/session.h"

namespace stylet::trainer {

class Keeper {
  public:
    // Opens the store, says what it found cut short, and sends to `database` from a thread of its own, unless
    // that is empty. Throws patient::DataError.
    Keeper(const std::filesystem::path& store, const std::string& database,
           const std::function<void(const std::string&)>& say);
    ~Keeper();  // an attempt that never came to a tick is not kept
    Keeper(const Keeper&) = delete;
    Keeper& operator=(const Keeper&) = delete;

    // Whether this store has nothing of the trainee.
    bool isNew(const std::string& trainee) const { return store_.attempts(trainee).empty(); }
    // An attempt begins; the folder for what it leaves.
    std::filesystem::path begin(const records::AttemptInfo&);
    // How long the trainee has been at it without a rest, by the store.
    double sinceRest_s(const std::string& trainee) const;
    // Session thread: after each tick.
    void take(const haptics::TickOutput&, const SessionLog&);
    // Session thread: after an event that must not wait for a tick. `at_once`: what would have to wait for
    // another process comes with the next.
    void storeEvents(const SessionLog&, bool at_once = true);
    // All of the folder is written. Acknowledged when it returns; its id.
    const std::string& finish(const SessionLog&);
    // To the training centre, for at most 10 s; how much still waits then.
    std::size_t send();

  private:
    records::Store store_;
    std::optional<records::BackgroundSender> sender_;
    std::string id_;
    records::SamplesHeader header_;
    std::optional<records::SampleWriter> samples_;  // once there is a tick
    bool finished_ = false;
    std::size_t stored_events_ = 0;
    std::uint64_t unstored_ticks_ = 0;
};

}  // namespace stylet::trainer
