// If a session cannot be created, the error is one sentence with the reason, and nothing leaks. A session can
// always be ended.
#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

#include "render_loop.h"

namespace stylet::xr {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

class InstanceTest : public SessionTest {
  protected:
    // The error message of creating a session, or empty if that succeeds.
    std::string sentence() {
        try {
            RenderLoop loop;
        } catch (const XrError& error) {
            const std::string text = error.what();
            EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 0);
            return text;
        }
        return "";
    }
    void setInitialRefusal(const std::string& call, const std::string& result) {
        useScenario(R"("events": [{"t_s": 0, "refuse": {"call": ")" + call + R"(", "result": ")" + result +
                    R"("}}])");
    }
};

TEST_F(InstanceTest, TheFactsListGrantedExtensions) {
    RenderLoop loop;
    const RuntimeFacts& facts = loop.session.facts();
    EXPECT_EQ(facts.runtime_name, "XR Mock");
    EXPECT_EQ(facts.runtime_version, "0.1.0");
    EXPECT_EQ(facts.system_name, "XR Mock HMD");
    EXPECT_EQ(facts.width, 64u);
    EXPECT_EQ(facts.height, 48u);
    EXPECT_EQ(facts.extensions.front(), "XR_KHR_vulkan_enable2");
    for (const char* name :
         {"XR_KHR_composition_layer_depth", "XR_KHR_visibility_mask", "XR_EXT_user_presence",
          "XR_EXT_hand_tracking", "XR_EXT_local_floor", "XR_FB_display_refresh_rate",
          "XR_KHR_convert_timespec_time", "XR_EXT_stationary_reference_space"})
        EXPECT_THAT(facts.extensions, Contains(name));
    EXPECT_THAT(loop.session.notes(), testing::IsEmpty());
}

TEST_F(InstanceTest, OnlyTheVulkanExtensionIsRequired) {
    std::string all;
    {
        Session session("Stylet test");
        for (const std::string& name : session.facts().extensions)
            if (name != "XR_KHR_vulkan_enable2") all += name + " ";
    }
    setVariable("XRMOCK_WITHHOLD", all);
    RenderLoop loop;
    // The loader itself offers XR_EXT_debug_utils.
    EXPECT_THAT(loop.session.facts().extensions,
                testing::IsSubsetOf({"XR_KHR_vulkan_enable2", "XR_EXT_debug_utils"}));
    loop.session.setDepthRange(0.1f, 10.0f);
    EXPECT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.frame("nowhere");
    EXPECT_TRUE(loop.session.hiddenArea(0).indices.empty());
}

TEST_F(InstanceTest, AnOfferedButRefusedExtensionIsSkipped) {
    setVariable("XRMOCK_WITHHOLD", "!XR_EXT_local_floor");
    RenderLoop loop;
    EXPECT_THAT(loop.session.facts().extensions, testing::ElementsAre("XR_KHR_vulkan_enable2"));
    EXPECT_THAT(loop.session.notes(), Contains(HasSubstr("refuses an extension that it offers")));
    EXPECT_TRUE(loop.runUntil(SessionPhase::focused));
}

