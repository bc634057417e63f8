// Error checks of OpenXR calls, owning handles, and the OpenXR header with the options that this module
// needs.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <time.h>

#include <vulkan/vulkan.h>
#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "xr/later.h"
#include "xr/xr.h"

namespace stylet::xr {

std::string resultName(XrResult);

[[noreturn]] void fail(XrResult, const char* call, std::string_view meaning);

// Throws XrError "CALL: RESULT: meaning" if the call failed. Qualified success codes pass.
inline void check(XrResult result, const char* call, std::string_view meaning) {
    if (XR_FAILED(result)) fail(result, call, meaning);
}

// Calls an enumerating function twice: call(0, &count, nullptr), then with room for all elements. Each
// element is initialised to `blank` before the second call. Throws XrError.
template <typename Element, typename Call>
std::vector<Element> enumerate(const char* name, std::string_view meaning, const Call& call,
                               const Element& blank = {}) {
    std::uint32_t count = 0;
    check(call(0, &count, nullptr), name, meaning);
    std::vector<Element> elements(count, blank);
    check(call(count, &count, elements.data()), name, meaning);
    return elements;
}

template <typename Handle, XrResult(XRAPI_PTR* kDestroy)(Handle)>
class Owned {
  public:
    Owned() = default;
    ~Owned() { reset(); }
    Owned(Owned&& other) noexcept : handle_(std::exchange(other.handle_, Handle{XR_NULL_HANDLE})) {}
    Owned& operator=(Owned&& other) noexcept {
        if (this != &other) {
            reset();
            handle_ = std::exchange(other.handle_, Handle{XR_NULL_HANDLE});
        }
        return *this;
    }
    Handle get() const { return handle_; }
    // Output pointer for a create call. Destroys the current handle.
    Handle* out() {
        reset();
        return &handle_;
    }
    void reset() {
        if (handle_ != XR_NULL_HANDLE) kDestroy(std::exchange(handle_, Handle{XR_NULL_HANDLE}));
    }

  private:
    Handle handle_{XR_NULL_HANDLE};
};

// A zero-initialised OpenXR structure of the given type.
template <typename Structure>
Structure makeStruct(XrStructureType type) {
    Structure s{};
    s.type = type;
    return s;
}

}  // namespace stylet::xr
