#include <bit>
#include <memory>

#include "api/api.h"
#include "world/capture.h"
#include "world/objects.h"
#include "world/verify.h"

namespace xrmock {

namespace {

const char* checkLabel(const XrDebugUtilsLabelEXT* label) {
    requireStruct(label, XR_TYPE_DEBUG_UTILS_LABEL_EXT);
    requireValid(label->labelName != nullptr, "labelName is null");
    return label->labelName;
}

// An inserted label (not a region) lasts until the next label operation.
void dropInsertedLabel(Session& session) {
    if (!session.labels.empty() && !session.labels.back().region) session.labels.pop_back();
}

std::string textOrEmpty(const char* text) {
    return text == nullptr ? "" : text;
}

}  // namespace

XrResult setDebugUtilsObjectName(Call& call, XrInstance handle, const XrDebugUtilsObjectNameInfoEXT* info) {
    const Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
    requireValid(info->objectType != XR_OBJECT_TYPE_UNKNOWN, "objectType is unknown");
    Object* object = runtime().handles.find(info->objectHandle);
    require(object != nullptr && object->type == info->objectType && findInstance(object) == &instance,
            XR_ERROR_HANDLE_INVALID, "objectHandle is no live handle of its type and instance");
    object->debug_name = textOrEmpty(info->objectName);
    return XR_SUCCESS;
}

XrResult createDebugUtilsMessenger(Call& call, XrInstance handle,
                                   const XrDebugUtilsMessengerCreateInfoEXT* info,
                                   XrDebugUtilsMessengerEXT* out) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    requireValid(out != nullptr, "messenger is null");
    checkMessenger(*info);
    instance.listeners.reserve(instance.listeners.size() + 1);
    const Messenger& messenger = call.create(std::make_unique<Messenger>(instance), &instance);
    instance.listeners.push_back(
        {messenger.handle, info->messageSeverities, info->messageTypes, info->userCallback, info->userData});
    *out = toHandle<XrDebugUtilsMessengerEXT>(messenger);
    return XR_SUCCESS;
}

XrResult submitDebugUtilsMessage(Call& call, XrInstance handle, XrDebugUtilsMessageSeverityFlagsEXT severity,
                                 XrDebugUtilsMessageTypeFlagsEXT types,
                                 const XrDebugUtilsMessengerCallbackDataEXT* data) {
    const Instance& instance = call.live<Instance>(handle);
    requireStruct(data, XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT);
    requireValid(std::has_single_bit(severity) && (severity & ~kAllSeverities) == 0,
                 "messageSeverity is not one known bit");
    requireValid(types != 0 && (types & ~kAllTypes) == 0, "messageTypes is empty or has unknown bits");
    requireValid(data->objectCount == 0 || data->objects != nullptr, "objects is null");
    Message message{severity, types, textOrEmpty(data->messageId), textOrEmpty(data->functionName),
                    textOrEmpty(data->message)};
    for (std::uint32_t i = 0; i < data->objectCount; ++i) {
        const XrDebugUtilsObjectNameInfoEXT& given = data->objects[i];
        requireValid(given.objectType != XR_OBJECT_TYPE_UNKNOWN, "the type of an object is unknown");
        const Object* object = runtime().handles.find(given.objectHandle);
        const bool known = object != nullptr && object->type == given.objectType;
        message.objects.push_back({given.objectType, given.objectHandle,
                                   known ? object->debug_name : textOrEmpty(given.objectName)});
        if (known && message.labels.empty()) message.labels = sessionLabels(*object);
    }
    post(call, instance, std::move(message));
    return XR_SUCCESS;
}

XrResult sessionBeginDebugUtilsLabelRegion(Call& call, XrSession handle, const XrDebugUtilsLabelEXT* label) {
    Session& session = call.live<Session>(handle);
    const char* name = checkLabel(label);
    dropInsertedLabel(session);
    session.labels.push_back({name, true});
    return XR_SUCCESS;
}

XrResult sessionEndDebugUtilsLabelRegion(Call& call, XrSession handle) {
    Session& session = call.live<Session>(handle);
    dropInsertedLabel(session);
    if (!session.labels.empty()) session.labels.pop_back();
    return XR_SUCCESS;
}

XrResult sessionInsertDebugUtilsLabel(Call& call, XrSession handle, const XrDebugUtilsLabelEXT* label) {
    Session& session = call.live<Session>(handle);
    const std::string name = checkLabel(label);
    dropInsertedLabel(session);
    session.labels.push_back({name, false});
    if (session.instance.capture_folder.empty() || !name.starts_with("capture:")) return XR_SUCCESS;
    session.capture_name = captureName(name);
    if (session.capture_name.empty()) warn(call, "no capture: " + name + " has no plain file name");
    return XR_SUCCESS;
}

}  // namespace xrmock