TEST_F(InstanceTest, MissingFeaturesAreReportedInOneSentence) {
    setVariable("XR_LOADER_DEBUG", "none");
    setVariable("XRMOCK_WITHHOLD", "XR_KHR_vulkan_enable2");
    EXPECT_THAT(sentence(), HasSubstr("does not offer XR_KHR_vulkan_enable2"));
    setVariable("XRMOCK_WITHHOLD", "!XR_KHR_vulkan_enable2");
    EXPECT_THAT(sentence(), StartsWith("xrCreateInstance: XR_ERROR_EXTENSION_NOT_PRESENT"));
    setVariable("XRMOCK_WITHHOLD", "");

    setInitialRefusal("xrGetSystem", "XR_ERROR_FORM_FACTOR_UNAVAILABLE");
    EXPECT_EQ(sentence(),
              "xrGetSystem: XR_ERROR_FORM_FACTOR_UNAVAILABLE: runtime \"XR Mock\" has no headset: "
              "connect it and switch it on");
    setInitialRefusal("xrEnumerateViewConfigurationViews", "XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED");
    EXPECT_THAT(sentence(), HasSubstr("does not support stereo"));
    setInitialRefusal("xrGetVulkanGraphicsRequirements2KHR", "XR_ERROR_SYSTEM_INVALID");
    EXPECT_THAT(sentence(), HasSubstr("cannot use Vulkan"));
    setInitialRefusal("xrCreateSession", "XR_ERROR_LIMIT_REACHED");
    EXPECT_THAT(sentence(), HasSubstr("refuses a session: quit other VR programs"));
    useScenario(R"("offers": {"formats": [37, 126]})");  // R8G8B8A8_UNORM, D32_SFLOAT
    EXPECT_EQ(sentence(), "xrEnumerateSwapchainFormats: the runtime offers no 8-bit sRGB colour format");
    setVariable("XR_RUNTIME_JSON", folder_ / "nowhere.json");
    EXPECT_THAT(sentence(), HasSubstr("start the headset's runtime, or set XR_RUNTIME_JSON"));
    // The runtime is available again.
    setVariable("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST);
    useScenario("");
    EXPECT_EQ(sentence(), "");
}

TEST_F(InstanceTest, AFailureOfAnyCallIsReported) {
    for (const char* call :
         {"xrGetInstanceProperties", "xrGetSystemProperties", "xrEnumerateViewConfigurations",
          "xrEnumerateEnvironmentBlendModes", "xrGetVulkanGraphicsDevice2KHR", "xrCreateVulkanInstanceKHR",
          "xrCreateVulkanDeviceKHR", "xrEnumerateReferenceSpaces", "xrCreateActionSet", "xrCreateAction",
          "xrStringToPath", "xrAttachSessionActionSets", "xrCreateActionSpace", "xrEnumerateSwapchainFormats",
          "xrCreateSwapchain", "xrEnumerateSwapchainImages"}) {
        setInitialRefusal(call, "XR_ERROR_RUNTIME_FAILURE");
        EXPECT_THAT(sentence(), StartsWith(call));
    }
    // These calls have a fallback.
    for (const char* call :
         {"xrCreateReferenceSpace", "xrCreateHandTrackerEXT", "xrGetDisplayRefreshRateFB"}) {
        setInitialRefusal(call, "XR_ERROR_RUNTIME_FAILURE");
        EXPECT_EQ(sentence(), "");
    }
}

double measureSeconds(const std::function<void()>& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Ending a session must not wait long for the runtime. The test waits for a call that hangs before the next
// round, because the library must not be unloaded during the call.
TEST_F(InstanceTest, AHangingRuntimeDoesNotBlockTheDestructor) {
    constexpr double kStall_s = 3.0;
    std::size_t destroyed = 0;
    for (const char* call : {"xrRequestExitSession", "xrDestroySession", "xrDestroyInstance"}) {
        useScenario(R"("events": [{"frame": 2, "stall": {"call": ")" + std::string(call) + R"(", "for_s": )" +
                    std::to_string(kStall_s) + "}}]");
        std::optional<Painter> painter;
        auto session = std::make_unique<Session>("Stylet test");
        painter.emplace(*session);
        painter->start();
        while (!session->running())
            session->poll();
        for (int i = 0; i < 4; ++i) {
            session->endFrame(session->beginFrame());
            session->poll();
        }
        const double took_s = measureSeconds([&] { session.reset(); });
        EXPECT_GT(took_s, 0.9) << call;
        EXPECT_LT(took_s, kStall_s) << call << ": the session's end did not wait for the call";
        RecordProperty(call, int(1e3 * took_s));
        ++destroyed;
        for (int i = 0; i < 600 && calls("xrDestroyInstance").size() < destroyed; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        EXPECT_EQ(calls("xrDestroyInstance").size(), destroyed);
    }
}

}  // namespace
}  // namespace stylet::xr
