#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "api/api.h"
#include "scenario/names.h"
#include "scenario/profiles.h"
#include "world/capture.h"
#include "world/director.h"
#include "world/objects.h"
#include "world/report.h"
#include "world/two_call.h"
#include "world/verify.h"

namespace xrmock {

namespace {

constexpr std::uint32_t kMaxViewSize = 4096;  // [px]; raised if the headset recommends more

void configure(Instance& instance, std::int64_t now_ns) {
    if (const char* file = std::getenv("XRMOCK_SCENARIO"); file != nullptr && *file != '\0')
        instance.scenario = loadScenario(file);
    instance.conditions.local = {{0, yawOnly(poseAt(instance.scenario.head, 0))}};
    if (const char* clock = std::getenv("XRMOCK_CLOCK"); clock != nullptr && *clock != '\0') {
        const std::string_view name = clock;
        if (name != "real" && name != "virtual") {
            std::fprintf(stderr, "xrmock: XRMOCK_CLOCK: real or virtual expected\n");
            refuse(XR_ERROR_RUNTIME_FAILURE, "XRMOCK_CLOCK is neither real nor virtual");
        }
        instance.clock.is_virtual = name == "virtual";
    }
    if (!instance.clock.is_virtual) instance.clock.origin_ns = now_ns;
    applyInitialRefusals(instance, instance.clock.now(now_ns));
    openLog();
    openControl(instance);
    instance.created_ns = now_ns;
    if (const char* folder = std::getenv("XRMOCK_CAPTURE"); folder != nullptr)
        instance.capture_folder = folder;
}

void checkApplication(const XrApplicationInfo& application) {
    require(isTerminated(application.applicationName) && application.applicationName[0] != '\0',
            XR_ERROR_NAME_INVALID, "applicationName is empty or not terminated");
    require(isTerminated(application.engineName), XR_ERROR_NAME_INVALID, "engineName is not terminated");
    require(XR_VERSION_MAJOR(application.apiVersion) == XR_VERSION_MAJOR(kApiVersion) &&
                XR_VERSION_MINOR(application.apiVersion) <= XR_VERSION_MINOR(kApiVersion),
            XR_ERROR_API_VERSION_UNSUPPORTED, "this runtime offers OpenXR 1.0");
}

// XRMOCK_WITHHOLD lists extensions, separated by spaces. It is an environment variable because extensions
// are enumerated before a scenario is loaded.
bool isWithheld(const std::string& name) {
    const char* withheld = std::getenv("XRMOCK_WITHHOLD");
    std::istringstream names(withheld == nullptr ? "" : withheld);
    const std::istream_iterator<std::string> end;
    return std::find(std::istream_iterator<std::string>(names), end, name) != end;
}

void enableExtensions(const XrInstanceCreateInfo& info, Instance& instance) {
    requireValid(info.enabledExtensionCount == 0 || info.enabledExtensionNames != nullptr,
                 "enabledExtensionNames is null");
    for (std::uint32_t i = 0; i < info.enabledExtensionCount; ++i) {
        const char* name = info.enabledExtensionNames[i];
        requireValid(name != nullptr, "an extension name is null");
        const bool known =
            std::any_of(std::begin(kExtensions), std::end(kExtensions), [&](const ExtensionEntry& each) {
                return std::strcmp(each.name, name) == 0 && !isWithheld(name) &&
                       !isWithheld(std::string("!") + name);
            });
        require(known, XR_ERROR_EXTENSION_NOT_PRESENT, "an extension is not offered");
        instance.extensions.emplace(name);
    }
}

// Reports to the messenger in the next chain of xrCreateInstance. The instance does not exist yet, so the
// message refers to no object.
void reportToCreator(Call& call, const Instance& unborn, const std::string& reason) {
    post(call, unborn,
         {XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT, XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
          "xrmock", call.function, reason});
}

// `buffer` has room for 64 bytes.
XrResult writeName(Call& call, XrInstance handle, const std::string& name, char* buffer) {
    static_assert(XR_MAX_RESULT_STRING_SIZE == XR_MAX_STRUCTURE_NAME_SIZE);
    call.live<Instance>(handle);
    requireValid(buffer != nullptr, "buffer is null");
    std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s", name.c_str());
    return XR_SUCCESS;
}

}  // namespace

Instance::Instance() : Object(kType) {
    ++runtime().instances;
}

Instance::~Instance() {
    --runtime().instances;
    std::erase(runtime().reported, this);
}

XrResult enumerateApiLayerProperties(Call&, std::uint32_t capacity, std::uint32_t* count,
                                     XrApiLayerProperties* properties) {
    constexpr std::array<int, 0> kNone{};  // API layers belong to the loader
    return twoCall(capacity, count, properties, kNone, [](int, XrApiLayerProperties&) {});
}

XrResult enumerateInstanceExtensionProperties(Call&, const char* layer, std::uint32_t capacity,
                                              std::uint32_t* count, XrExtensionProperties* properties) {
    require(layer == nullptr, XR_ERROR_API_LAYER_NOT_PRESENT, "a runtime has no API layers");
    std::vector<ExtensionEntry> offered;
    std::copy_if(std::begin(kExtensions), std::end(kExtensions), std::back_inserter(offered),
                 [](const ExtensionEntry& each) { return !isWithheld(each.name); });
    checkElements(capacity, properties, offered.size(), XR_TYPE_EXTENSION_PROPERTIES);
    return twoCall(capacity, count, properties, offered,
                   [](const ExtensionEntry& extension, XrExtensionProperties& out) {
                       copyText(extension.name, out.extensionName);
                       out.extensionVersion = extension.version;
                   });
}

XrResult createInstance(Call& call, const XrInstanceCreateInfo* info, XrInstance* out) {
    requireStruct(info, XR_TYPE_INSTANCE_CREATE_INFO);
    requireValid(out != nullptr, "instance is null");
    requireValid(info->createFlags == 0, "createFlags must be 0");
    auto instance = std::make_unique<Instance>();
    enableExtensions(*info, *instance);
    const auto* messenger = findInChain<XrDebugUtilsMessengerCreateInfoEXT>(
        info->next, XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    if (messenger != nullptr && instance->extensions.contains(XR_EXT_DEBUG_UTILS_EXTENSION_NAME)) {
        checkMessenger(*messenger);
        instance->listeners.push_back({0, messenger->messageSeverities, messenger->messageTypes,
                                       messenger->userCallback, messenger->userData});
    }
    try {
        checkApplication(info->applicationInfo);
        configure(*instance, call.now_ns);
    } catch (const Refused& refused) {
        reportToCreator(call, *instance, refused.reason);
        throw;
    } catch (const std::runtime_error& error) {  // the message is one line with file and reason
        std::fprintf(stderr, "xrmock: %s\n", error.what());
        reportToCreator(call, *instance, error.what());
        throw;
    }
    instance->application = info->applicationInfo.applicationName;
    runtime().reported.push_back(instance.get());
    reportAtExit();
    *out = toHandle<XrInstance>(call.create(std::move(instance), nullptr));
    return XR_SUCCESS;
}

XrResult destroyInstance(Call& call, XrInstance handle) {
    Instance& instance = call.liveOrLost<Instance>(handle);
    if (!instance.capture_folder.empty()) writeStatistics(instance);
    writeReport(instance);
    const Statistics& counts = instance.statistics;
    post(call, instance,
         {XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT,
          XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
          "xrmock",
          call.function,
          "frames: " + std::to_string(counts.submitted) + " submitted, " + std::to_string(counts.discarded) +
              " discarded, " + std::to_string(counts.missed) + " refreshes missed",
          {{instance.type, instance.handle, instance.debug_name}}});
    runtime().handles.destroy(instance);
    runtime().changed.notify_all();
    return XR_SUCCESS;
}

XrResult getInstanceProperties(Call& call, XrInstance handle, XrInstanceProperties* properties) {
    call.live<Instance>(handle);
    requireStruct(properties, XR_TYPE_INSTANCE_PROPERTIES);
    properties->runtimeVersion = XR_MAKE_VERSION(0, 1, 0);
    copyText("XR Mock", properties->runtimeName);
    return XR_SUCCESS;
}

XrResult pollEvent(Call& call, XrInstance handle, XrEventDataBuffer* event) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(event, XR_TYPE_EVENT_DATA_BUFFER);
    applyDueEvents(instance, instance.clock.now(call.now_ns));
    call.live<Instance>(handle);  // throws if an event has caused its loss
    if (instance.events.pop(*event)) return XR_SUCCESS;
    bool idle = instance.conditions.loss == Loss::pending;
    if (Session* session = findSession(instance)) {
        idle = idle || session->progress.state == XR_SESSION_STATE_IDLE;
        advance(*session, instance.clock.now(call.now_ns), false);
    }
    // Frames advance the virtual time. Advance it here while there are none: otherwise a stopped session
    // would never restart.
    if (idle && instance.clock.is_virtual)
        instance.clock.virtual_now_ns += refreshPeriodNs(instance.scenario);
    return instance.events.pop(*event) ? XR_SUCCESS : XR_EVENT_UNAVAILABLE;
}

XrResult resultToString(Call& call, XrInstance handle, XrResult value, char* buffer) {
    return writeName(call, handle, resultName(value), buffer);
}

XrResult structureTypeToString(Call& call, XrInstance handle, XrStructureType value, char* buffer) {
    return writeName(call, handle, structureTypeName(value), buffer);
}

XrResult stringToPath(Call& call, XrInstance handle, const char* string, XrPath* path) {
    Instance& instance = call.live<Instance>(handle);
    requireValid(string != nullptr && path != nullptr, "an argument is null");
    require(isWellFormedPath({string, strnlen(string, XR_MAX_PATH_LENGTH)}), XR_ERROR_PATH_FORMAT_INVALID,
            "the path is not well formed");
    *path = instance.paths.fromString(string);
    return XR_SUCCESS;
}

XrResult pathToString(Call& call, XrInstance handle, XrPath path, std::uint32_t capacity,
                      std::uint32_t* count, char* buffer) {
    Instance& instance = call.live<Instance>(handle);
    return twoCallString(capacity, count, buffer, pathString(instance, path));
}

XrResult getSystem(Call& call, XrInstance handle, const XrSystemGetInfo* info, XrSystemId* system) {
    call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_SYSTEM_GET_INFO);
    requireValid(system != nullptr, "systemId is null");
    require(info->formFactor == XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY, XR_ERROR_FORM_FACTOR_UNSUPPORTED,
            "only a head-mounted display is offered");
    *system = kSystemId;
    return XR_SUCCESS;
}

