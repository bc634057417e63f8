// Sends finished attempts and deletions from the store to the training centre's PostgreSQL (centre.h).
// Everything is stored locally first and stays queued until the centre has it. An unreachable or slow
// database only causes delay, and sending an attempt twice stores it once.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "app/records/store.h"

namespace stylet::records {

struct SendReport {
    std::size_t sent = 0, erased = 0, left = 0;  // left: entries still queued
    bool reached = false;                        // the database was reached
    std::string error;                           // the most recent error, or empty
};

// Sends every queued entry once, in order. An entry that the centre refuses stays queued with the reason, and
// the next is tried. Without a connection nothing is sent. Only one sender may run at a time: if another one
// is running, nothing is sent and `error` says so. Throws DataError if the store fails.
SendReport sendOutbox(Store&, const std::string& database, const std::function<void(int)>& connected = {});

// A thread that sends whenever the outbox has entries. While the database cannot be reached it backs off: 1
// s, 2 s, 4 s, up to five minutes. Each error is reported once.
class BackgroundSender {
  public:
    BackgroundSender(const std::filesystem::path& store, std::string database,
                     std::function<void(const std::string&)> on_message);
    ~BackgroundSender();  // interrupts sending; the interrupted entry stays queued
    // Sends at once and waits up to `timeout`. Returns the number of entries left. Returns at least 1 if the
    // number is not known in time.
    std::size_t drain(std::chrono::milliseconds timeout);
    BackgroundSender(const BackgroundSender&) = delete;
    BackgroundSender& operator=(const BackgroundSender&) = delete;

  private:
    struct Running;
    std::unique_ptr<Running> running_;
};

}  // namespace stylet::records
