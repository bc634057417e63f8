// Calls the mock OpenXR runtime directly, without a loader, so that a fuzzer can create any number of
// instances.
#pragma once

#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "xr/mock/scenario/loader_interface.h"

namespace mock_fuzz {

inline PFN_xrVoidFunction function(XrInstance instance, const char* name) {
    static const PFN_xrGetInstanceProcAddr get = [] {
        void* library = dlopen(STYLET_MOCK_LIBRARY, RTLD_NOW);
        const auto negotiate = reinterpret_cast<decltype(&xrNegotiateLoaderRuntimeInterface)>(
            library == nullptr ? nullptr : dlsym(library, "xrNegotiateLoaderRuntimeInterface"));
        if (negotiate == nullptr) std::abort();
        const XrNegotiateLoaderInfo loader{XR_LOADER_INTERFACE_STRUCT_LOADER_INFO,
                                           kLoaderStructVersion,
                                           sizeof(XrNegotiateLoaderInfo),
                                           1,
                                           kLoaderInterfaceVersion,
                                           XR_MAKE_VERSION(1, 0, 0),
                                           XR_MAKE_VERSION(1, 0x3ff, 0xfff)};
        XrNegotiateRuntimeRequest request{};
        request.structType = XR_LOADER_INTERFACE_STRUCT_RUNTIME_REQUEST;
        request.structVersion = kLoaderStructVersion;
        request.structSize = sizeof request;
        if (negotiate(&loader, &request) != XR_SUCCESS) std::abort();
        return request.getInstanceProcAddr;
    }();
    PFN_xrVoidFunction found = nullptr;
    if (get(instance, name, &found) != XR_SUCCESS) std::abort();
    return found;
}

// Uses the current environment variables. Hides the runtime's messages on stderr.
inline XrResult createInstance(XrInstance* instance) {
    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strcpy(info.applicationInfo.applicationName, "fuzz");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    const int shown = dup(STDERR_FILENO), nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDERR_FILENO);
    const XrResult result =
        reinterpret_cast<PFN_xrCreateInstance>(function(XR_NULL_HANDLE, "xrCreateInstance"))(&info, instance);
    dup2(shown, STDERR_FILENO);
    close(shown);
    close(nowhere);
    return result;
}

inline void destroyInstance(XrInstance instance) {
    const int shown = dup(STDERR_FILENO), nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDERR_FILENO);  // hides the reports of failed assertions
    reinterpret_cast<PFN_xrDestroyInstance>(function(instance, "xrDestroyInstance"))(instance);
    dup2(shown, STDERR_FILENO);
    close(shown);
    close(nowhere);
}

// Each call advances the virtual clock by one refresh and processes the events that are due.
inline XrResult poll(XrInstance instance) {
    XrEventDataBuffer event{};
    event.type = XR_TYPE_EVENT_DATA_BUFFER;
    return reinterpret_cast<PFN_xrPollEvent>(function(instance, "xrPollEvent"))(instance, &event);
}

// Starts the runtime with the scenario and polls four times. Aborts unless the runtime accepts the scenario
// or fails xrCreateInstance with XR_ERROR_RUNTIME_FAILURE.
inline void play(const std::filesystem::path& scenario) {
    setenv("XRMOCK_SCENARIO", scenario.c_str(), 1);
    XrInstance instance = XR_NULL_HANDLE;
    const XrResult result = createInstance(&instance);
    if (result == XR_ERROR_RUNTIME_FAILURE) return;
    if (result != XR_SUCCESS) std::abort();
    for (int i = 0; i < 4; ++i) {
        const XrResult polled = poll(instance);
        // A scenario may make xrPollEvent fail, but the only success codes are these two.
        if (polled > 0 && polled != XR_EVENT_UNAVAILABLE) std::abort();
    }
    destroyInstance(instance);
}

inline void writeBytes(const std::filesystem::path& file, const std::uint8_t* data, std::size_t size) {
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
}

inline std::filesystem::path scratchFile(const char* name) {
    static std::string folder = [] {
        std::string made = (std::filesystem::temp_directory_path() / "mock-fuzz-XXXXXX").string();
        if (mkdtemp(made.data()) == nullptr) std::abort();
        setenv("XRMOCK_CLOCK", "virtual", 1);
        return made;
    }();
    static const struct Cleaner {
        ~Cleaner() {
            std::error_code unimportant;
            std::filesystem::remove_all(folder, unimportant);
        }
    } cleaner;
    return std::filesystem::path(folder) / name;
}

}  // namespace mock_fuzz