XrResult getSystemProperties(Call& call, XrInstance handle, XrSystemId system,
                             XrSystemProperties* properties) {
    const Instance& instance = call.live<Instance>(handle);
    requireStruct(properties, XR_TYPE_SYSTEM_PROPERTIES);
    requireSystem(system);
    properties->systemId = system;
    properties->vendorId = 0;
    copyText(instance.scenario.system_name.c_str(), properties->systemName);
    properties->graphicsProperties = {kMaxImageSize, kMaxImageSize, kMaxLayers};
    properties->trackingProperties = {XR_TRUE, XR_TRUE};
    auto* presence = findOutput<XrSystemUserPresencePropertiesEXT>(
        properties->next, XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT);
    if (presence != nullptr && instance.extensions.contains(XR_EXT_USER_PRESENCE_EXTENSION_NAME))
        presence->supportsUserPresence = XR_TRUE;
    auto* hands = findOutput<XrSystemHandTrackingPropertiesEXT>(properties->next,
                                                                XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT);
    if (hands != nullptr && instance.extensions.contains(XR_EXT_HAND_TRACKING_EXTENSION_NAME))
        hands->supportsHandTracking = instance.scenario.hand_tracking;
    return XR_SUCCESS;
}

XrResult enumerateEnvironmentBlendModes(Call& call, XrInstance handle, XrSystemId system,
                                        XrViewConfigurationType views, std::uint32_t capacity,
                                        std::uint32_t* count, XrEnvironmentBlendMode* modes) {
    const Instance& instance = call.live<Instance>(handle);
    requireSystem(system);
    requireViewConfiguration(views);
    return twoCall(capacity, count, modes, instance.scenario.offers.blend_modes);
}

