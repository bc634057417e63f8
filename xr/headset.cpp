#include "xr/headset.h"

#include <algorithm>
#include <array>

namespace stylet::xr {
namespace {

constexpr auto kEyes = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
constexpr const char* kNoStereo = "the headset does not support stereo (one image per eye)";

void requireStereo(const Instance& instance) {
    const char* call = "xrEnumerateViewConfigurations";
    const auto offered = enumerate<XrViewConfigurationType>(call, kNoStereo, [&](auto... out) {
        return xrEnumerateViewConfigurations(instance.handle.get(), instance.system, out...);
    });
    if (std::find(offered.begin(), offered.end(), kEyes) == offered.end())
        throw XrError(std::string(call) + ": " + kNoStereo);
}

XrEnvironmentBlendMode chooseBlendMode(const Instance& instance, bool passthrough,
                                       std::vector<std::string>& notes) {
    const char* call = "xrEnumerateEnvironmentBlendModes";
    const auto offered = enumerate<XrEnvironmentBlendMode>(call, kNoStereo, [&](auto... out) {
        return xrEnumerateEnvironmentBlendModes(instance.handle.get(), instance.system, kEyes, out...);
    });
    if (offered.empty()) throw XrError(std::string(call) + ": the runtime offers no blend mode");
    const auto offers = [&](XrEnvironmentBlendMode mode) {
        return std::find(offered.begin(), offered.end(), mode) != offered.end();
    };
    if (passthrough) {
        for (const auto mode : {XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND, XR_ENVIRONMENT_BLEND_MODE_ADDITIVE})
            if (offers(mode)) return mode;
        notes.push_back(std::string(call) + ": the headset does not show the room: no passthrough");
    }
    // Without OPAQUE, use the runtime's preferred mode.
    return offers(XR_ENVIRONMENT_BLEND_MODE_OPAQUE) ? XR_ENVIRONMENT_BLEND_MODE_OPAQUE : offered.front();
}

}  // namespace

Headset readHeadset(const Instance& instance, bool passthrough, std::vector<std::string>& notes) {
    requireStereo(instance);
    Headset headset;
    headset.blend_mode = chooseBlendMode(instance, passthrough, notes);
    std::array<XrViewConfigurationView, 2> eyes{};
    eyes.fill({XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, 0, 0, 0, 0, 0, 0});
    std::uint32_t count = 0;
    check(xrEnumerateViewConfigurationViews(instance.handle.get(), instance.system, kEyes, 2, &count,
                                            eyes.data()),
          "xrEnumerateViewConfigurationViews", kNoStereo);
    const XrSystemGraphicsProperties& limits = instance.limits;
    headset.width = std::min(std::max(eyes[0].recommendedImageRectWidth, eyes[1].recommendedImageRectWidth),
                             limits.maxSwapchainImageWidth);
    headset.height =
        std::min(std::max(eyes[0].recommendedImageRectHeight, eyes[1].recommendedImageRectHeight),
                 limits.maxSwapchainImageHeight);
    if (headset.width == 0 || headset.height == 0)
        throw XrError("xrEnumerateViewConfigurationViews: the runtime recommends images of size 0");
    headset.max_layers = std::max<std::size_t>(limits.maxLayerCount, XR_MIN_COMPOSITION_LAYERS_SUPPORTED);
    return headset;
}

const char* blendModeName(XrEnvironmentBlendMode mode) {
    constexpr std::array kNames{"unknown", "opaque", "additive", "alpha_blend"};
    return kNames[std::size_t(mode) < kNames.size() ? std::size_t(mode) : 0];
}

double refreshRate_hz(const Instance& instance, XrSession session) {
    float rate_hz = 0;
    if (!instance.calls.getRefreshRate || XR_FAILED(instance.calls.getRefreshRate(session, &rate_hz)))
        return 0.0;
    return double(rate_hz);
}

HiddenArea hiddenArea(const Instance& instance, XrSession session, int eye) {
    const auto get = instance.calls.getVisibilityMask;
    if (!get) return {};
    constexpr auto kHidden = XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR;
    auto mask = makeStruct<XrVisibilityMaskKHR>(XR_TYPE_VISIBILITY_MASK_KHR);
    if (XR_FAILED(get(session, kEyes, std::uint32_t(eye), kHidden, &mask)) || mask.indexCountOutput == 0)
        return {};
    std::vector<XrVector2f> vertices(mask.vertexCountOutput);
    HiddenArea area;
    area.indices.resize(mask.indexCountOutput);
    mask.vertexCapacityInput = mask.vertexCountOutput;
    mask.indexCapacityInput = mask.indexCountOutput;
    mask.vertices = vertices.data();
    mask.indices = area.indices.data();
    if (XR_FAILED(get(session, kEyes, std::uint32_t(eye), kHidden, &mask))) return {};
    for (const XrVector2f& v : vertices)
        area.tangents.push_back({v.x, v.y});
    // The GPU reads the mask without further checks, so every index must be valid.
    const auto inside = [&](std::uint32_t i) { return i < area.tangents.size(); };
    if (area.indices.size() % 3 != 0 || !std::all_of(area.indices.begin(), area.indices.end(), inside))
        return {};
    return area;
}

}  // namespace stylet::xr
