#include "app/trainer/session/contrast_feed.h"

#include <utility>

namespace stylet::trainer {

namespace {

constexpr std::size_t kMostWaiting = 64;  // two seconds of a moving front; the frame thread is not reading

}  // namespace

void ContrastFeed::give(const patient::Contrast& contrast) {
    if (!contrast.begun() || !painter_.paint(contrast, changes_)) return;
    const std::lock_guard lock(mutex_);
    if (changes_.whole) waiting_.clear();  // a full picture replaces all pending changes
    waiting_.push_back(std::exchange(changes_, {}));
    if (waiting_.size() > kMostWaiting) painter_.reset();
}

bool ContrastFeed::take(patient::ContrastTable& table) {
    taken_.clear();
    {
        const std::lock_guard lock(mutex_);
        std::swap(taken_, waiting_);
    }
    for (const patient::ContrastChanges& changes : taken_)
        patient::apply(changes, table);
    return !taken_.empty();
}

}  // namespace stylet::trainer
