#include <cstdlib>
#include <filesystem>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "xr/xr.h"

namespace stylet::xr {
namespace {

// Sets or unsets an environment variable, and restores it on destruction.
class Variable {
  public:
    Variable(const char* name, const char* value) : name_(name) {
        if (const char* before = std::getenv(name)) before_ = before;
        value ? setenv(name, value, 1) : unsetenv(name);
    }
    ~Variable() { before_ ? setenv(name_, before_->c_str(), 1) : unsetenv(name_); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

  private:
    const char* name_;
    std::optional<std::string> before_;
};

TEST(RuntimeSearchPath, TheEnvironmentVariableOverridesAllOtherPaths) {
    const Variable chosen("XR_RUNTIME_JSON", "/opt/runtime.json");
    EXPECT_THAT(runtimeSearchPath(), testing::ElementsAre("/opt/runtime.json"));
}

TEST(RuntimeSearchPath, OrderIsUserSharedSystem) {
    const Variable chosen("XR_RUNTIME_JSON", nullptr), user("XDG_CONFIG_HOME", "/u"),
        shared("XDG_CONFIG_DIRS", "/a:/b");
    EXPECT_THAT(runtimeSearchPath(),
                testing::ElementsAre("/u/openxr/1/active_runtime.json", "/a/openxr/1/active_runtime.json",
                                     "/b/openxr/1/active_runtime.json", "/etc/openxr/1/active_runtime.json"));
}

TEST(RuntimeSearchPath, DefaultsOfTheXdgBaseDirectories) {
    const Variable chosen("XR_RUNTIME_JSON", nullptr), user("XDG_CONFIG_HOME", nullptr),
        shared("XDG_CONFIG_DIRS", nullptr), home("HOME", "/home/ada");
    EXPECT_THAT(runtimeSearchPath(), testing::ElementsAre("/home/ada/.config/openxr/1/active_runtime.json",
                                                          "/etc/xdg/openxr/1/active_runtime.json",
                                                          "/etc/openxr/1/active_runtime.json"));
}

TEST(NoRuntime, TheErrorListsSearchedPathsAndTheRemedy) {
    const Variable chosen("XR_RUNTIME_JSON", "/nowhere/runtime.json"), quiet("XR_LOADER_DEBUG", "none");
    try {
        const Session session("Stylet test");
        FAIL() << "a session without a runtime";
    } catch (const XrError& error) {
        const std::string text = error.what();
        EXPECT_THAT(text, testing::HasSubstr("xrEnumerateInstanceExtensionProperties: XR_ERROR_"));
        EXPECT_THAT(text, testing::HasSubstr("/nowhere/runtime.json"));
        EXPECT_THAT(text, testing::HasSubstr("XR_RUNTIME_JSON"));
        EXPECT_THAT(text, testing::Not(testing::HasSubstr("\n")));
    }
}

}  // namespace
}  // namespace stylet::xr
