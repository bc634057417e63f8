// One API call: its lock, its start time, and the debug messages to deliver after the lock is released.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "compositor/refused.h"
#include "world/debug_messages.h"
#include "world/handles.h"
#include "world/log.h"

namespace xrmock {

template <class Struct>
void requireStruct(const Struct* given, XrStructureType type) {
    requireValid(given != nullptr, "a required structure is null");
    requireValid(given->type == type, "a structure has the wrong type");
}

// The structure of this type in a next chain, or null.
template <class Struct>
const Struct* findInChain(const void* next, XrStructureType type) {
    for (auto* link = static_cast<const XrBaseInStructure*>(next); link != nullptr; link = link->next)
        if (link->type == type) return reinterpret_cast<const Struct*>(link);
    return nullptr;
}
// The same for a structure that the call fills.
template <class Struct>
Struct* findOutput(void* next, XrStructureType type) {
    return const_cast<Struct*>(findInChain<Struct>(next, type));
}

// Global state of the library, shared by all instances. Guarded by `mutex`.
struct Runtime {
    std::mutex mutex;
    std::condition_variable changed;  // notified when a frame begins or a session ends or is lost
    HandleTable handles;
    std::unique_ptr<Log> log;   // null if logging is off
    std::size_t instances = 0;  // number of live instances, including one being created
    // Live instances that still need a report, on destruction or at process exit.
    std::vector<const Instance*> reported;
    std::uint64_t reports = 0;  // number of reports written
};
Runtime& runtime();

std::int64_t monotonicNs();

class Call {
  public:
    explicit Call(const char* function_name)
        : function(function_name), now_ns(monotonicNs()), lock(runtime().mutex) {}

    // Returns the live object of exactly this type. Refuses the call if there is none, or if its instance
    // or session is lost.
    template <class T, class Handle>
    T& live(Handle handle) {
        T& found = liveOrLost<T>(handle);
        requireNotLost(found);
        return found;
    }
    // Like live(), but also works after a loss. For destruction and function look-up.
    template <class T, class Handle>
    T& liveOrLost(Handle handle) {
        Object* found = runtime().handles.find(handleValue(handle));
        require(found != nullptr && found->type == T::kType, XR_ERROR_HANDLE_INVALID,
                "a handle is not a live handle of its type");
        if (subject == 0) subject = found->handle;
        return static_cast<T&>(*found);
    }
    // Runs `work` without the lock, because it may take long or call back into OpenXR. Objects looked up
    // before may be destroyed afterwards.
    template <class Work>
    auto runUnlocked(Work work) {
        lock.unlock();
        auto result = work();
        lock.lock();
        return result;
    }
    template <class T>
    T& create(std::unique_ptr<T> object, Object* parent) {
        return static_cast<T&>(runtime().handles.add(std::move(object), parent));
    }

    const char* function;
    std::int64_t now_ns;
    std::uint64_t subject = 0;  // the call's first handle: its debug messages refer to this object
    // One of the call's sessions is about to be lost: successes become XR_SESSION_LOSS_PENDING.
    bool loss_pending = false;
    std::vector<Delivery> deliveries;
    std::unique_lock<std::mutex> lock;

  private:
    void requireNotLost(const Object& object);
};

namespace detail {
// Type-erased arguments of guard().
struct Invocation {
    void* given;
    XrResult (*run)(Call&, void*);
    void (*finish)(Call&, XrResult, void*);
};
// Runs the body, converts any exception to a result, calls `finish`, and then delivers the messages without
// the lock.
XrResult runGuarded(const char* function, const Invocation& invocation) noexcept;
}  // namespace detail

// `body(call)` returns the result. `finish(call, result)` runs afterwards under the same lock.
template <class Body, class Finish>
XrResult guard(const char* function, Body body, Finish finish) noexcept {
    std::pair<Body&, Finish&> given{body, finish};
    using Given = decltype(given);
    return detail::runGuarded(
        function,
        {&given, [](Call& call, void* it) { return static_cast<Given*>(it)->first(call); },
         [](Call& call, XrResult result, void* it) { static_cast<Given*>(it)->second(call, result); }});
}

}  // namespace xrmock
