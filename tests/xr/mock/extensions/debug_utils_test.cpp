#include <algorithm>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

struct ReceivedMessage {
    XrDebugUtilsMessageSeverityFlagsEXT severity;
    std::string function, message;
    std::vector<std::string> objects, labels;
};

XRAPI_ATTR XrBool32 XRAPI_CALL receiveMessage(XrDebugUtilsMessageSeverityFlagsEXT severity,
                                              XrDebugUtilsMessageTypeFlagsEXT,
                                              const XrDebugUtilsMessengerCallbackDataEXT* data,
                                              void* received) {
    ReceivedMessage entry{severity, data->functionName, data->message, {}, {}};
    for (std::uint32_t i = 0; i < data->objectCount; ++i) {
        entry.objects.emplace_back(data->objects[i].objectName == nullptr ? "" : data->objects[i].objectName);
    }
    for (std::uint32_t i = 0; i < data->sessionLabelCount; ++i) {
        entry.labels.emplace_back(data->sessionLabels[i].labelName);
    }
    static_cast<std::vector<ReceivedMessage>*>(received)->push_back(entry);
    return XR_FALSE;
}

class DebugUtils : public MockTest {
  protected:
    XrDebugUtilsMessengerCreateInfoEXT messengerInfo() {
        return {
            XR_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
            nullptr,
            XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT | XR_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT,
            XR_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
            receiveMessage,
            &received_};
    }
    XrResult tryMessenger(const XrDebugUtilsMessengerCreateInfoEXT& info) {
        return load<PFN_xrCreateDebugUtilsMessengerEXT>(instance_, "xrCreateDebugUtilsMessengerEXT")(
            instance_, &info, &messenger_);
    }
    void insert(const char* name) {
        const XrDebugUtilsLabelEXT label{XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, name};
        EXPECT_EQ(load<PFN_xrSessionInsertDebugUtilsLabelEXT>(instance_, "xrSessionInsertDebugUtilsLabelEXT")(
                      session_, &label),
                  XR_SUCCESS);
    }
    void begin(const char* name) {
        const XrDebugUtilsLabelEXT label{XR_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, name};
        EXPECT_EQ(load<PFN_xrSessionBeginDebugUtilsLabelRegionEXT>(
                      instance_, "xrSessionBeginDebugUtilsLabelRegionEXT")(session_, &label),
                  XR_SUCCESS);
    }
    void end() {
        EXPECT_EQ(load<PFN_xrSessionEndDebugUtilsLabelRegionEXT>(
                      instance_, "xrSessionEndDebugUtilsLabelRegionEXT")(session_),
                  XR_SUCCESS);
    }
    std::vector<ReceivedMessage> received_;
    XrDebugUtilsMessengerEXT messenger_ = XR_NULL_HANDLE;
};

TEST_F(DebugUtils, ReportsTheReasonOfARefusal) {
    startSession();
    ASSERT_EQ(tryMessenger(messengerInfo()), XR_SUCCESS);
    const XrDebugUtilsObjectNameInfoEXT name{XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr,
                                             XR_OBJECT_TYPE_SESSION,
                                             reinterpret_cast<std::uint64_t>(session_), "the session"};
    ASSERT_EQ(
        load<PFN_xrSetDebugUtilsObjectNameEXT>(instance_, "xrSetDebugUtilsObjectNameEXT")(instance_, &name),
        XR_SUCCESS);
    EXPECT_EQ(xrEndSession(session_), XR_ERROR_SESSION_NOT_RUNNING);
    ASSERT_FALSE(received_.empty());
    EXPECT_EQ(received_.back().severity, XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT);
    EXPECT_EQ(received_.back().function, "xrEndSession");
    EXPECT_EQ(received_.back().message, "the session does not run");
    EXPECT_EQ(received_.back().objects, std::vector<std::string>{"the session"});

    ASSERT_EQ(
        load<PFN_xrDestroyDebugUtilsMessengerEXT>(instance_, "xrDestroyDebugUtilsMessengerEXT")(messenger_),
        XR_SUCCESS);
    received_.clear();
    EXPECT_EQ(xrEndSession(session_), XR_ERROR_SESSION_NOT_RUNNING);
    EXPECT_TRUE(received_.empty());
}

TEST_F(DebugUtils, MessagesCarryTheSessionLabels) {
    startSession();
    ASSERT_EQ(tryMessenger(messengerInfo()), XR_SUCCESS);
    const auto labels = [&] {
        received_.clear();
        EXPECT_EQ(xrEndSession(session_), XR_ERROR_SESSION_NOT_RUNNING);
        return received_.empty() ? std::vector<std::string>{"nothing heard"} : received_.front().labels;
    };
    using Labels = std::vector<std::string>;
    begin("outer");
    insert("first");
    EXPECT_EQ(labels(), (Labels{"first", "outer"}));
    insert("second");
    EXPECT_EQ(labels(), (Labels{"second", "outer"}));
    begin("inner");
    EXPECT_EQ(labels(), (Labels{"inner", "outer"}));
    end();
    EXPECT_EQ(labels(), Labels{"outer"});
    end();
    EXPECT_EQ(labels(), Labels{});
}

