// Khronos' sample application, unchanged, on the mock runtime.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace {

struct Outcome {
    int exit_status = -1;
    std::string output;
};

std::string freshFolder() {
    std::string folder = (std::filesystem::temp_directory_path() / "hello_xr.XXXXXX").string();
    return mkdtemp(folder.data()) == nullptr ? std::string() : folder;
}

// hello_xr ends when its standard input does, so it gets a pipe that stays open.
Outcome runHelloXr(const std::string& folder, const char* graphics = "Vulkan2") {
    int input[2];
    if (pipe(input) != 0) return {};
    const std::string log = folder + "/log.txt";
    const pid_t child = fork();
    if (child == 0) {
        const int out = open(log.c_str(), O_CREAT | O_WRONLY, 0600);
        dup2(input[0], STDIN_FILENO);
        dup2(out, STDOUT_FILENO);
        dup2(out, STDERR_FILENO);
        execlp("timeout", "timeout", "120", "hello_xr", "-g", graphics, nullptr);
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

class HelloXr : public testing::Test {
  protected:
    void SetUp() override {
        if (std::system("command -v hello_xr > /dev/null") != 0) {
            GTEST_SKIP() << "hello_xr (package libopenxr-utils) is not installed";
        }
        folder_ = freshFolder();
        ASSERT_FALSE(folder_.empty());
        std::ofstream(folder_ + "/scenario.json") << R"({"version": 1, "exit_after_frames": 300})";
        setenv("XRMOCK_SCENARIO", (folder_ + "/scenario.json").c_str(), 1);
        setenv("XRMOCK_CAPTURE", folder_.c_str(), 1);
    }
    void TearDown() override {
        for (const char* name : {"XRMOCK_SCENARIO", "XRMOCK_CAPTURE", "XR_ENABLE_API_LAYERS",
                                 "XR_CORE_VALIDATION_EXPORT_TYPE"}) {
            unsetenv(name);
        }
        std::filesystem::remove_all(folder_);
    }
    std::string frames() const {
        std::ostringstream text;
        text << std::ifstream(folder_ + "/frames.json").rdbuf();
        return text.str();
    }
    std::string folder_;
};

TEST_F(HelloXr, RunsThreeHundredFramesAndLeaves) {
    const Outcome outcome = runHelloXr(folder_);
    EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("VISIBLE->XR_SESSION_STATE_FOCUSED"), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find("IDLE->XR_SESSION_STATE_EXITING"), std::string::npos) << outcome.output;
    EXPECT_NE(frames().find("\"submitted\": 300,"), std::string::npos) << frames();
}

TEST_F(HelloXr, BringsItsOwnVulkan) {
    const Outcome outcome = runHelloXr(folder_, "Vulkan");  // XR_KHR_vulkan_enable
    EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
    EXPECT_NE(frames().find("\"submitted\": 300,"), std::string::npos) << frames();
}

TEST_F(HelloXr, PleasesCoreValidation) {
    setenv("XR_ENABLE_API_LAYERS", "XR_APILAYER_LUNARG_core_validation", 1);
    setenv("XR_CORE_VALIDATION_EXPORT_TYPE", "text", 1);
    const Outcome outcome = runHelloXr(folder_);
    if (outcome.output.find("Core Validation output type: text") == std::string::npos) {
        GTEST_SKIP() << "the core_validation layer (package openxr-layer-corevalidation) is not installed";
    }
    EXPECT_EQ(outcome.exit_status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("VUID"), std::string::npos) << outcome.output;
    EXPECT_NE(frames().find("\"submitted\": 300,"), std::string::npos) << frames();
}

}  // namespace
