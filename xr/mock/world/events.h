// Event queue of an instance. If it overflows, XrEventDataEventsLost replaces the lost events.
#pragma once

#include <cstring>
#include <deque>

#include "scenario/openxr_api.h"

namespace xrmock {

class EventQueue {
  public:
    template <class Event>
    void push(const Event& event) {
        static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
        Entry entry{{}, XR_NULL_HANDLE};
        if constexpr (requires { event.session; }) entry.session = event.session;
        std::memcpy(&entry.data, &event, sizeof event);
        append(entry);
    }
    // Returns false if the queue is empty. After an overflow, XrEventDataEventsLost comes in the place of
    // the lost events.
    bool pop(XrEventDataBuffer& out);
    // Drops the events of a destroyed session.
    void dropEvents(XrSession session);

  private:
    struct Entry {
        XrEventDataBuffer data;
        XrSession session;  // null: an event of the instance
    };
    void append(const Entry& entry);
    std::deque<Entry> entries_;
    unsigned lost_ = 0;
};

}  // namespace xrmock
