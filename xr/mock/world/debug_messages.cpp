#include "world/debug_messages.h"

#include <string_view>

#include "scenario/names.h"
#include "world/call.h"
#include "world/objects.h"

namespace xrmock {

Instance* findInstance(Object* object) {
    while (object != nullptr && object->parent != nullptr)
        object = object->parent;
    return static_cast<Instance*>(object);
}

std::vector<std::string> sessionLabels(const Object& object) {
    if (object.type != XR_OBJECT_TYPE_SESSION) return {};
    const std::vector<Label>& labels = static_cast<const Session&>(object).labels;
    std::vector<std::string> newest_first;
    for (auto label = labels.rbegin(); label != labels.rend(); ++label)
        newest_first.push_back(label->name);
    return newest_first;
}

void post(Call& call, const Instance& instance, Message message) {
    const std::string_view function = call.function;
    const bool at_either_end = function == "xrCreateInstance" || function == "xrDestroyInstance";
    for (const Listener& listener : instance.listeners) {
        // The messenger chained to xrCreateInstance receives messages only during xrCreateInstance and
        // xrDestroyInstance.
        if (listener.messenger == 0 && !at_either_end) continue;
        if ((listener.severities & message.severity) != 0 && (listener.types & message.type) != 0)
            call.deliveries.push_back({listener.callback, listener.user_data, message});
    }
}

namespace {

void postAboutSubject(Call& call, XrDebugUtilsMessageSeverityFlagsEXT severity,
                      XrDebugUtilsMessageTypeFlagsEXT type, const char* id, const std::string& text) {
    Object* subject = runtime().handles.find(call.subject);
    const Instance* instance = findInstance(subject);
    if (instance == nullptr || instance->listeners.empty()) return;
    const Object* labelled = subject;
    while (labelled->type != XR_OBJECT_TYPE_SESSION && labelled->parent != nullptr)
        labelled = labelled->parent;
    post(call, *instance,
         {severity,
          type,
          id,
          call.function,
          text,
          {{subject->type, subject->handle, subject->debug_name}},
          sessionLabels(*labelled)});
}

}  // namespace

void reportRefusal(Call& call, XrResult result, const std::string& reason) {
    postAboutSubject(call, XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                     XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT, resultName(result).c_str(), reason);
}

void warn(Call& call, const std::string& text) {
    postAboutSubject(call, XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
                     XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT, "xrmock", text);
}

void reportPerformance(Call& call, const std::string& text) {
    postAboutSubject(call, XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT,
                     XR_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT, "xrmock", text);
}

void deliver(std::vector<Delivery>& deliveries) {
    for (const Delivery& delivery : deliveries) {
        const Message& message = delivery.message;
        std::vector<XrDebugUtilsObjectNameInfoEXT> objects;
        for (const NamedObject& object : message.objects) {
            objects.push_back({XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr, object.type, object.handle,
                               object.name.empty() ? nullptr : object.name.c_str()});
        }
        std::vector<XrDebugUtilsLabelEXT> labels;
        for (const std::string& label : message.labels)
            labels.push_back({XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, label.c_str()});
        const XrDebugUtilsMessengerCallbackDataEXT data{XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT,
                                                        nullptr,
                                                        message.id.c_str(),
                                                        message.function.c_str(),
                                                        message.text.c_str(),
                                                        static_cast<std::uint32_t>(objects.size()),
                                                        objects.data(),
                                                        static_cast<std::uint32_t>(labels.size()),
                                                        labels.data()};
        delivery.callback(message.severity, message.type, &data, delivery.user_data);
    }
}

}  // namespace xrmock
