// Makes calls with arguments that no sensible program passes. The arguments are generated from the types of a
// function's parameters and, by reflection, of structure members. Memory is valid: a buffer has the size of
// its capacity, and a pointer is null or points to an object of its type. All other values are arbitrary.
#pragma once

#include <atomic>
#include <memory>
#include <random>
#include <string_view>
#include <type_traits>
#include <typeindex>
#include <unordered_map>

#include "tests/xr/mock/every_function.h"

#include <openxr/openxr_reflection.h>  // after client.h, which selects the platform

namespace mock_test {

template <class T>
concept Complete = requires { sizeof(T); };
// Handles of OpenXR and Vulkan are pointers to undefined types.
template <class T>
concept Handle = std::is_pointer_v<T> && !std::is_function_v<std::remove_pointer_t<T>> &&
                 !std::is_void_v<std::remove_pointer_t<T>> && !Complete<std::remove_pointer_t<T>>;

// The tag of a structure type, or XR_TYPE_UNKNOWN for structures without `type` and `next`.
template <class Struct>
inline constexpr XrStructureType kTagOf = XR_TYPE_UNKNOWN;
#define MOCK_TEST_TAG(Struct, tag) \
    template <>                    \
    inline constexpr XrStructureType kTagOf<Struct> = tag;
XR_LIST_STRUCTURE_TYPES(MOCK_TEST_TAG)
#undef MOCK_TEST_TAG

// Objects shared by all threads: those needed to create a session, and the most recent session.
struct SharedObjects {
    XrInstance instance;
    XrSystemId system;
    XrGraphicsBindingVulkan2KHR binding;
    std::atomic<XrSession> session{XR_NULL_HANDLE};
    std::atomic<bool> waited{false};  // a waited frame has not begun: xrWaitFrame would block
};

class HostileCaller {
  public:
    // With several threads, only one waits for frames.
    HostileCaller(SharedObjects& surroundings, unsigned seed, bool waits_for_frames = true);

    // Calls a random function with hostile arguments. A result that the specification does not list is a
    // failure.
    void callAny();
    // Does what a sensible program does next: reacts to events, runs a frame, or creates a session if there
    // is none.
    void callSensibly();

  private:
    void createObjects(XrSession session);
    struct Row;
    template <class... Arguments>
    void call(const char* name, XrResult(XRAPI_PTR* function)(Arguments...), Family family,
              std::initializer_list<XrResult> more);
    void trackResult(std::string_view name, XrResult result);
    template <class T>
    T make();
    template <class T>
    void fill(T& value);
    template <class T>
    void fillMembers(T& value);

    // Called after a structure was filled at random. Usually restores sensible values, so that calls pass the
    // first checks.
    template <class T>
    void adjust(T&) {}
    void adjust(XrPosef& pose);
    void adjust(XrSwapchainSubImage& image);
    void adjust(XrSessionCreateInfo& info);
    void adjust(XrSessionBeginInfo& info);
    void adjust(XrReferenceSpaceCreateInfo& info);
    void adjust(XrSwapchainCreateInfo& info);
    void adjust(XrFrameEndInfo& info);
    void adjust(XrViewLocateInfo& info);
    void adjust(XrActionCreateInfo& info);
    void adjust(XrInteractionProfileSuggestedBinding& info);
    void adjust(XrVulkanInstanceCreateInfoKHR& info);
    void adjust(XrVulkanDeviceCreateInfoKHR& info);
    void adjust(XrDebugUtilsMessengerCreateInfoEXT& info);

    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
    bool once(std::uint32_t in) { return below(in) == 0; }
    template <class T>
    T pick(std::initializer_list<T> values) {
        return values.begin()[below(static_cast<std::uint32_t>(values.size()))];
    }
    template <class T>
    void usuallySet(T& value, std::type_identity_t<T> sensible) {
        if (!once(6)) value = sensible;
    }
    template <class T>
    T* newElements(std::size_t count);
    const void* chain();
    const char* text();
    template <Handle H>
    H handle();
    template <class T>
    void keepOutput(T argument);
    template <Handle H>
    void destroySurplus(std::size_t most, XrResult(XRAPI_PTR* destroy)(H));

    SharedObjects& shared_;
    std::mt19937 random_;
    bool waits_for_frames_;
    std::vector<std::pair<const Row*, PFN_xrVoidFunction>> functions_;
    std::vector<std::unique_ptr<std::byte[]>> memory_;
    std::size_t next_memory_ = 0;
    std::unordered_map<std::type_index, std::vector<void*>> handles_;
    std::vector<XrPath> paths_;
};

}  // namespace mock_test
