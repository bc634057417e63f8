#include "world/events.h"

namespace xrmock {

namespace {
constexpr std::size_t kCapacity = 64;
}

void EventQueue::append(const Entry& entry) {
    if (entries_.size() >= kCapacity || lost_ > 0) {
        ++lost_;  // later events are lost too until the queue is empty: this keeps the order
        return;
    }
    entries_.push_back(entry);
}

bool EventQueue::pop(XrEventDataBuffer& out) {
    if (!entries_.empty()) {
        out = entries_.front().data;
        entries_.pop_front();
        return true;
    }
    if (lost_ == 0) return false;
    XrEventDataEventsLost event{XR_TYPE_EVENT_DATA_EVENTS_LOST, nullptr, lost_};
    std::memcpy(&out, &event, sizeof event);
    lost_ = 0;
    return true;
}

void EventQueue::dropEvents(XrSession session) {
    std::erase_if(entries_, [&](const Entry& entry) { return entry.session == session; });
}

}  // namespace xrmock
