// Tests the library without a loader: its exports and the negotiation with loaders.
#include <dlfcn.h>
#include <elf.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "xr/mock/scenario/loader_interface.h"

namespace mock_test {
namespace {

class Negotiation : public testing::Test {
  protected:
    void SetUp() override {
        const char* manifest = std::getenv("XR_RUNTIME_JSON");
        ASSERT_NE(manifest, nullptr);
        path_ = std::filesystem::path(manifest).replace_filename("libxrmock.so");
        library_ = dlopen(path_.c_str(), RTLD_NOW | RTLD_LOCAL);
        ASSERT_NE(library_, nullptr) << dlerror();
        negotiate_ =
            reinterpret_cast<decltype(negotiate_)>(dlsym(library_, "xrNegotiateLoaderRuntimeInterface"));
        ASSERT_NE(negotiate_, nullptr);
    }
    void TearDown() override {
        if (library_ != nullptr) dlclose(library_);
    }
    XrNegotiateLoaderInfo loader_{XR_LOADER_INTERFACE_STRUCT_LOADER_INFO,
                                  kLoaderStructVersion,
                                  sizeof(XrNegotiateLoaderInfo),
                                  1,
                                  1,
                                  XR_MAKE_VERSION(1, 0, 0),
                                  XR_MAKE_VERSION(1, 0x3ff, 0xfff)};
    XrNegotiateRuntimeRequest request_{XR_LOADER_INTERFACE_STRUCT_RUNTIME_REQUEST,
                                       kLoaderStructVersion,
                                       sizeof(XrNegotiateRuntimeRequest),
                                       0,
                                       0,
                                       nullptr};
    decltype(&xrNegotiateLoaderRuntimeInterface) negotiate_ = nullptr;
    void* library_ = nullptr;
    std::filesystem::path path_;
};

// The defined names in the dynamic symbol table.
std::vector<std::string> exportedNames(const std::filesystem::path& library) {
    std::ifstream file(library, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const auto at = [&](std::size_t offset) { return bytes.data() + offset; };
    Elf64_Ehdr header;
    std::memcpy(&header, at(0), sizeof header);
    std::vector<Elf64_Shdr> sections(header.e_shnum);
    std::memcpy(sections.data(), at(header.e_shoff), sections.size() * sizeof(Elf64_Shdr));
    std::vector<std::string> names;
    for (const Elf64_Shdr& section : sections) {
        if (section.sh_type != SHT_DYNSYM) continue;
        for (std::size_t offset = 0; offset < section.sh_size; offset += sizeof(Elf64_Sym)) {
            Elf64_Sym symbol;
            std::memcpy(&symbol, at(section.sh_offset + offset), sizeof symbol);
            const bool exported = symbol.st_shndx != SHN_UNDEF && symbol.st_shndx != SHN_ABS;
            if (exported) names.emplace_back(at(sections[section.sh_link].sh_offset + symbol.st_name));
        }
    }
    return names;
}

TEST_F(Negotiation, ExportsNothingElse) {
    EXPECT_EQ(exportedNames(path_), std::vector<std::string>{"xrNegotiateLoaderRuntimeInterface"});
    EXPECT_EQ(dlsym(library_, "xrGetInstanceProcAddr"), nullptr);
}

TEST_F(Negotiation, AgreesWithLoadersOfOneDotZeroAndOneDotOne) {
    ASSERT_EQ(negotiate_(&loader_, &request_), XR_SUCCESS);
    EXPECT_EQ(request_.runtimeInterfaceVersion, 1U);
    EXPECT_EQ(XR_VERSION_MAJOR(request_.runtimeApiVersion), 1U);
    EXPECT_EQ(XR_VERSION_MINOR(request_.runtimeApiVersion), 0U);
    for (const XrVersion newest : {XR_MAKE_VERSION(1, 0, 0xfff), XR_MAKE_VERSION(1, 0, 0),
                                   XR_MAKE_VERSION(1, 1, 0xfff), XR_MAKE_VERSION(2, 0, 0)}) {
        loader_.maxApiVersion = newest;
        EXPECT_EQ(negotiate_(&loader_, &request_), XR_SUCCESS);
    }
    loader_.maxInterfaceVersion = 7;
    ASSERT_EQ(negotiate_(&loader_, &request_), XR_SUCCESS);
    EXPECT_EQ(request_.runtimeInterfaceVersion, 1U);
}

TEST_F(Negotiation, RefusesInvalidLoaders) {
    const auto good_loader = loader_;
    const auto good_request = request_;
    EXPECT_EQ(negotiate_(nullptr, &request_), XR_ERROR_INITIALIZATION_FAILED);
    EXPECT_EQ(negotiate_(&loader_, nullptr), XR_ERROR_INITIALIZATION_FAILED);
    loader_.structSize -= 1;
    EXPECT_EQ(negotiate_(&loader_, &request_), XR_ERROR_INITIALIZATION_FAILED);
    loader_ = good_loader;
    loader_.minInterfaceVersion = loader_.maxInterfaceVersion = 2;
    EXPECT_EQ(negotiate_(&loader_, &request_), XR_ERROR_INITIALIZATION_FAILED);
    loader_ = good_loader;
    loader_.minApiVersion = XR_MAKE_VERSION(2, 0, 0);
    EXPECT_EQ(negotiate_(&loader_, &request_), XR_ERROR_INITIALIZATION_FAILED);
    loader_ = good_loader;
    request_.structVersion = 2;
    EXPECT_EQ(negotiate_(&loader_, &request_), XR_ERROR_INITIALIZATION_FAILED);
    request_ = good_request;
    EXPECT_EQ(negotiate_(&loader_, &request_), XR_SUCCESS);
}

TEST_F(Negotiation, InstancesAreIndependent) {
    ASSERT_EQ(negotiate_(&loader_, &request_), XR_SUCCESS);
    const auto function = [&](XrInstance instance, const char* name) {
        PFN_xrVoidFunction found = nullptr;
        EXPECT_EQ(request_.getInstanceProcAddr(instance, name, &found), XR_SUCCESS) << name;
        return found;
    };
    const auto create = reinterpret_cast<PFN_xrCreateInstance>(function(XR_NULL_HANDLE, "xrCreateInstance"));
    const char* debug_utils = XR_EXT_DEBUG_UTILS_EXTENSION_NAME;
    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strcpy(info.applicationInfo.applicationName, "twice");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = 1;
    info.enabledExtensionNames = &debug_utils;
    XrInstance one = XR_NULL_HANDLE, other = XR_NULL_HANDLE;
    ASSERT_EQ(create(&info, &one), XR_SUCCESS);
    ASSERT_EQ(create(&info, &other), XR_SUCCESS);

    const auto create_set = reinterpret_cast<PFN_xrCreateActionSet>(function(one, "xrCreateActionSet"));
    XrActionSetCreateInfo set_info{};
    set_info.type = XR_TYPE_ACTION_SET_CREATE_INFO;
    std::strcpy(set_info.actionSetName, "same_name");
    std::strcpy(set_info.localizedActionSetName, "Same name");
    XrActionSet sets[2] = {};
    EXPECT_EQ(create_set(one, &set_info, &sets[0]), XR_SUCCESS);
    EXPECT_EQ(create_set(other, &set_info, &sets[1]), XR_SUCCESS);
    const auto name =
        reinterpret_cast<PFN_xrSetDebugUtilsObjectNameEXT>(function(one, "xrSetDebugUtilsObjectNameEXT"));
    const XrDebugUtilsObjectNameInfoEXT name_info{XR_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr,
                                                  XR_OBJECT_TYPE_ACTION_SET,
                                                  reinterpret_cast<std::uint64_t>(sets[1]), "the other's"};
    EXPECT_EQ(name(one, &name_info), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(name(other, &name_info), XR_SUCCESS);
    const auto to_path = reinterpret_cast<PFN_xrStringToPath>(function(one, "xrStringToPath"));
    const auto to_string = reinterpret_cast<PFN_xrPathToString>(function(one, "xrPathToString"));
    XrPath path = XR_NULL_PATH;
    ASSERT_EQ(to_path(one, "/known/to/one", &path), XR_SUCCESS);
    std::uint32_t count = 0;
    EXPECT_EQ(to_string(one, path, 0, &count, nullptr), XR_SUCCESS);
    EXPECT_EQ(to_string(other, path, 0, &count, nullptr), XR_ERROR_PATH_INVALID);

    const auto destroy = reinterpret_cast<PFN_xrDestroyInstance>(function(one, "xrDestroyInstance"));
    const auto destroy_set = reinterpret_cast<PFN_xrDestroyActionSet>(function(one, "xrDestroyActionSet"));
    EXPECT_EQ(destroy(one), XR_SUCCESS);
    EXPECT_EQ(destroy_set(sets[0]), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(destroy_set(sets[1]), XR_SUCCESS);
    EXPECT_EQ(destroy(other), XR_SUCCESS);
}

TEST_F(Negotiation, EveryCoreFunctionIsAvailable) {
    ASSERT_EQ(negotiate_(&loader_, &request_), XR_SUCCESS);
    PFN_xrVoidFunction function = nullptr;
    EXPECT_EQ(request_.getInstanceProcAddr(XR_NULL_HANDLE, "xrDestroyInstance", &function),
              XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(function, nullptr);
    ASSERT_EQ(request_.getInstanceProcAddr(XR_NULL_HANDLE, "xrCreateInstance", &function), XR_SUCCESS);
    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::string("direct").copy(info.applicationInfo.applicationName, 6);
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    XrInstance instance = XR_NULL_HANDLE;
    const auto create = reinterpret_cast<PFN_xrCreateInstance>(function);
    ASSERT_EQ(create(&info, &instance), XR_SUCCESS);
    const char* const names[] = {"xrGetInstanceProcAddr",
                                 "xrEnumerateApiLayerProperties",
                                 "xrEnumerateInstanceExtensionProperties",
                                 "xrCreateInstance",
                                 "xrDestroyInstance",
                                 "xrGetInstanceProperties",
                                 "xrPollEvent",
                                 "xrResultToString",
                                 "xrStructureTypeToString",
                                 "xrGetSystem",
                                 "xrGetSystemProperties",
                                 "xrEnumerateEnvironmentBlendModes",
                                 "xrCreateSession",
                                 "xrDestroySession",
                                 "xrEnumerateReferenceSpaces",
                                 "xrCreateReferenceSpace",
                                 "xrGetReferenceSpaceBoundsRect",
                                 "xrCreateActionSpace",
                                 "xrLocateSpace",
                                 "xrDestroySpace",
                                 "xrEnumerateViewConfigurations",
                                 "xrGetViewConfigurationProperties",
                                 "xrEnumerateViewConfigurationViews",
                                 "xrEnumerateSwapchainFormats",
                                 "xrCreateSwapchain",
                                 "xrDestroySwapchain",
                                 "xrEnumerateSwapchainImages",
                                 "xrAcquireSwapchainImage",
                                 "xrWaitSwapchainImage",
                                 "xrReleaseSwapchainImage",
                                 "xrBeginSession",
                                 "xrEndSession",
                                 "xrRequestExitSession",
                                 "xrWaitFrame",
                                 "xrBeginFrame",
                                 "xrEndFrame",
                                 "xrLocateViews",
                                 "xrStringToPath",
                                 "xrPathToString",
                                 "xrCreateActionSet",
                                 "xrDestroyActionSet",
                                 "xrCreateAction",
                                 "xrDestroyAction",
                                 "xrSuggestInteractionProfileBindings",
                                 "xrAttachSessionActionSets",
                                 "xrGetCurrentInteractionProfile",
                                 "xrGetActionStateBoolean",
                                 "xrGetActionStateFloat",
                                 "xrGetActionStateVector2f",
                                 "xrGetActionStatePose",
                                 "xrSyncActions",
                                 "xrEnumerateBoundSourcesForAction",
                                 "xrGetInputSourceLocalizedName",
                                 "xrApplyHapticFeedback",
                                 "xrStopHapticFeedback"};
    for (const char* name : names) {
        EXPECT_EQ(request_.getInstanceProcAddr(instance, name, &function), XR_SUCCESS) << name;
        EXPECT_NE(function, nullptr) << name;
    }
    // No loader refuses a 1.1 client or a second instance here, so the runtime itself must decide.
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 1, 0);
    XrInstance other = XR_NULL_HANDLE;
    EXPECT_EQ(create(&info, &other), XR_ERROR_API_VERSION_UNSUPPORTED);
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 99);
    ASSERT_EQ(create(&info, &other), XR_SUCCESS);
    EXPECT_NE(instance, other);
    ASSERT_EQ(request_.getInstanceProcAddr(instance, "xrDestroyInstance", &function), XR_SUCCESS);
    const auto destroy = reinterpret_cast<PFN_xrDestroyInstance>(function);
    EXPECT_EQ(destroy(XR_NULL_HANDLE), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(destroy(reinterpret_cast<XrInstance>(~std::uintptr_t{0})), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(destroy(instance), XR_SUCCESS);
    EXPECT_EQ(destroy(instance), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(destroy(other), XR_SUCCESS);
    info.createFlags = 1;
    EXPECT_EQ(create(&info, &other), XR_ERROR_VALIDATION_FAILURE);
    info.createFlags = 0;
    info.applicationInfo.applicationName[0] = '\0';
    EXPECT_EQ(create(&info, &other), XR_ERROR_NAME_INVALID);
}

}  // namespace
}  // namespace mock_test
