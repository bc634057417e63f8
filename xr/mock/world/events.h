// Event queue of an instance. If it overflows, XrEventDataEventsLost replaces the lost events.
#pragma once

#include <cstring>
#include <deque>

#include "scenario/openxr_api.h"

namespace xrmock {

class EventQueue {
  public:
    template <class Event>
    void push(const Event& event, XrSession session = XR_NULL_HANDLE) {
        static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
        Entry entry{{}, session};
        std::memcpy(&entry.data, &event, sizeof event);
        push(entry);
    }
    // Returns false if the queue is empty. After an overflow, XrEventDataEventsLost comes in the place of
    // the lost events.
    bool pop(XrEventDataBuffer& out);
    // Drops the events of a destroyed session.
    void forget(XrSession session);

  private:
    struct Entry {
        XrEventDataBuffer data;
        XrSession session;
    };
    void push(const Entry& entry);
    std::deque<Entry> entries_;
    unsigned lost_ = 0;
};

}  // namespace xrmock
