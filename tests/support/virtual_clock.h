// A clock for threads that wait for each other. The time stands still while any of them works. When all of
// them sleep, it jumps to the earliest time that one of them waits for. So a loop of several threads runs at
// full speed, and a stall of the machine makes none of them late.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <thread>

#include "haptics/loop/loop.h"

namespace stylet::test {

class VirtualClock {
  public:
    // Time starts once `threads` threads have used the clock. It never starts if one of them ends before
    // that. The thread that creates the clock may read the time but is not one of them.
    explicit VirtualClock(std::size_t threads) : state_(std::make_shared<State>()) {
        state_->expected = threads;
        state_->owner = std::this_thread::get_id();
    }
    // The result must not outlive this object.
    haptics::Clock clock() noexcept {
        return {
            this, [](void* c) noexcept { return static_cast<VirtualClock*>(c)->now_ns(); },
            [](void* c, std::int64_t t_ns) noexcept { static_cast<VirtualClock*>(c)->sleepUntil_ns(t_ns); }};
    }
    std::int64_t now_ns() {
        join();
        const std::lock_guard lock(state_->mutex);
        return state_->now_ns;
    }
    void sleepUntil_ns(std::int64_t t_ns) {
        join();
        std::unique_lock lock(state_->mutex);
        const auto waiting = state_->waiting.insert(t_ns);
        state_->advance();
        state_->advanced.wait(lock, [&] { return state_->now_ns >= t_ns; });
        state_->waiting.erase(waiting);
    }

  private:
    struct State {
        std::mutex mutex;
        std::condition_variable advanced;
        std::thread::id owner;
        std::int64_t now_ns = 1'000'000'000;
        std::size_t expected = 0, joined = 0, members = 0;
        std::multiset<std::int64_t> waiting;

        // The mutex must be locked.
        void advance() {
            if (joined < expected || waiting.empty() || waiting.size() < members) return;
            now_ns = std::max(now_ns, *waiting.begin());
            advanced.notify_all();
        }
    };
    // A thread's membership in a clock. It ends with the thread, or when the thread uses another clock.
    class Membership {
      public:
        ~Membership() { leave(); }
        void join(const std::shared_ptr<State>& state) {
            if (state_ == state) return;
            leave();
            state_ = state;
            const std::lock_guard lock(state->mutex);
            ++state->joined;
            ++state->members;
        }

      private:
        void leave() {
            if (!state_) return;
            const std::lock_guard lock(state_->mutex);
            --state_->members;
            state_->advance();
        }
        std::shared_ptr<State> state_;
    };

    void join() {
        static thread_local Membership membership;
        if (std::this_thread::get_id() != state_->owner) membership.join(state_);
    }

    std::shared_ptr<State> state_;
};

}  // namespace stylet::test
