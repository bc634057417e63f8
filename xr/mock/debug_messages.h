// XR_EXT_debug_utils: what is said, and to whom.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "openxr_api.h"

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
    std::vector<NamedObject> objects;
    std::vector<std::string> labels;  // of the sessions among the objects, the newest first
};

// A message on its way to one messenger. It leaves without the lock, so that a callback may call OpenXR.
struct Delivery {
    PFN_xrDebugUtilsMessengerCallbackEXT callback;
    void* user_data;
    Message message;
};

// Queues the message for every messenger of the instance that listens to its severity and type.
void post(Call& call, const Instance& instance, Message message);
// Says why a call is refused; silent when the call named no live object.
void reportRefusal(Call& call, XrResult result, const std::string& reason);
void warn(Call& call, const std::string& text);
void tell(Call& call, const std::string& text);  // about performance
void deliver(std::vector<Delivery>& deliveries);

const Instance* instanceOf(const Object* object);
std::vector<std::string> labelsOf(const Object& object);

}  // namespace xrmock
