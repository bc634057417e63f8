#include "api/api.h"
#include "scenario/loader_interface.h"

XRAPI_ATTR XrResult XRAPI_CALL xrNegotiateLoaderRuntimeInterface(const XrNegotiateLoaderInfo* loader,
                                                                 XrNegotiateRuntimeRequest* request) {
    if (loader == nullptr || request == nullptr ||
        loader->structType != XR_LOADER_INTERFACE_STRUCT_LOADER_INFO ||
        loader->structVersion != kLoaderStructVersion || loader->structSize != sizeof *loader ||
        request->structType != XR_LOADER_INTERFACE_STRUCT_RUNTIME_REQUEST ||
        request->structVersion != kLoaderStructVersion || request->structSize != sizeof *request ||
        loader->minInterfaceVersion > kLoaderInterfaceVersion ||
        loader->maxInterfaceVersion < kLoaderInterfaceVersion ||
        loader->minApiVersion > xrmock::kApiVersion ||
        XR_VERSION_MAJOR(loader->maxApiVersion) < XR_VERSION_MAJOR(xrmock::kApiVersion)) {
        return XR_ERROR_INITIALIZATION_FAILED;
    }
    request->runtimeInterfaceVersion = kLoaderInterfaceVersion;
    request->runtimeApiVersion = xrmock::kApiVersion;
    request->getInstanceProcAddr = xrmock::getInstanceProcAddr;
    return XR_SUCCESS;
}