TEST_F(DebugUtils, ForwardsApplicationMessages) {
    start();
    ASSERT_EQ(tryMessenger(messengerInfo()), XR_SUCCESS);
    const auto submit = load<PFN_xrSubmitDebugUtilsMessageEXT>(instance_, "xrSubmitDebugUtilsMessageEXT");
    auto data =
        makeStruct<XrDebugUtilsMessengerCallbackDataEXT>(XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT);
    data.messageId = "id";
    data.functionName = "here";
    data.message = "look";
    constexpr auto kGeneral = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;
    ASSERT_EQ(submit(instance_, XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT, kGeneral, &data), XR_SUCCESS);
    EXPECT_TRUE(received_.empty());
    ASSERT_EQ(submit(instance_, XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT, kGeneral, &data), XR_SUCCESS);
    ASSERT_FALSE(received_.empty());
    EXPECT_EQ(received_.front().message, "look");
    EXPECT_EQ(received_.front().function, "here");
}

TEST_F(DebugUtils, AChainedMessengerReceivesCreationAndDestruction) {
    const XrDebugUtilsMessengerCreateInfoEXT messenger = [&] {
        auto all = messengerInfo();
        all.messageSeverities |= XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT;
        return all;
    }();
    const auto heardFrom = [&](const char* function) {
        return std::count_if(received_.begin(), received_.end(),
                             [&](const ReceivedMessage& each) { return each.function == function; });
    };
    setVariable("XRMOCK_CLOCK", "imaginary");
    EXPECT_EQ(tryInstance(&messenger), XR_ERROR_RUNTIME_FAILURE);
    EXPECT_GE(heardFrom("xrCreateInstance"), 1);
    setVariable("XRMOCK_CLOCK", "virtual");
    ASSERT_EQ(tryInstance(&messenger), XR_SUCCESS);
    ASSERT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
    instance_ = XR_NULL_HANDLE;
    EXPECT_EQ(heardFrom("xrDestroyInstance"), 1);
}

struct Caller {
    XrInstance instance;
    int calls = 0;
};

XRAPI_ATTR XrBool32 XRAPI_CALL callBack(XrDebugUtilsMessageSeverityFlagsEXT, XrDebugUtilsMessageTypeFlagsEXT,
                                        const XrDebugUtilsMessengerCallbackDataEXT*, void* caller) {
    auto& self = *static_cast<Caller*>(caller);
    XrPath path = XR_NULL_PATH;
    EXPECT_EQ(xrStringToPath(self.instance, "/user/hand/left", &path), XR_SUCCESS);
    ++self.calls;
    return XR_FALSE;
}

TEST_F(DebugUtils, ACallbackMayCallOpenXr) {
    start();
    Caller caller{instance_};
    XrDebugUtilsMessengerCreateInfoEXT info = messengerInfo();
    info.userCallback = callBack;
    info.userData = &caller;
    ASSERT_EQ(tryMessenger(info), XR_SUCCESS);
    EXPECT_EQ(xrGetSystem(instance_, nullptr, nullptr), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_GE(caller.calls, 1);
}

TEST_F(DebugUtils, ValidatesForwardedMessages) {
    start();
    const auto submit = load<PFN_xrSubmitDebugUtilsMessageEXT>(instance_, "xrSubmitDebugUtilsMessageEXT");
    constexpr auto kInfo = XR_DEBUG_UTILS_MESSAGE_SEVERITY_INFO_BIT_EXT;
    constexpr auto kGeneral = XR_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT;
    auto data =
        makeStruct<XrDebugUtilsMessengerCallbackDataEXT>(XR_TYPE_DEBUG_UTILS_MESSENGER_CALLBACK_DATA_EXT);
    data.functionName = "here";
    data.message = "words";
    EXPECT_EQ(submit(instance_, kInfo, kGeneral, &data), XR_SUCCESS);
    EXPECT_EQ(submit(instance_, kInfo | XR_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT, kGeneral, &data),
              XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(submit(instance_, 2, kGeneral, &data), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(submit(instance_, kInfo, XrDebugUtilsMessageTypeFlagsEXT{1} << 20, &data),
              XR_ERROR_VALIDATION_FAILURE);
    auto object = makeStruct<XrDebugUtilsObjectNameInfoEXT>(XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
    data.objectCount = 1;
    EXPECT_EQ(submit(instance_, kInfo, kGeneral, &data), XR_ERROR_VALIDATION_FAILURE);
    data.objects = &object;
    EXPECT_EQ(submit(instance_, kInfo, kGeneral, &data), XR_ERROR_VALIDATION_FAILURE);  // of unknown type
    object.objectType = XR_OBJECT_TYPE_INSTANCE;
    EXPECT_EQ(submit(instance_, kInfo, kGeneral, &data), XR_SUCCESS);
}

TEST_F(DebugUtils, ValidatesItsArguments) {
    startSession();
    XrDebugUtilsMessengerCreateInfoEXT info = messengerInfo();
    info.userCallback = nullptr;
    EXPECT_EQ(tryMessenger(info), XR_ERROR_VALIDATION_FAILURE);
    info = messengerInfo();
    info.messageTypes = 0;
    EXPECT_EQ(tryMessenger(info), XR_ERROR_VALIDATION_FAILURE);
    const XrDebugUtilsObjectNameInfoEXT name{XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr,
                                             XR_OBJECT_TYPE_SPACE, reinterpret_cast<std::uint64_t>(session_),
                                             "no space"};
    EXPECT_EQ(
        load<PFN_xrSetDebugUtilsObjectNameEXT>(instance_, "xrSetDebugUtilsObjectNameEXT")(instance_, &name),
        XR_ERROR_HANDLE_INVALID);
}

}  // namespace
}  // namespace mock_test
