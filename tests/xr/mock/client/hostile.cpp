#include "tests/xr/mock/client/hostile.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <tuple>

namespace mock_test {

bool isListed(XrResult result, Family family, std::initializer_list<XrResult> more) {
    if (std::find(more.begin(), more.end(), result) != more.end()) return true;
    switch (result) {
        case XR_SUCCESS:
        case XR_ERROR_HANDLE_INVALID:
            return true;
        case XR_ERROR_VALIDATION_FAILURE:
        case XR_ERROR_INSTANCE_LOST:
            return family != Family::destroy;
        case XR_SESSION_LOSS_PENDING:
        case XR_ERROR_SESSION_LOST:
            return family == Family::session;
        default:
            return false;
    }
}

namespace {

constexpr std::size_t kBlockBytes = 65536;  // larger than any output
constexpr std::size_t kBlocks = 256;        // more than any call uses
constexpr std::size_t kElements = 16;       // array size; input counts stay below
constexpr XrStructureType kTags[] = {
#define MOCK_TEST_VALUE(name, value) name,
    XR_LIST_ENUM_XrStructureType(MOCK_TEST_VALUE)
#undef MOCK_TEST_VALUE
};

#define MOCK_TEST_VISIT(member) visit(#member, value.member);
#define MOCK_TEST_MEMBERS(Struct, tag)            \
    template <class Visit>                        \
    void eachMember(Struct& value, Visit visit) { \
        XR_LIST_STRUCT_##Struct(MOCK_TEST_VISIT)  \
    }
XR_LIST_STRUCTURE_TYPES(MOCK_TEST_MEMBERS)
MOCK_TEST_MEMBERS(XrVector2f, )
MOCK_TEST_MEMBERS(XrVector3f, )
MOCK_TEST_MEMBERS(XrQuaternionf, )
MOCK_TEST_MEMBERS(XrPosef, )
MOCK_TEST_MEMBERS(XrFovf, )
MOCK_TEST_MEMBERS(XrOffset2Di, )
MOCK_TEST_MEMBERS(XrExtent2Di, )
MOCK_TEST_MEMBERS(XrExtent2Df, )
MOCK_TEST_MEMBERS(XrRect2Di, )
MOCK_TEST_MEMBERS(XrSwapchainSubImage, )
MOCK_TEST_MEMBERS(XrSystemGraphicsProperties, )
MOCK_TEST_MEMBERS(XrSystemTrackingProperties, )
MOCK_TEST_MEMBERS(XrActionSuggestedBinding, )
MOCK_TEST_MEMBERS(XrActiveActionSet, )
#undef MOCK_TEST_MEMBERS
#undef MOCK_TEST_VISIT

template <class T>
concept Reflected = requires(T value) { eachMember(value, [](const char*, auto&) {}); };
template <class T>
concept VulkanHandle = std::is_same_v<T, VkInstance> || std::is_same_v<T, VkPhysicalDevice> ||
                       std::is_same_v<T, VkDevice> || std::is_same_v<T, VkImage>;

XRAPI_ATTR XrBool32 XRAPI_CALL ignoreMessage(XrDebugUtilsMessageSeverityFlagsEXT,
                                             XrDebugUtilsMessageTypeFlagsEXT,
                                             const XrDebugUtilsMessengerCallbackDataEXT*, void*) {
    return XR_FALSE;
}

const VkInstanceCreateInfo kVulkanInstanceInfo{
    VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, nullptr, 0, nullptr, 0, nullptr, 0, nullptr};
const float kPriority = 1;
const VkDeviceQueueCreateInfo kQueueInfo{
    VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &kPriority};
const VkDeviceCreateInfo kVulkanDeviceInfo{
    VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, nullptr, 0, 1, &kQueueInfo, 0, nullptr, 0, nullptr, nullptr};

}  // namespace

// --- Values ---

template <class T>
T* HostileCaller::newElements(std::size_t count) {
    std::byte* block = memory_[next_memory_++ % kBlocks].get();
    auto* elements = reinterpret_cast<T*>(block);
    std::uninitialized_value_construct_n(elements, std::min(count, kBlockBytes / sizeof(T)));
    return elements;
}

const void* HostileCaller::chain() {
    if (!once(6)) return nullptr;
    auto* link = reinterpret_cast<XrBaseOutStructure*>(newElements<std::byte>(kBlockBytes));
    link->type = kTags[below(std::size(kTags))];
    link->next =
        once(3) ? const_cast<XrBaseOutStructure*>(static_cast<const XrBaseOutStructure*>(chain())) : nullptr;
    return link;
}

const char* HostileCaller::text() {
    static const std::string long_path = "/" + std::string(300, 'a');
    return pick<const char*>({"/user/hand/left", "/user/hand/right", "/user/gamepad", "/a/b",
                              "/interaction_profiles/khr/simple_controller",
                              "/user/hand/left/input/select/click", "/user/hand/right/output/haptic", "",
                              "no", "/A", "/a/", "//", "/..", "capture:", "capture:../../up", "\xff\xfe",
                              "name", long_path.c_str()});
}

template <Handle H>
H HostileCaller::handle() {
    std::vector<void*>& own = handles_[typeid(H)];
    if constexpr (VulkanHandle<H>) {
        return own.empty() || once(8) ? nullptr : static_cast<H>(own.front());
    } else {
        if constexpr (std::is_same_v<H, XrSession>) {
            if (!once(6)) return shared_.session.load();
        }
        switch (below(20)) {
            case 0:
                return XR_NULL_HANDLE;
            case 1:
                return reinterpret_cast<H>(std::uintptr_t{random_()} << below(32));
            case 2:
                return reinterpret_cast<H>(shared_.session.load());  // of another type
            case 3:
                return reinterpret_cast<H>(shared_.instance);
            default:  // most likely the newest, which is probably still valid
                if (own.empty()) return XR_NULL_HANDLE;
                return static_cast<H>(once(2) ? own.back()
                                              : own[below(static_cast<std::uint32_t>(own.size()))]);
        }
    }
}

template <class T>
T HostileCaller::make() {
    if constexpr (Handle<T>) {
        return handle<T>();
    } else if constexpr (std::is_same_v<T, const char*>) {
        return once(12) ? nullptr : text();
    } else if constexpr (std::is_same_v<T, std::uint32_t>) {
        return pick({0U, 1U, 2U, 3U, 16U, 4096U, std::numeric_limits<std::uint32_t>::max()});
    } else if constexpr (std::is_same_v<T, const XrHapticBaseHeader*>) {
        return reinterpret_cast<T>(make<const XrHapticVibration*>());
    } else if constexpr (std::is_same_v<T, XrSwapchainImageBaseHeader*>) {
        return reinterpret_cast<T>(make<XrSwapchainImageVulkanKHR*>());
    } else if constexpr (std::is_pointer_v<T> && Complete<std::remove_pointer_t<T>>) {
        using Element = std::remove_cv_t<std::remove_pointer_t<T>>;
        if (once(12)) return nullptr;
        Element* elements = newElements<Element>(kElements);
        if constexpr (std::is_const_v<std::remove_pointer_t<T>> || kTagOf<Element> != XR_TYPE_UNKNOWN)
            for (std::size_t i = 0; i < 3; ++i)
                fill(elements[i]);
        return elements;
    } else {
        T value{};
        fill(value);
        return value;
    }
}

template <class T>
void HostileCaller::fill(T& value) {
    if constexpr (std::is_enum_v<T>) {
        value = static_cast<T>(pick({0, 1, 2, 3, 4, 5, 100, 1000054000, 0x7ffffffe}));
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {  // flags, system, path, version
        const XrPath path = paths_[below(static_cast<std::uint32_t>(paths_.size()))];
        value = pick<std::uint64_t>(
            {0, 1, 7, ~std::uint64_t{0}, shared_.system, shared_.system, shared_.system, path, path, path});
    } else if constexpr (std::is_same_v<T, std::int64_t>) {  // time, duration
        constexpr std::int64_t kSoon = 1'500'000'000;
        value = pick<std::int64_t>({kSoon, kSoon, kSoon, 0, 1, -1, std::numeric_limits<std::int64_t>::max(),
                                    std::numeric_limits<std::int64_t>::min()});
    } else if constexpr (std::is_integral_v<T>) {
        value = static_cast<T>(pick({0, 1, 2, 3, 16}));
    } else if constexpr (std::is_floating_point_v<T>) {
        using Limits = std::numeric_limits<T>;
        value = pick<T>({0, 0.5F, 1, -1, 90, 1e38F, Limits::quiet_NaN(), -Limits::infinity()});
    } else if constexpr (std::is_same_v<T, timespec>) {
        value = {pick<time_t>({0, 1, -1, std::numeric_limits<time_t>::max()}),
                 pick({0L, -1L, 999'999'999L, 1L << 40})};
    } else if constexpr (std::is_array_v<T> && std::is_same_v<std::remove_extent_t<T>, char>) {
        const std::string name = "n" + std::to_string(below(40));
        std::strcpy(value, pick({name.c_str(), name.c_str(), name.c_str(), "", "UPPER", "a b", "\xff"}));
        if (once(20)) std::memset(value, 'a', sizeof value);  // not terminated
    } else if constexpr (Reflected<T>) {
        fillMembers(value);
        adjust(value);
    } else if constexpr (Handle<T> || (std::is_pointer_v<T> && Complete<std::remove_pointer_t<T>> &&
                                       !std::is_function_v<std::remove_pointer_t<T>>)) {
        value = make<T>();
    }
}

template <class T>
void HostileCaller::fillMembers(T& value) {
    eachMember(value, [&](std::string_view name, auto& member) {
        using Member = std::remove_reference_t<decltype(member)>;
        if constexpr (std::is_same_v<Member, XrStructureType>) {
            member = once(16) ? kTags[below(std::size(kTags))] : kTagOf<T>;
        } else if constexpr (std::is_same_v<Member, const void*> || std::is_same_v<Member, void*>) {
            if (name == "next") member = const_cast<void*>(chain());
        } else if constexpr (!std::is_array_v<Member> || sizeof(Member) < 1000) {
            fill(member);
        }
    });
}

// --- Sensible values ---

void HostileCaller::adjust(XrPosef& pose) {
    usuallySet(pose, kIdentity);
}

void HostileCaller::adjust(XrSwapchainSubImage& image) {
    usuallySet(image.imageRect, {{0, 0}, {16, 16}});
    usuallySet(image.imageArrayIndex, 0);
}

void HostileCaller::adjust(XrSessionCreateInfo& info) {
    usuallySet(info.createFlags, 0);
    usuallySet(info.systemId, shared_.system);
    if (!once(6)) info.next = &shared_.binding;
}

void HostileCaller::adjust(XrSessionBeginInfo& info) {
    usuallySet(info.primaryViewConfigurationType, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO);
}

void HostileCaller::adjust(XrReferenceSpaceCreateInfo& info) {
    usuallySet(info.referenceSpaceType, XR_REFERENCE_SPACE_TYPE_LOCAL);
}

void HostileCaller::adjust(XrSwapchainCreateInfo& info) {
    constexpr std::uint32_t kHuge = std::numeric_limits<std::uint32_t>::max();
    const std::int64_t format = pick<std::int64_t>({VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_D32_SFLOAT, 0, -1});
    info = {info.type, info.next, 0, XR_SWAPCHAIN_USAGE_SAMPLED_BIT, VK_FORMAT_R8G8B8A8_SRGB, 1, 16, 16,
            1,         1,         1};
    switch (below(16)) {
        case 0:
            return void(info.createFlags = pick<XrFlags64>({1, 2, 3, ~XrFlags64{0}}));
        case 1:
            return void(info.usageFlags = pick<XrFlags64>({0, 2, 4, 0x7f, ~XrFlags64{0}}));
        case 2:
            return void(info.format = format);
        case 3:
            return void(info.sampleCount = pick({0U, 2U, kHuge}));
        case 4:
            return void((once(2) ? info.width : info.height) = pick({0U, 1U, 17U, kHuge}));
        case 5:
            return void(info.faceCount = pick({0U, 2U, 6U, kHuge}));
        case 6:
            return void(info.arraySize = pick({0U, 2U, kHuge}));
        case 7:
            return void(info.mipCount = pick({0U, 5U, 6U, kHuge}));
        default:
            return;
    }
}

void HostileCaller::adjust(XrFrameEndInfo& info) {
    usuallySet(info.displayTime, 1'500'000'000);
    usuallySet(info.environmentBlendMode, XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
    auto** layers = newElements<const XrCompositionLayerBaseHeader*>(kElements);
    const auto place = [&]<class Layer>(const Layer* layer) {
        return reinterpret_cast<const XrCompositionLayerBaseHeader*>(layer);
    };
    for (std::size_t i = 0; i < kElements; ++i) {
        switch (below(8)) {
            case 0:
                layers[i] = place(make<const XrCompositionLayerCylinderKHR*>());
                break;
            case 1:
                layers[i] = place(make<const XrCompositionLayerCubeKHR*>());
                break;
            case 2:
            case 3:
                layers[i] = place(make<const XrCompositionLayerQuad*>());
                break;
            default:
                layers[i] = place(make<const XrCompositionLayerProjection*>());
        }
    }
    info.layers = layers;
    info.layerCount = pick({0U, 0U, 0U, 1U, 1U, 2U, 16U});
    if (once(16)) info.layerCount = std::numeric_limits<std::uint32_t>::max(), info.layers = nullptr;
}

void HostileCaller::adjust(XrViewLocateInfo& info) {
    usuallySet(info.viewConfigurationType, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO);
}

void HostileCaller::adjust(XrActionCreateInfo& info) {
    info.actionType =
        pick({XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_FLOAT_INPUT, XR_ACTION_TYPE_VECTOR2F_INPUT,
              XR_ACTION_TYPE_POSE_INPUT, XR_ACTION_TYPE_VIBRATION_OUTPUT, XR_ACTION_TYPE_MAX_ENUM});
    auto* hands = newElements<XrPath>(2);
    hands[0] = paths_[0], hands[1] = paths_[1];
    usuallySet(info.subactionPaths, hands);
    usuallySet(info.countSubactionPaths, below(3));
}

void HostileCaller::adjust(XrInteractionProfileSuggestedBinding& info) {
    usuallySet(info.interactionProfile, paths_[2]);
    usuallySet(info.countSuggestedBindings, 1 + below(3));
}

void HostileCaller::adjust(XrVulkanInstanceCreateInfoKHR& info) {
    usuallySet(info.createFlags, 0);
    info.vulkanAllocator = nullptr;
    info.vulkanCreateInfo = once(3) ? nullptr : &kVulkanInstanceInfo;
    info.pfnGetInstanceProcAddr = once(3) ? nullptr : vkGetInstanceProcAddr;
}

void HostileCaller::adjust(XrVulkanDeviceCreateInfoKHR& info) {
    usuallySet(info.createFlags, 0);
    info.vulkanAllocator = nullptr;
    info.vulkanCreateInfo = once(3) ? nullptr : &kVulkanDeviceInfo;
    info.pfnGetInstanceProcAddr = once(3) ? nullptr : vkGetInstanceProcAddr;
}

void HostileCaller::adjust(XrDebugUtilsMessengerCreateInfoEXT& info) {
    info.userCallback = once(4) ? nullptr : ignoreMessage;
    info.messageSeverities =
        pick<XrFlags64>({XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT, 0, ~XrFlags64{0}});
    usuallySet(info.messageTypes, XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT);
}

// --- Calls ---

struct HostileCaller::Row {
    const char* name;
    void (*call)(HostileCaller&, PFN_xrVoidFunction);
};

template <class... Arguments>
void HostileCaller::call(const char* name, XrResult(XRAPI_PTR* function)(Arguments...), Family family,
                         std::initializer_list<XrResult> more) {
    const std::tuple<Arguments...> arguments{make<Arguments>()...};
    const XrResult result = std::apply(function, arguments);
    EXPECT_TRUE(isListed(result, family, more)) << name << " returned " << result;
    if (XR_SUCCEEDED(result)) std::apply([&](auto... each) { (keepOutput(each), ...); }, arguments);
    trackResult(name, result);
}

template <class T>
void HostileCaller::keepOutput(T argument) {
    if constexpr (std::is_same_v<T, VkInstance*>) {
        if (argument != nullptr && *argument != VK_NULL_HANDLE) vkDestroyInstance(*argument, nullptr);
    } else if constexpr (std::is_same_v<T, VkDevice*>) {
        if (argument != nullptr && *argument != VK_NULL_HANDLE) vkDestroyDevice(*argument, nullptr);
    } else if constexpr (std::is_same_v<T, XrSession*>) {
        shared_.session = *argument;
    } else if constexpr (std::is_pointer_v<T>) {
        using Element = std::remove_pointer_t<T>;
        if constexpr (Handle<Element> && !std::is_const_v<Element> && !VulkanHandle<Element>) {
            if (argument != nullptr) handles_[typeid(Element)].push_back(*argument);
        }
    }
}

// Records whether a waited frame has not begun yet. Another xrWaitFrame would then block.
void HostileCaller::trackResult(std::string_view name, XrResult result) {
    if (name == "xrWaitFrame" && XR_SUCCEEDED(result)) shared_.waited = true;
    if (name == "xrBeginFrame" && (XR_SUCCEEDED(result) || result == XR_ERROR_CALL_ORDER_INVALID))
        shared_.waited = false;
    if ((name == "xrEndSession" || name == "xrDestroySession") && XR_SUCCEEDED(result))
        shared_.waited = false;
}

HostileCaller::HostileCaller(SharedObjects& surroundings, unsigned seed, bool waits_for_frames)
    : shared_(surroundings), random_(seed), waits_for_frames_(waits_for_frames) {
    static const Row kRows[] = {
#define MOCK_TEST_ROW(function, family, ...)                                                     \
    {"xr" #function, [](HostileCaller& hostile, PFN_xrVoidFunction entry) {                      \
         hostile.call("xr" #function, reinterpret_cast<PFN_xr##function>(entry), Family::family, \
                      {__VA_ARGS__});                                                            \
     }},
        MOCK_TEST_EVERY_FUNCTION(MOCK_TEST_ROW)
#undef MOCK_TEST_ROW
    };
    const PFN_xrGetInstanceProcAddr look_up = runtimeEntry();
    for (const Row& row : kRows) {
        PFN_xrVoidFunction entry = nullptr;
        if (look_up(shared_.instance, row.name, &entry) == XR_SUCCESS) functions_.emplace_back(&row, entry);
    }
    for (std::size_t i = 0; i < kBlocks; ++i)
        memory_.push_back(std::make_unique<std::byte[]>(kBlockBytes));
    for (const char* each :
         {"/user/hand/left", "/user/hand/right", "/interaction_profiles/khr/simple_controller",
          "/user/hand/left/input/select/click", "/user/hand/right/input/aim/pose",
          "/user/hand/left/output/haptic", "/interaction_profiles/oculus/touch_controller", "/nobody"}) {
        xrStringToPath(shared_.instance, each, &paths_.emplace_back());
    }
    handles_[typeid(XrInstance)] = {shared_.instance};
    handles_[typeid(VkInstance)] = {shared_.binding.instance};
    handles_[typeid(VkPhysicalDevice)] = {shared_.binding.physicalDevice};
}

template <Handle H>
void HostileCaller::destroySurplus(std::size_t most, XrResult(XRAPI_PTR* destroy)(H)) {
    std::vector<void*>& own = handles_[typeid(H)];
    if (own.size() <= most) return;
    const XrResult result = destroy(static_cast<H>(own.front()));
    EXPECT_TRUE(result == XR_SUCCESS || result == XR_ERROR_HANDLE_INVALID) << result;
    own.erase(own.begin());
}

void HostileCaller::callAny() {
    const auto& [row, entry] = functions_[below(static_cast<std::uint32_t>(functions_.size()))];
    const std::string_view name = row->name;
    if (name == "xrWaitFrame" && (!waits_for_frames_ || shared_.waited)) return;
    // These calls destroy objects that other calls need, or take long.
    const bool rare = name.starts_with("xrDestroy") || name == "xrRequestExitSession" ||
                      name == "xrCreateVulkanInstanceKHR" || name == "xrCreateVulkanDeviceKHR";
    if (rare && !once(10)) return;
    row->call(*this, entry);
    destroySurplus<XrSwapchain>(12, xrDestroySwapchain);
    destroySurplus<XrSpace>(30, xrDestroySpace);
    destroySurplus<XrActionSet>(12, xrDestroyActionSet);
    destroySurplus<XrAction>(40, xrDestroyAction);
}

// Creates a space and attaches an action set to the session.
void HostileCaller::createObjects(XrSession session) {
    const auto keep = [this]<class H>(H handle) { handles_[typeid(H)].push_back(handle); };
    XrSpace space = XR_NULL_HANDLE;
    const XrReferenceSpaceCreateInfo space_info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr,
                                                XR_REFERENCE_SPACE_TYPE_LOCAL, kIdentity};
    if (xrCreateReferenceSpace(session, &space_info, &space) == XR_SUCCESS) keep(space);
    auto set_info = makeStruct<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    const std::string name = "set" + std::to_string(random_());
    std::strcpy(set_info.actionSetName, name.c_str());
    std::strcpy(set_info.localizedActionSetName, name.c_str());
    XrActionSet set = XR_NULL_HANDLE;
    if (xrCreateActionSet(shared_.instance, &set_info, &set) != XR_SUCCESS) return;
    keep(set);
    for (const XrActionType type :
         {XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_FLOAT_INPUT, XR_ACTION_TYPE_VECTOR2F_INPUT,
          XR_ACTION_TYPE_POSE_INPUT, XR_ACTION_TYPE_VIBRATION_OUTPUT}) {
        auto info = makeStruct<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
        std::strcpy(info.actionName, ("a" + std::to_string(type)).c_str());
        std::strcpy(info.localizedActionName, info.actionName);
        info.actionType = type;
        info.countSubactionPaths = 2;
        info.subactionPaths = paths_.data();  // the hands
        XrAction action = XR_NULL_HANDLE;
        if (xrCreateAction(set, &info, &action) == XR_SUCCESS) keep(action);
    }
    const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set};
    xrAttachSessionActionSets(session, &attach);
}

void HostileCaller::callSensibly() {
    auto event = makeStruct<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    while (xrPollEvent(shared_.instance, &event) == XR_SUCCESS) {
        if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
            XrEventDataSessionStateChanged changed;
            std::memcpy(&changed, &event, sizeof changed);
            const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr,
                                          XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
            if (changed.state == XR_SESSION_STATE_READY) xrBeginSession(changed.session, &info);
            if (changed.state == XR_SESSION_STATE_STOPPING)
                xrEndSession(changed.session), shared_.waited = false;
            if (changed.state == XR_SESSION_STATE_EXITING || changed.state == XR_SESSION_STATE_LOSS_PENDING)
                xrDestroySession(changed.session), shared_.waited = false;
        }
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
    }
    const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, &shared_.binding, 0, shared_.system};
    XrSession session = XR_NULL_HANDLE;
    if (xrCreateSession(shared_.instance, &info, &session) == XR_SUCCESS) {
        shared_.session = session;
        shared_.waited = false;
        createObjects(session);
    }
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    if (!shared_.waited) trackResult("xrWaitFrame", xrWaitFrame(shared_.session, nullptr, &state));
    trackResult("xrBeginFrame", xrBeginFrame(shared_.session, nullptr));
    const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO,           nullptr, state.predictedDisplayTime,
                             XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0,       nullptr};
    xrEndFrame(shared_.session, &end);
}

}  // namespace mock_test
