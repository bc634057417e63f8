// Source of the table: OpenXR 1.0, section 6.4, "Interaction Profile Paths", and the chapters of the
// extensions.
#include "xr/profiles.h"

#include <fmt/core.h>

#include <span>

namespace stylet::xr {
namespace {

struct Profile {
    const char* name;       // below /interaction_profiles/
    const char* extension;  // null: core
    const char* select;     // the runtime applies a threshold if a trigger is bound to a boolean action
    std::array<const char*, 2> menu;  // left, right
    const char* squeeze;              // null: none
    const char* thumbstick;
};

constexpr std::array kMenuBoth{"/input/menu/click", "/input/menu/click"};
constexpr std::array kMenuAndB{"/input/menu/click", "/input/b/click"};
constexpr std::array kBBoth{"/input/b/click", "/input/b/click"};
constexpr const char* kTrigger = "/input/trigger/value";
constexpr const char* kSqueeze = "/input/squeeze/value";
constexpr const char* kSqueezeClick = "/input/squeeze/click";
constexpr const char* kThumbstick = "/input/thumbstick";
constexpr const char* kTrackpad = "/input/trackpad";

constexpr Profile kProfiles[] = {
    {"khr/simple_controller", nullptr, "/input/select/click", kMenuBoth, nullptr, nullptr},
    {"oculus/touch_controller", nullptr, kTrigger, kMenuAndB, kSqueeze, kThumbstick},
    {"valve/index_controller", nullptr, kTrigger, kBBoth, kSqueeze, kThumbstick},
    {"htc/vive_controller", nullptr, kTrigger, kMenuBoth, kSqueezeClick, kTrackpad},
    {"microsoft/motion_controller", nullptr, kTrigger, kMenuBoth, kSqueezeClick, kThumbstick},
    {"hp/mixed_reality_controller", XR_EXT_HP_MIXED_REALITY_CONTROLLER_EXTENSION_NAME, kTrigger, kMenuBoth,
     kSqueeze, kThumbstick},
    {"htc/vive_focus3_controller", XR_HTC_VIVE_FOCUS3_CONTROLLER_INTERACTION_EXTENSION_NAME, kTrigger,
     kMenuAndB, kSqueezeClick, kThumbstick},
    {"bytedance/pico4_controller", XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME, kTrigger, kMenuAndB, kSqueeze,
     kThumbstick},
    {"bytedance/pico_neo3_controller", XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME, kTrigger, kMenuAndB,
     kSqueeze, kThumbstick},
    {"facebook/touch_controller_pro", XR_FB_TOUCH_CONTROLLER_PRO_EXTENSION_NAME, kTrigger, kMenuAndB,
     kSqueeze, kThumbstick},
    {"meta/touch_controller_plus", XR_META_TOUCH_CONTROLLER_PLUS_EXTENSION_NAME, kTrigger, kMenuAndB,
     kSqueeze, kThumbstick},
};

struct Binding {
    XrAction action;
    std::string path;
};
using Bindings = std::vector<Binding>;

XrResult suggest(XrInstance instance, const Profile& profile, const Bindings& bindings) {
    std::vector<XrActionSuggestedBinding> suggested;
    for (const Binding& binding : bindings)
        suggested.push_back({binding.action, toXrPath(instance, binding.path)});
    auto info =
        makeStruct<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
    info.interactionProfile = toXrPath(instance, std::string("/interaction_profiles/") + profile.name);
    info.countSuggestedBindings = std::uint32_t(suggested.size());
    info.suggestedBindings = suggested.data();
    return xrSuggestInteractionProfileBindings(instance, &info);
}

// A controller is useless without its first kRequired bindings.
constexpr std::size_t kRequired = 4;
Bindings makeBindings(const Actions& actions, const Profile& profile) {
    Bindings bindings;
    for (const std::string hand : kSides) {
        bindings.push_back({actions.grip, hand + "/input/grip/pose"});
        bindings.push_back({actions.select, hand + profile.select});
    }
    for (std::size_t side = 0; side < kSides.size(); ++side) {
        const std::string hand = kSides[side];
        bindings.push_back({actions.aim, hand + "/input/aim/pose"});
        bindings.push_back({actions.haptic, hand + "/output/haptic"});
        bindings.push_back({actions.menu, hand + profile.menu[side]});
        if (profile.squeeze) bindings.push_back({actions.squeeze, hand + profile.squeeze});
        if (profile.thumbstick) bindings.push_back({actions.thumbstick, hand + profile.thumbstick});
    }
    return bindings;
}

// Called after the runtime refused the full set of bindings. Tries each optional binding in addition to
// those accepted so far.
void suggestOneByOne(XrInstance instance, const Profile& profile, const Bindings& all,
                     std::vector<std::string>& notes) {
    const char* call = "xrSuggestInteractionProfileBindings";
    Bindings accepted(all.begin(), all.begin() + kRequired);
    if (const XrResult result = suggest(instance, profile, accepted); XR_FAILED(result)) {
        notes.push_back(fmt::format("{}: {}: the runtime takes no /interaction_profiles/{} bindings", call,
                                    resultName(result), profile.name));
        return;
    }
    bool refused_last = false;
    for (const Binding& binding : std::span(all).subspan(kRequired)) {
        accepted.push_back(binding);
        const XrResult result = suggest(instance, profile, accepted);
        refused_last = XR_FAILED(result);
        if (!refused_last) continue;
        accepted.pop_back();
        notes.push_back(
            fmt::format("{}: {}: {} goes without {}", call, resultName(result), profile.name, binding.path));
    }
    // The refused suggestion may have replaced the accepted one: suggest the accepted bindings again.
    if (refused_last) suggest(instance, profile, accepted);
}

}  // namespace

XrPath toXrPath(XrInstance instance, const std::string& text) {
    XrPath path = XR_NULL_PATH;
    check(xrStringToPath(instance, text.c_str(), &path), "xrStringToPath", text);
    return path;
}

void suggestBindings(const Instance& instance, const Actions& actions, std::vector<std::string>& notes) {
    const XrInstance handle = instance.handle.get();
    for (const Profile& profile : kProfiles) {
        if (profile.extension && !instance.has(profile.extension)) continue;
        const Bindings all = makeBindings(actions, profile);
        if (XR_FAILED(suggest(handle, profile, all))) suggestOneByOne(handle, profile, all, notes);
    }
}

}  // namespace stylet::xr
