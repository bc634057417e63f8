#include <algorithm>

#include "api/api.h"
#include "world/objects.h"
#include "world/verify.h"
#include "world/visibility_mask.h"

namespace xrmock {

XrResult getVisibilityMask(Call& call, XrSession handle, XrViewConfigurationType configuration,
                           std::uint32_t view, XrVisibilityMaskTypeKHR type, XrVisibilityMaskKHR* out) {
    const Session& session = call.live<Session>(handle);
    requireViewConfiguration(configuration);
    const Scenario& scenario = session.instance.scenario;
    requireValid(view < scenario.lens.size(), "there is no view of this index");
    requireValid(type >= XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR &&
                     type <= XR_VISIBILITY_MASK_TYPE_LINE_LOOP_KHR,
                 "visibilityMaskType is no known value");
    requireStruct(out, XR_TYPE_VISIBILITY_MASK_KHR);
    const MaskMesh mesh = maskMesh(visibilityMask(scenario.lens[view], scenario.eye_fov[view]), type);
    out->vertexCountOutput = static_cast<std::uint32_t>(mesh.vertices.size());
    out->indexCountOutput = static_cast<std::uint32_t>(mesh.indices.size());
    if (out->vertexCapacityInput == 0 || out->indexCapacityInput == 0) return XR_SUCCESS;
    require(
        out->vertexCapacityInput >= mesh.vertices.size() && out->indexCapacityInput >= mesh.indices.size(),
        XR_ERROR_SIZE_INSUFFICIENT, "a buffer is too small");
    requireValid(out->vertices != nullptr && out->indices != nullptr, "a buffer is null");
    std::copy(mesh.vertices.begin(), mesh.vertices.end(), out->vertices);
    std::copy(mesh.indices.begin(), mesh.indices.end(), out->indices);
    return XR_SUCCESS;
}

}  // namespace xrmock
