// Triple buffer: passes the newest value of a large type from one thread to another. Neither side ever
// waits.
#pragma once

#include <array>
#include <atomic>

namespace stylet::trainer {

// One writer, one reader. Like Snapshot, but written and read in place: memory that a T has
// allocated is reused.
template <typename T>
class Latest {
  public:
    // Writer thread. Wait-free. Write the whole value, then publish it.
    T& draft() noexcept { return slots_[back_]; }
    void publish() noexcept { back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex; }

    // Reader thread. Wait-free. Returns true if a newer value was published since the last call.
    bool take() noexcept {
        if (!(middle_.load(std::memory_order_relaxed) & kFresh)) return false;
        front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
        return true;
    }
    T& front() noexcept { return slots_[front_]; }
    const T& front() const noexcept { return slots_[front_]; }

  private:
    static constexpr unsigned kFresh = 4, kIndex = 3;
    std::array<T, 3> slots_{};
    alignas(64) std::atomic<unsigned> middle_{1};
    alignas(64) unsigned back_ = 0;
    alignas(64) unsigned front_ = 2;
};

}  // namespace stylet::trainer