XrResult enumerateViewConfigurations(Call& call, XrInstance handle, XrSystemId system, std::uint32_t capacity,
                                     std::uint32_t* count, XrViewConfigurationType* types) {
    call.live<Instance>(handle);
    requireSystem(system);
    constexpr std::array kTypes{XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    return twoCall(capacity, count, types, kTypes);
}

XrResult getViewConfigurationProperties(Call& call, XrInstance handle, XrSystemId system,
                                        XrViewConfigurationType views,
                                        XrViewConfigurationProperties* properties) {
    call.live<Instance>(handle);
    requireSystem(system);
    // This result is also used for unknown values: conformance suites before 2025 accept no other.
    require(views == XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
            "only primary stereo is offered");
    requireStruct(properties, XR_TYPE_VIEW_CONFIGURATION_PROPERTIES);
    properties->viewConfigurationType = views;
    properties->fovMutable = XR_FALSE;
    return XR_SUCCESS;
}

XrResult enumerateViewConfigurationViews(Call& call, XrInstance handle, XrSystemId system,
                                         XrViewConfigurationType views, std::uint32_t capacity,
                                         std::uint32_t* count, XrViewConfigurationView* out) {
    const Instance& instance = call.live<Instance>(handle);
    requireSystem(system);
    requireViewConfiguration(views);
    constexpr std::array kEyes{0, 1};
    checkElements(capacity, out, kEyes.size(), XR_TYPE_VIEW_CONFIGURATION_VIEW);
    return twoCall(capacity, count, out, kEyes, [&](int, XrViewConfigurationView& view) {
        view.recommendedImageRectWidth = instance.scenario.width;
        view.recommendedImageRectHeight = instance.scenario.height;
        view.maxImageRectWidth = std::max(instance.scenario.width, kMaxViewSize);
        view.maxImageRectHeight = std::max(instance.scenario.height, kMaxViewSize);
        view.recommendedSwapchainSampleCount = 1;
        view.maxSwapchainSampleCount = kMaxSampleCount;
    });
}

}  // namespace xrmock
