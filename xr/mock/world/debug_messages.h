// XR_EXT_debug_utils: debug messages and their delivery.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenario/openxr_api.h"

namespace xrmock {

class Call;
struct Instance;
struct Object;

struct NamedObject {
    XrObjectType type;
    std::uint64_t handle;
    std::string name;
};

struct Message {
    XrDebugUtilsMessageSeverityFlagsEXT severity;
    XrDebugUtilsMessageTypeFlagsEXT type;
    std::string id;
    std::string function;
    std::string text;
    std::vector<NamedObject> objects{};
    std::vector<std::string> labels{};  // labels of the message's session, newest first
};

// A message queued for one messenger. It is delivered without the lock, so that the callback may call
// OpenXR.
struct Delivery {
    PFN_xrDebugUtilsMessengerCallbackEXT callback;
    void* user_data;
    Message message;
};

// Queues the message for every messenger of the instance that accepts its severity and type.
void post(Call& call, const Instance& instance, Message message);
// Reports why a call is refused. No effect if the call named no live object.
void reportRefusal(Call& call, XrResult result, const std::string& reason);
void warn(Call& call, const std::string& text);
void reportPerformance(Call& call, const std::string& text);  // as a performance message
void deliver(std::vector<Delivery>& deliveries);

Instance* findInstance(Object* object);  // null for null
std::vector<std::string> sessionLabels(const Object& object);

}  // namespace xrmock
