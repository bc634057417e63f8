// A faulty OpenXR runtime. STYLET_BAD_RUNTIME selects the fault:
// - "hang": the runtime never returns to the loader.
// - "crash": the runtime ends the program with SIGSEGV.
// - The name of an OpenXR function: this function fails. All other calls go to the runtime that
//   STYLET_GOOD_RUNTIME names.
#include <dlfcn.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string_view>

#include "xr/mock/scenario/loader_interface.h"

namespace {

PFN_xrGetInstanceProcAddr good_look_up = nullptr;

std::string_view variable(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

XrResult fails() {
    return variable("STYLET_BAD_RUNTIME") == "xrGetSystem" ? XR_ERROR_FORM_FACTOR_UNAVAILABLE
                                                           : XR_ERROR_RUNTIME_FAILURE;
}

XRAPI_ATTR XrResult XRAPI_CALL lookUp(XrInstance instance, const char* name, PFN_xrVoidFunction* function) {
    if (variable("STYLET_BAD_RUNTIME") != name) return good_look_up(instance, name, function);
    *function = reinterpret_cast<PFN_xrVoidFunction>(fails);
    return XR_SUCCESS;
}

}  // namespace

XRAPI_ATTR XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(const XrNegotiateLoaderInfo* loader,
                                                                 XrNegotiateRuntimeRequest* request) {
    if (variable("STYLET_BAD_RUNTIME") == "crash") std::raise(SIGSEGV);
    while (variable("STYLET_BAD_RUNTIME") == "hang")
        pause();
    void* good = dlopen(std::getenv("STYLET_GOOD_RUNTIME"), RTLD_NOW | RTLD_LOCAL);
    if (!good) return XR_ERROR_RUNTIME_FAILURE;
    const auto negotiate = reinterpret_cast<decltype(&xrNegotiateLoaderRuntimeInterface)>(
        dlsym(good, "xrNegotiateLoaderRuntimeInterface"));
    const XrResult result = negotiate(loader, request);
    good_look_up = request->getInstanceProcAddr;
    request->getInstanceProcAddr = lookUp;
    return result;
}
