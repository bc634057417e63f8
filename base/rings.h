// Communication between threads: ring buffers for data that must not be lost, snapshots where the latest
// value wins.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace stylet {

// One producer, one consumer. On a full ring push() returns false and counts the drop. Nothing blocks or
// allocates.
template <typename T>
class Ring {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    explicit Ring(std::size_t capacity) : slots_(capacity + 1) {}

    // Producer thread. Wait-free.
    bool push(const T& value) noexcept {
        const std::size_t head = head_.load(std::memory_order_relaxed);
        const std::size_t next = head + 1 == slots_.size() ? 0 : head + 1;
        if (next == tail_.load(std::memory_order_acquire)) {
            dropped_.fetch_add(1, std::memory_order_relaxed);
            return false;
        }
        slots_[head] = value;
        head_.store(next, std::memory_order_release);
        return true;
    }
    // Consumer thread. Wait-free.
    bool pop(T& value) noexcept {
        const std::size_t tail = tail_.load(std::memory_order_relaxed);
        if (tail == head_.load(std::memory_order_acquire)) return false;
        value = slots_[tail];
        tail_.store(tail + 1 == slots_.size() ? 0 : tail + 1, std::memory_order_release);
        return true;
    }
    // Producer thread. True when the consumer has popped everything.
    bool empty() const noexcept {
        return tail_.load(std::memory_order_acquire) == head_.load(std::memory_order_relaxed);
    }
    std::size_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

  private:
    std::vector<T> slots_;
    alignas(64) std::atomic<std::size_t> head_{0};
    alignas(64) std::atomic<std::size_t> tail_{0};
    alignas(64) std::atomic<std::size_t> dropped_{0};
};

// Triple buffer: passes the newest value of one writer to one reader. The value is written and read in
// place, so memory that a T has allocated is reused. Neither side ever waits.
template <typename T>
class Latest {
  public:
    // Writer thread. Wait-free. Write the whole value, then publish it.
    T& draft() noexcept { return slots_[back_]; }
    void publish() noexcept { back_ = middle_.exchange(back_ | kFresh, std::memory_order_acq_rel) & kIndex; }

    // Reader thread. Wait-free. Returns true if a newer value was published since the last call.
    bool update() noexcept {
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

// The same for small values, which are copied.
template <typename T>
class Snapshot {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    // Writer thread. Wait-free.
    void publish(const T& value) noexcept {
        latest_.draft() = value;
        latest_.publish();
    }
    // Reader thread. Wait-free. Returns true if the value is new since the last call.
    bool read(T& value) noexcept {
        const bool fresh = latest_.update();
        value = latest_.front();
        return fresh;
    }

  private:
    Latest<T> latest_;
};

}  // namespace stylet
