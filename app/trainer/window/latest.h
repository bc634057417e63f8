// The newest of something large on its way from one thread to another: three of it, and neither side ever
// waits.
#pragma once

#include <array>
#include <atomic>

namespace stylet::trainer {

// One writer, one reader. As haptics::Snapshot, but written and read in place: what a T has allocated stays.
template <typename T>
class Latest {
  public:
    // Writer thread. Wait-free. To be written whole, then published.
    T& draft() noexcept { return slots_[back_]; }
    void publish() noexcept { back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex; }

    // Reader thread. Wait-free. True when there is a newer one since the last call.
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
