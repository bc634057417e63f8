// Calls with arguments that no sensible program gives: made from the types of a function's parameters and, by
// reflection, of the members of structures. What is promised in memory is there (a buffer is as large as its
// capacity says, a pointer leads to what its type says or is null); everything else is odd.
#pragma once

#include <atomic>
#include <memory>
#include <random>
#include <string_view>
#include <type_traits>
#include <typeindex>
#include <unordered_map>

#include "every_function.h"

#include <openxr/openxr_reflection.h>  // after client.h, which names the platform

namespace mock_test {

template <class T>
concept Complete = requires { sizeof(T); };
// OpenXR's and Vulkan's handles are pointers to types that nobody defines.
template <class T>
concept Handle = std::is_pointer_v<T> && !std::is_function_v<std::remove_pointer_t<T>> &&
                 !std::is_void_v<std::remove_pointer_t<T>> && !Complete<std::remove_pointer_t<T>>;

// The tag of a structure type; none for those without `type` and `next`.
template <class Struct>
inline constexpr XrStructureType kTagOf = XR_TYPE_UNKNOWN;
#define MOCK_TEST_TAG(Struct, tag) \
    template <>                    \
    inline constexpr XrStructureType kTagOf<Struct> = tag;
XR_LIST_STRUCTURE_TYPES(MOCK_TEST_TAG)
#undef MOCK_TEST_TAG

// What all threads share: the ingredients of a session that works, and the last that was made.
struct Surroundings {
    XrInstance instance;
    XrSystemId system;
    XrGraphicsBindingVulkan2KHR binding;
    std::atomic<XrSession> session{XR_NULL_HANDLE};
    std::atomic<bool> waited{false};  // for a frame that was not begun: xrWaitFrame would block, as it should
};

class Hostile {
  public:
    // One of the threads, if there are several, waits for frames.
    Hostile(Surroundings& surroundings, unsigned seed, bool waits_for_frames = true);

    // Some function with hostile arguments. A result that is not listed is a failure.
    void callAny();
    // What a sensible program does next: answers to events, a frame, a session if there is none.
    void behave();

  private:
    void furnish(XrSession session);
    struct Row;
    template <class... Arguments>
    void call(const char* name, XrResult(XRAPI_PTR* function)(Arguments...), Family family,
              std::initializer_list<XrResult> more);
    void follow(std::string_view name, XrResult result);
    template <class T>
    T make();
    template <class T>
    void fill(T& value);
    template <class T>
    void fillMembers(T& value);

    // After a structure was filled with anything: mostly what makes sense, so that calls get further.
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
    void mostly(T& value, std::type_identity_t<T> sensible) {
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
    void trim(std::size_t most, XrResult(XRAPI_PTR* destroy)(H));

    Surroundings& shared_;
    std::mt19937 random_;
    bool waits_for_frames_;
    std::vector<std::pair<const Row*, PFN_xrVoidFunction>> functions_;
    std::vector<std::unique_ptr<std::byte[]>> memory_;
    std::size_t next_memory_ = 0;
    std::unordered_map<std::type_index, std::vector<void*>> handles_;
    std::vector<XrPath> paths_;
};

}  // namespace mock_test
