// One API call: the lock it holds, the time it was made at, and the messages that leave when the lock is
// released.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "debug_messages.h"
#include "handles.h"
#include "log.h"

namespace xrmock {

// Ends a call with an error code. The reason goes to the application's debug messengers.
struct Refused {
    XrResult result;
    std::string reason;
};
[[noreturn]] void refuse(XrResult result, std::string reason);
inline void require(bool fulfilled, XrResult otherwise, const char* reason) {
    if (!fulfilled) refuse(otherwise, reason);
}

template <class Struct>
void requireStruct(const Struct* given, XrStructureType type) {
    require(given != nullptr, XR_ERROR_VALIDATION_FAILURE, "a required structure is null");
    require(given->type == type, XR_ERROR_VALIDATION_FAILURE, "a structure has the wrong type");
}

// The structure of this type in a next chain, or null.
template <class Struct>
const Struct* findInChain(const void* next, XrStructureType type) {
    for (auto* link = static_cast<const XrBaseInStructure*>(next); link != nullptr; link = link->next) {
        if (link->type == type) return reinterpret_cast<const Struct*>(link);
    }
    return nullptr;
}

// Everything the library keeps, shared by all instances. Guarded by `mutex`.
struct Runtime {
    std::mutex mutex;
    std::condition_variable changed;  // a frame was begun, a session stopped or went
    HandleTable handles;
    std::unique_ptr<Log> log;               // null while nothing is logged
    std::size_t instances = 0;              // live ones, and one that is being created
    std::vector<const Instance*> reported;  // live ones: when they go, or when the process exits
    std::uint64_t reports = 0;              // written so far
};
Runtime& runtime();

std::int64_t monotonicNs();

class Call {
  public:
    explicit Call(const char* function_name)
        : function(function_name), now_ns(monotonicNs()), lock(runtime().mutex) {}

    // The live object behind a handle of exactly this type, of an instance and a session that are not lost.
    template <class T, class Handle>
    T& live(Handle handle) {
        T& found = evenLost<T>(handle);
        requireNotLost(found);
        return found;
    }
    // The same for destruction and look-up, which go on after a loss.
    template <class T, class Handle>
    T& evenLost(Handle handle) {
        Object* found = runtime().handles.find(numberOf(handle));
        require(found != nullptr && found->type == T::kType, XR_ERROR_HANDLE_INVALID,
                "a handle is not a live handle of its type");
        if (subject == 0) subject = found->handle;
        return static_cast<T&>(*found);
    }
    // Runs what may take long or call back without the lock. What was looked up before may be gone after.
    template <class Work>
    auto unlocked(Work work) {
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
    std::uint64_t subject = 0;  // the first handle the call named: the object its messages are about
    bool loss_pending = false;  // a session that the call named: every success is XR_SESSION_LOSS_PENDING
    std::vector<Delivery> deliveries;
    std::unique_lock<std::mutex> lock;

  private:
    void requireNotLost(const Object& object);
};

namespace detail {
// What guard() was given, without its type.
struct Invocation {
    void* given;
    XrResult (*run)(Call&, void*);
    void (*finish)(Call&, XrResult, void*);
};
// Runs the body, turns whatever it throws into a result, finishes, then delivers the messages without the
// lock.
XrResult guarded(const char* function, const Invocation& invocation) noexcept;
}  // namespace detail

// `body(call)` gives the result; `finish(call, result)` follows under the same lock.
template <class Body, class Finish>
XrResult guard(const char* function, Body body, Finish finish) noexcept {
    std::pair<Body&, Finish&> given{body, finish};
    using Given = decltype(given);
    return detail::guarded(
        function,
        {&given, [](Call& call, void* it) { return static_cast<Given*>(it)->first(call); },
         [](Call& call, XrResult result, void* it) { static_cast<Given*>(it)->second(call, result); }});
}

}  // namespace xrmock
