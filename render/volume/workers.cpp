#include "render/volume/workers.h"

#include <algorithm>

#include "base/parallel.h"

namespace stylet::render {

Workers::Workers(int threads) {
    if (threads == 0) threads = processorCount();
    for (int i = 1; i < threads; ++i)
        helpers_.emplace_back([this, i] { runHelper(i); });
}

Workers::~Workers() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& helper : helpers_)
        helper.join();
}

void Workers::runJobs(int thread) {
    for (;;) {
        const std::size_t job = next_.fetch_add(1, std::memory_order_relaxed);
        if (job >= jobs_) return;
        task_.call(task_.work, job, thread);
    }
}

void Workers::runAll(std::size_t jobs, Task task) {
    {
        const std::lock_guard lock(mutex_);
        task_ = task;
        jobs_ = jobs;
        next_.store(0, std::memory_order_relaxed);
        busy_ = helpers_.size();
        ++round_;
    }
    wake_.notify_all();
    runJobs(0);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return busy_ == 0; });
}

void Workers::runHelper(int thread) {
    std::size_t seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [&] { return stop_ || round_ != seen; });
        if (stop_) return;
        seen = round_;
        lock.unlock();
        runJobs(thread);
        lock.lock();
        if (--busy_ == 0) done_.notify_one();
    }
}

}  // namespace stylet::render
