// Registers a trainee's attempt in the store: begins it, and fills the index from its record at the end
// (records/store.h). session_recorder.h writes the record.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "app/records/outbox.h"
#include "app/records/store.h"

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

    // True until the trainee has done most of the procedure (kGuidedEnough) in one guided attempt. Attempts
    // that enter no statistics and those of a script or a replay do not count.
    bool needsGuidance(const std::string& trainee) const;
    // Begins an attempt. Its record must have the id, the trainee and the start that this returns.
    records::StoredAttempt begin(const records::AttemptInfo&);
    // Working time since the trainee's last rest, according to the store.
    double sinceRest_s(const std::string& trainee) const;
    // Call after the first tick. From then on, the attempt is never discarded.
    void keep() { begun_ = true; }
    // Call when the record and all other files of the folder are complete. Returns the attempt's id.
    // Everything is on disk when it returns.
    const std::string& finish();
    // Sends to the training centre for at most 10 s. Returns the number of entries still unsent.
    std::size_t send();

  private:
    records::Store store_;
    std::optional<records::BackgroundSender> sender_;
    std::string id_;
    bool begun_ = false, finished_ = false;
};

}  // namespace stylet::trainer
