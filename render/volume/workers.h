// A small thread pool that lives as long as its owner. Its threads share the jobs of one frame.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>
#include <vector>

namespace stylet::render {

class Workers {
  public:
    // `threads` includes the caller of run(). 0: as many as the machine has.
    explicit Workers(int threads = 0);
    ~Workers();
    Workers(const Workers&) = delete;
    Workers& operator=(const Workers&) = delete;

    int threads() const { return int(helpers_.size()) + 1; }

    // Calls work(job, thread) for every job in [0, jobs), with thread in [0, threads()). Returns when all
    // are done. One caller at a time. `work` must not throw. Allocates nothing.
    template <typename Work>
    void run(std::size_t jobs, const Work& work) {
        const auto call = [](const void* w, std::size_t job, int thread) {
            (*static_cast<const Work*>(w))(job, thread);
        };
        runAll(jobs, {+call, &work});
    }

  private:
    struct Task {
        void (*call)(const void*, std::size_t, int) = nullptr;
        const void* work = nullptr;
    };
    void runAll(std::size_t jobs, Task);
    void runJobs(int thread);
    void runHelper(int thread);

    std::mutex mutex_;
    std::condition_variable wake_, done_;
    Task task_;
    std::atomic<std::size_t> next_{0};
    std::size_t jobs_ = 0, round_ = 0, busy_ = 0;
    bool stop_ = false;
    std::vector<std::thread> helpers_;
};

}  // namespace stylet::render
