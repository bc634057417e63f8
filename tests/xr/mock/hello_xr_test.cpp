// Runs Khronos' sample application hello_xr, unmodified, on the mock runtime.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <openxr/openxr.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace {

struct Outcome {
    int exit_status = -1;
    std::string output;
};

std::string makeFolder() {
    std::string folder = (std::filesystem::temp_directory_path() / "hello_xr.XXXXXX").string();
    return mkdtemp(folder.data()) == nullptr ? std::string() : folder;
}

// Runs `body` in a separate process and captures its output. Its stdin stays open, because hello_xr quits
// when its input ends.
template <class Body>
Outcome runInChildProcess(const std::string& folder, Body body) {
    int input[2];
    if (pipe(input) != 0) return {};
    const std::string log = folder + "/log.txt";
    const pid_t child = fork();
    if (child == 0) {
        const int out = open(log.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
        dup2(input[0], STDIN_FILENO);
        dup2(out, STDOUT_FILENO);
        dup2(out, STDERR_FILENO);
        body();
        std::fflush(nullptr);
        _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    close(input[0]);
    close(input[1]);
    std::ostringstream text;
    text << std::ifstream(log).rdbuf();
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text.str()};
}

Outcome runHelloXr(const std::string& folder, const char* graphics) {
    return runInChildProcess(
        folder, [&] { execlp("timeout", "timeout", "120", "hello_xr", "-g", graphics, nullptr); });
}

class HelloXr : public testing::Test {
  protected:
    void SetUp() override {
        if (std::system("command -v hello_xr > /dev/null") != 0)
            GTEST_SKIP() << "hello_xr (package libopenxr-utils) is not installed";
        folder_ = makeFolder();
        ASSERT_FALSE(folder_.empty());
        std::ofstream(folder_ + "/scenario.json") << R"({"version": 1, "exit_after_frames": 300})";
        setenv("XRMOCK_SCENARIO", (folder_ + "/scenario.json").c_str(), 1);
        setenv("XRMOCK_CAPTURE", folder_.c_str(), 1);
    }
    void TearDown() override {
        for (const char* name : {"XRMOCK_SCENARIO", "XRMOCK_CAPTURE", "XR_ENABLE_API_LAYERS",
                                 "XR_CORE_VALIDATION_EXPORT_TYPE", "VK_INSTANCE_LAYERS"}) {
            unsetenv(name);
        }
        if (!folder_.empty()) std::filesystem::remove_all(folder_);
    }
    // The application reaches the focused state, submits 300 frames and exits on its own.
    void expectCompleteRun(const Outcome& outcome) {
        EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
        EXPECT_NE(outcome.output.find("VISIBLE->XR_SESSION_STATE_FOCUSED"), std::string::npos)
            << outcome.output;
        EXPECT_NE(outcome.output.find("IDLE->XR_SESSION_STATE_EXITING"), std::string::npos) << outcome.output;
        EXPECT_NE(frames().find("\"submitted\": 300,"), std::string::npos) << frames();
    }
    static void enableCoreValidation() {
        setenv("XR_ENABLE_API_LAYERS", "XR_APILAYER_LUNARG_core_validation", 1);
        setenv("XR_CORE_VALIDATION_EXPORT_TYPE", "text", 1);
    }
    static bool coreValidationRan(const Outcome& outcome) {
        return outcome.output.find("Core Validation output type: text") != std::string::npos;
    }
    std::string frames() const {
        std::ostringstream text;
        text << std::ifstream(folder_ + "/frames.json").rdbuf();
        return text.str();
    }
    std::string folder_;
};

TEST_F(HelloXr, RunsThreeHundredFramesAndExits) {
    for (const char* graphics : {"Vulkan2", "Vulkan"}) {
        SCOPED_TRACE(graphics);
        expectCompleteRun(runHelloXr(folder_, graphics));
    }
}

TEST_F(HelloXr, PassesCoreValidation) {
    enableCoreValidation();
    for (const char* graphics : {"Vulkan2", "Vulkan"}) {
        SCOPED_TRACE(graphics);
        const Outcome outcome = runHelloXr(folder_, graphics);
        if (!coreValidationRan(outcome)) {
            GTEST_SKIP()
                << "the core_validation layer (package openxr-layer-corevalidation) is not installed";
        }
        expectCompleteRun(outcome);
        EXPECT_EQ(outcome.output.find("VUID"), std::string::npos) << outcome.output;
    }
}

// Checks that the validation layer, which found no errors above, reports a real violation.
TEST_F(HelloXr, CoreValidationDetectsAViolation) {
    enableCoreValidation();
    const Outcome outcome = runInChildProcess(folder_, [] {
        XrInstanceCreateInfo info{};
        info.type = XR_TYPE_INSTANCE_CREATE_INFO;
        std::strcpy(info.applicationInfo.applicationName, "violator");
        info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
        XrInstance instance = XR_NULL_HANDLE;
        if (xrCreateInstance(&info, &instance) != XR_SUCCESS) return;
        const XrSystemGetInfo wrong{XR_TYPE_VIEW, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
        XrSystemId system = XR_NULL_SYSTEM_ID;
        const XrResult result = xrGetSystem(instance, &wrong, &system);
        std::fflush(nullptr);
        _exit(result == XR_ERROR_VALIDATION_FAILURE ? 0 : 1);
    });
    if (!coreValidationRan(outcome))
        GTEST_SKIP() << "the core_validation layer (package openxr-layer-corevalidation) is not installed";
    EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("VUID-XrSystemGetInfo-type-type"), std::string::npos) << outcome.output;
}

TEST_F(HelloXr, PassesVulkanValidation) {
    setenv("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation", 1);
    for (const char* graphics : {"Vulkan2", "Vulkan"}) {
        SCOPED_TRACE(graphics);
        const Outcome outcome = runHelloXr(folder_, graphics);
        if (outcome.output.find("VK_LAYER_KHRONOS_validation") == std::string::npos)
            GTEST_SKIP() << "the Vulkan validation layer (package vulkan-validationlayers) is not installed";
        expectCompleteRun(outcome);
        EXPECT_EQ(outcome.output.find("Validation Error"), std::string::npos) << outcome.output;
        EXPECT_EQ(outcome.output.find("VUID"), std::string::npos) << outcome.output;
    }
}

}  // namespace
