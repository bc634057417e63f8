#include "app/records/outbox.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "app/records/centre.h"
#include "app/records/disk_linux.h"
#include "app/records/socket_linux.h"
#include "patient/package/package.h"

namespace stylet::records {

namespace {

constexpr std::chrono::seconds kMinPause{1}, kMaxPause{300};

void sendEntry(Centre& centre, const Store& store, const OutboxEntry& entry) {
    if (entry.kind == OutboxEntry::Kind::erase)
        centre.erase(entry.attempt_id);
    else
        centre.insert(store.attempt(entry.attempt_id), store.files(entry.attempt_id));
}

}  // namespace

SendReport sendOutbox(Store& store, const std::string& database, const std::function<void(int)>& connected) {
    SendReport report;
    const auto sender_lock = FileLock::tryLock(store.folder() / ".sending");
    const std::vector<OutboxEntry> entries = store.outbox();
    report.left = entries.size();
    if (!sender_lock) report.error = "another process is sending";
    if (!sender_lock || entries.empty()) return report;
    try {
        Centre centre(database, connected);
        report.reached = true;
        for (const OutboxEntry& entry : entries) {
            try {
                sendEntry(centre, store, entry);
            } catch (const CentreUnreachable&) {
                report.reached = false;
                throw;
            } catch (const std::runtime_error& e) {
                store.markFailed(entry, e.what());
                report.error = entry.attempt_id + ": " + e.what();
                continue;
            }
            store.markSent(entry);
            --report.left;
            ++(entry.kind == OutboxEntry::Kind::erase ? report.erased : report.sent);
        }
    } catch (const DataError&) {
        throw;
    } catch (const std::runtime_error& e) {
        report.error = e.what();
    }
    return report;
}

struct BackgroundSender::Running {
    std::mutex mutex;
    std::condition_variable wake;
    std::condition_variable answer;
    bool stop = false, ended = false;
    // drain() increments `requested` and waits until `answered` reaches its number. A round answers all
    // requests that were made before it began.
    std::uint64_t requested = 0, serving = 0, answered = 0;
    std::size_t left = 0;  // after the latest round
    int socket = -1;
    std::thread thread;

    // Waits until the time is over or drain() was called. Returns false if the sender must stop.
    bool wait(std::chrono::seconds time) {
        std::unique_lock lock(mutex);
        wake.wait_for(lock, time, [&] { return stop || requested > answered; });
        serving = requested;
        return !stop;
    }
    void finishRound(std::size_t now_left) {
        const std::lock_guard lock(mutex);
        answered = serving;
        left = now_left;
        answer.notify_all();
    }
    void end() {
        const std::lock_guard lock(mutex);
        ended = true;
        answer.notify_all();
    }
    void connected(int now) {
        const std::lock_guard lock(mutex);
        socket = now;
        if (stop && socket >= 0) shutdownSocket(socket);
    }
};

BackgroundSender::BackgroundSender(const std::filesystem::path& folder, std::string database,
                                   std::function<void(const std::string&)> on_message)
    : running_(std::make_unique<Running>()) {
    running_->thread = std::thread([this, folder, database = std::move(database),
                                    on_message = std::move(on_message)] {
        std::string last_message;
        const auto notifyOnce = [&](const std::string& text) {
            if (!text.empty() && text != last_message) on_message(text);
            last_message = text;
        };
        std::chrono::seconds pause = kMinPause;
        std::optional<Store> store;
        try {
            while (running_->wait(pause)) {
                SendReport report;
                try {
                    if (!store) {
                        store.emplace(folder);
                        for (const RecoveredAttempt& cut : store->recovered())
                            on_message(describe(cut));
                    }
                    if (!store->outbox().empty())
                        report =
                            sendOutbox(*store, database, [this](int socket) { running_->connected(socket); });
                    notifyOnce(report.error.empty() ? ""
                                                    : "the training centre: " + report.error +
                                                          "; attempts stay stored here and are sent later");
                } catch (const DataError& e) {  // from the store, such as a full disk
                    notifyOnce(std::string("nothing is sent to the training centre now: ") + e.what());
                    report.left = 1;
                }
                const bool made_progress = report.left == 0 || report.sent + report.erased > 0;
                pause = made_progress ? kMinPause : std::min(2 * pause, kMaxPause);
                running_->finishRound(report.left);
            }
        } catch (const std::exception& e) {
            notifyOnce(std::string("nothing is sent to the training centre any more: ") + e.what());
        }
        running_->end();
    });
}

std::size_t BackgroundSender::drain(std::chrono::milliseconds timeout) {
    std::unique_lock lock(running_->mutex);
    const std::uint64_t my_request = ++running_->requested;
    running_->wake.notify_all();
    const bool answered = running_->answer.wait_for(
        lock, timeout, [&] { return running_->ended || running_->answered >= my_request; });
    return answered && !running_->ended ? running_->left : std::max<std::size_t>(running_->left, 1);
}

BackgroundSender::~BackgroundSender() {
    {
        const std::lock_guard lock(running_->mutex);
        running_->stop = true;
        if (running_->socket >= 0) shutdownSocket(running_->socket);
    }
    running_->wake.notify_all();
    running_->thread.join();
}

}  // namespace stylet::records
