// The event queue of an instance, with its overflow rule.
#pragma once

#include <cstring>
#include <deque>

#include "openxr_api.h"

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
    // False when there is none. After an overflow, XrEventDataEventsLost stands where the lost ones would
    // have been.
    bool pop(XrEventDataBuffer& out);
    // A destroyed session sends nothing more.
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
