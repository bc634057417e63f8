#include "world/call.h"

#include <chrono>
#include <new>
#include <stdexcept>

#include "world/objects.h"

namespace xrmock {

Runtime& runtime() {
    // Never destroyed: other threads may still be inside a call when the process exits.
    static Runtime& shared = *new Runtime;
    return shared;
}

std::int64_t monotonicNs() {
    return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Call::requireNotLost(const Object& object) {
    for (const Object* each = &object; each != nullptr; each = each->parent) {
        if (each->type == XR_OBJECT_TYPE_SESSION) {
            const Loss loss = static_cast<const Session*>(each)->loss;
            require(loss != Loss::lost, XR_ERROR_SESSION_LOST, "the session is lost");
            loss_pending = loss_pending || loss == Loss::pending;
        } else if (each->type == XR_OBJECT_TYPE_INSTANCE) {
            require(static_cast<const Instance*>(each)->conditions.loss != Loss::lost, XR_ERROR_INSTANCE_LOST,
                    "the instance is lost");
        }
    }
}

namespace detail {

namespace {

XrResult run(Call& call, const Invocation& invocation) {
    try {
        const XrResult result = invocation.run(call, invocation.given);
        return XR_SUCCEEDED(result) && call.loss_pending ? XR_SESSION_LOSS_PENDING : result;
    } catch (const Refused& refused) {
        reportRefusal(call, refused.result, refused.reason);
        observeRefusal(call, refused.result, refused.reason);
        return refused.result;
    } catch (const std::bad_alloc&) {
        return XR_ERROR_OUT_OF_MEMORY;
    } catch (const std::exception& error) {
        reportRefusal(call, XR_ERROR_RUNTIME_FAILURE, error.what());
        return XR_ERROR_RUNTIME_FAILURE;
    }
}

}  // namespace

XrResult runGuarded(const char* function, const Invocation& invocation) noexcept {
    try {
        Call call(function);
        const XrResult result = run(call, invocation);
        invocation.finish(call, result, invocation.given);
        call.lock.unlock();
        deliver(call.deliveries);
        return result;
    } catch (const std::bad_alloc&) {
        return XR_ERROR_OUT_OF_MEMORY;
    } catch (...) {
        return XR_ERROR_RUNTIME_FAILURE;
    }
}

}  // namespace detail

}  // namespace xrmock
