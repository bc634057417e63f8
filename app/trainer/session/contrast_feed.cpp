#include "app/trainer/session/contrast_feed.h"

#include <utility>

namespace stylet::trainer {

namespace {

// Two seconds of a moving front. If more lists wait, the frame thread is not reading.
constexpr std::size_t kMaxWaiting = 64;

}  // namespace

void ContrastFeed::publish(const patient::Contrast& contrast) {
    if (!contrast.begun() || !painter_.paint(contrast, changes_)) return;
    const std::lock_guard lock(mutex_);
    if (changes_.whole) waiting_.clear();  // a full picture replaces all pending changes
    waiting_.push_back(std::exchange(changes_, {}));
    if (waiting_.size() > kMaxWaiting) painter_.reset();
}

bool ContrastFeed::applyTo(patient::ContrastTable& table) {
    popped_.clear();
    {
        const std::lock_guard lock(mutex_);
        std::swap(popped_, waiting_);
    }
    for (const patient::ContrastChanges& changes : popped_)
        patient::apply(changes, table);
    return !popped_.empty();
}

}  // namespace stylet::trainer
