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

constexpr std::chrono::seconds kSoon{1}, kAtLeast{300};

void tell(Centre& centre, const Store& store, const OutboxEntry& entry) {
    if (entry.kind == OutboxEntry::Kind::erase)
        centre.erase(entry.what);
    else
        centre.keep(store.attempt(entry.what), store.files(entry.what));
}

}  // namespace

SendReport sendOutbox(Store& store, const std::string& database, const std::function<void(int)>& connected) {
    SendReport report;
    const auto turn = FileLock::tryTake(store.folder() / ".sending");
    const std::vector<OutboxEntry> entries = store.outbox();
    report.left = entries.size();
    if (!turn) report.error = "another process is sending";
    if (!turn || entries.empty()) return report;
    try {
        Centre centre(database, connected);
        report.reached = true;
        for (const OutboxEntry& entry : entries) {
            try {
                tell(centre, store, entry);
            } catch (const Unreachable&) {
                report.reached = false;
                throw;
            } catch (const std::runtime_error& e) {
                store.notTold(entry, e.what());
                report.error = entry.what + ": " + e.what();
                continue;
            }
            store.told(entry);
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
    std::uint64_t asked = 0, serving = 0, answered = 0;  // counts of drain() calls
    std::size_t left = 0;                                // after the latest round
    int socket = -1;
    std::thread thread;

    // Waits until the time is over or drain() was called. Returns false if the sender must stop.
    bool wait(std::chrono::seconds time) {
        std::unique_lock lock(mutex);
        wake.wait_for(lock, time, [&] { return stop || asked > answered; });
        serving = asked;
        return !stop;
    }
    void tried(std::size_t now_left) {
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
        if (stop && socket >= 0) shutDown(socket);
    }
};

BackgroundSender::BackgroundSender(const std::filesystem::path& folder, std::string database,
                                   std::function<void(const std::string&)> say)
    : running_(std::make_unique<Running>()) {
    running_->thread = std::thread([this, folder, database = std::move(database), say = std::move(say)] {
        std::string said;
        const auto sayOnce = [&](const std::string& text) {
            if (!text.empty() && text != said) say(text);
            said = text;
        };
        std::chrono::seconds pause = kSoon;
        std::optional<Store> store;
        const auto round = [&] {
            if (!store) {
                store.emplace(folder);
                for (const Recovered& cut : store->recovered())
                    say(describe(cut));
            }
            SendReport report;
            if (!store->outbox().empty())
                report = sendOutbox(*store, database, [this](int socket) { running_->connected(socket); });
            sayOnce(report.error.empty() ? ""
                                         : "the training centre: " + report.error +
                                               "; attempts stay stored here and are sent later");
            return report;
        };
        try {
            while (running_->wait(pause)) {
                SendReport report;
                try {
                    report = round();
                } catch (const DataError& e) {  // from the store, such as a full disk
                    sayOnce(std::string("nothing is sent to the training centre now: ") + e.what());
                    report.left = 1;
                }
                const bool gets_on = report.left == 0 || report.sent + report.erased > 0;
                pause = gets_on ? kSoon : std::min(2 * pause, kAtLeast);
                running_->tried(report.left);
            }
        } catch (const std::exception& e) {
            sayOnce(std::string("nothing is sent to the training centre any more: ") + e.what());
        }
        running_->end();
    });
}

std::size_t BackgroundSender::drain(std::chrono::milliseconds at_most) {
    std::unique_lock lock(running_->mutex);
    const std::uint64_t mine = ++running_->asked;
    running_->wake.notify_all();
    const bool answered = running_->answer.wait_for(
        lock, at_most, [&] { return running_->ended || running_->answered >= mine; });
    return answered && !running_->ended ? running_->left : std::max<std::size_t>(running_->left, 1);
}

BackgroundSender::~BackgroundSender() {
    {
        const std::lock_guard lock(running_->mutex);
        running_->stop = true;
        if (running_->socket >= 0) shutDown(running_->socket);
    }
    running_->wake.notify_all();
    running_->thread.join();
}

}  // namespace stylet::records
