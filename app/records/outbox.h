// To the training centre: what the store has finished is sent to its PostgreSQL (centre.h), what was deleted
// is deleted there. Everything is in the store first and stays until the centre has it: a database that is
// gone, slow or restarted costs time only, and an attempt that was sent twice is there once.
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
    std::size_t sent = 0, erased = 0, left = 0;  // left: of what waited
    bool reached = false;                        // the database
    std::string error;                           // the newest, empty when nothing went wrong
};

// Everything that waits, in order, once. What the centre refuses stays, with its reason, and the next is
// tried; without a connection nothing is. One sender at a time: while another sends there is an error. Throws
// patient::DataError when the store refuses.
SendReport sendOutbox(Store&, const std::string& database, const std::function<void(int)>& connected = {});

// A thread that sends whenever something waits, and while the database cannot be reached ever less often:
// after a second, two, four, at last every five minutes. Its errors are said once each.
class BackgroundSender {
  public:
    BackgroundSender(const std::filesystem::path& store, std::string database,
                     std::function<void(const std::string&)> say);
    ~BackgroundSender();  // interrupts what is on its way, which stays queued
    // Sends at once, and waits so long for it; how much is left, at least 1 where that is not known.
    std::size_t drain(std::chrono::milliseconds at_most);
    BackgroundSender(const BackgroundSender&) = delete;
    BackgroundSender& operator=(const BackgroundSender&) = delete;

  private:
    struct Running;
    std::unique_ptr<Running> running_;
};

}  // namespace stylet::records
