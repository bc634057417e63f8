// Source of the table: OpenXR 1.0, section 6.4, "Interaction Profile Paths", and the chapters of the
// extensions.
#include "scenario/profiles.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "scenario/openxr_later.h"

namespace xrmock {

namespace {

#define POSES "input/grip/pose input/aim/pose input/palm_ext/pose"
#define TRACKPAD "input/trackpad/x input/trackpad/y input/trackpad/click input/trackpad/touch "
#define THUMBSTICK "input/thumbstick/x input/thumbstick/y input/thumbstick/click "

constexpr char kSimple[] = "input/select/click input/menu/click " POSES " output/haptic";
constexpr char kDaydream[] = "input/select/click " TRACKPAD POSES;
constexpr char kVive[] =
    "input/system/click input/squeeze/click input/menu/click input/trigger/click "
    "input/trigger/value " TRACKPAD POSES " output/haptic";
constexpr char kVivePro[] =
    "input/system/click input/volume_up/click input/volume_down/click input/mute_mic/click";
constexpr char kMotion[] =
    "input/menu/click input/squeeze/click input/trigger/value " THUMBSTICK TRACKPAD POSES " output/haptic";
constexpr char kXbox[] =
    "input/menu/click input/view/click input/a/click input/b/click input/x/click input/y/click "
    "input/dpad_down/click input/dpad_right/click input/dpad_up/click input/dpad_left/click "
    "input/shoulder_left/click input/shoulder_right/click "
    "input/thumbstick_left/x input/thumbstick_left/y input/thumbstick_left/click "
    "input/thumbstick_right/x input/thumbstick_right/y input/thumbstick_right/click "
    "input/trigger_left/value input/trigger_right/value "
    "output/haptic_left output/haptic_right output/haptic_left_trigger output/haptic_right_trigger";
constexpr char kGo[] = "input/system/click input/trigger/click input/back/click " TRACKPAD POSES;

#define TOUCH_BOTH                                                                        \
    "input/squeeze/value input/trigger/value input/trigger/touch input/thumbstick/touch " \
    "input/thumbrest/touch " THUMBSTICK POSES " output/haptic"
constexpr char kTouchLeft[] =
    "input/x/click input/x/touch input/y/click input/y/touch input/menu/click " TOUCH_BOTH;
constexpr char kTouchRight[] =
    "input/a/click input/a/touch input/b/click input/b/touch input/system/click " TOUCH_BOTH;
constexpr char kIndex[] =
    "input/system/click input/system/touch input/a/click input/a/touch input/b/click input/b/touch "
    "input/squeeze/value input/squeeze/force input/trigger/click input/trigger/value input/trigger/touch "
    "input/thumbstick/touch " THUMBSTICK
    "input/trackpad/x input/trackpad/y input/trackpad/force input/trackpad/touch " POSES " output/haptic";

#define COSMOS_BOTH                                                                     \
    "input/shoulder/click input/squeeze/click input/trigger/click input/trigger/value " \
    "input/thumbstick/touch " THUMBSTICK POSES " output/haptic"
constexpr char kCosmosLeft[] = "input/x/click input/y/click input/menu/click " COSMOS_BOTH;
constexpr char kCosmosRight[] = "input/a/click input/b/click input/system/click " COSMOS_BOTH;
#define FOCUS3_BOTH                                                                                          \
    "input/squeeze/click input/squeeze/touch input/squeeze/value input/trigger/click "                       \
    "input/trigger/touch input/trigger/value input/thumbstick/touch input/thumbrest/touch " THUMBSTICK POSES \
    " output/haptic"
constexpr char kFocus3Left[] = "input/x/click input/y/click input/menu/click " FOCUS3_BOTH;
constexpr char kFocus3Right[] = "input/a/click input/b/click input/system/click " FOCUS3_BOTH;
#define HP_BOTH "input/menu/click input/squeeze/value input/trigger/value " THUMBSTICK POSES " output/haptic"
constexpr char kHpLeft[] = "input/x/click input/y/click " HP_BOTH;
constexpr char kHpRight[] = "input/a/click input/b/click " HP_BOTH;

#define TRIGGERS "input/squeeze/value input/trigger/value input/trigger/touch "
#define PICO_BOTH                                                                                 \
    "input/system/click input/squeeze/click input/trigger/click input/thumbstick/touch " TRIGGERS \
        THUMBSTICK POSES " output/haptic"
constexpr char kNeo3Left[] =
    "input/x/click input/x/touch input/y/click input/y/touch input/menu/click " PICO_BOTH;
constexpr char kNeo3Right[] =
    "input/a/click input/a/touch input/b/click input/b/touch input/menu/click " PICO_BOTH;
constexpr const auto& kPico4Left = kNeo3Left;
constexpr char kPico4Right[] = "input/a/click input/a/touch input/b/click input/b/touch " PICO_BOTH;
// These controllers add components to the Touch controller. Only the force inputs are included here.
#define TOUCH_PRO_BOTH                                                                              \
    "input/thumbrest/touch input/thumbrest/force input/thumbstick/touch " TRIGGERS THUMBSTICK POSES \
    " output/haptic"
#define TOUCH_PLUS_BOTH                                                                           \
    "input/thumbrest/touch input/thumbstick/touch input/trigger/force " TRIGGERS THUMBSTICK POSES \
    " output/haptic"
#define LEFT_BUTTONS "input/x/click input/x/touch input/y/click input/y/touch input/menu/click "
#define RIGHT_BUTTONS "input/a/click input/a/touch input/b/click input/b/touch input/system/click "
constexpr char kTouchProLeft[] = LEFT_BUTTONS TOUCH_PRO_BOTH;
constexpr char kTouchProRight[] = RIGHT_BUTTONS TOUCH_PRO_BOTH;
constexpr char kTouchPlusLeft[] = LEFT_BUTTONS TOUCH_PLUS_BOTH;
constexpr char kTouchPlusRight[] = RIGHT_BUTTONS TOUCH_PLUS_BOTH;

#undef TRIGGERS
#undef PICO_BOTH
#undef TOUCH_PRO_BOTH
#undef TOUCH_PLUS_BOTH
#undef LEFT_BUTTONS
#undef RIGHT_BUTTONS
#undef POSES
#undef TRACKPAD
#undef THUMBSTICK
#undef TOUCH_BOTH
#undef COSMOS_BOTH
#undef FOCUS3_BOTH
#undef HP_BOTH

constexpr Profile kProfiles[] = {
    {"/interaction_profiles/khr/simple_controller", "Simple Controller", {kSimple, kSimple}},
    {"/interaction_profiles/google/daydream_controller", "Daydream Controller", {kDaydream, kDaydream}},
    {"/interaction_profiles/htc/vive_controller", "Vive Controller", {kVive, kVive}},
    {"/interaction_profiles/htc/vive_pro", "Vive Pro Headset", {"", "", kVivePro}},
    {"/interaction_profiles/microsoft/motion_controller", "Motion Controller", {kMotion, kMotion}},
    {"/interaction_profiles/microsoft/xbox_controller", "Xbox Controller", {"", "", "", kXbox}},
    {"/interaction_profiles/oculus/go_controller", "Go Controller", {kGo, kGo}},
    {"/interaction_profiles/oculus/touch_controller", "Touch Controller", {kTouchLeft, kTouchRight}},
    {"/interaction_profiles/valve/index_controller", "Index Controller", {kIndex, kIndex}},
    {"/interaction_profiles/hp/mixed_reality_controller",
     "HP Mixed Reality Controller",
     {kHpLeft, kHpRight},
     XR_EXT_HP_MIXED_REALITY_CONTROLLER_EXTENSION_NAME},
    {"/interaction_profiles/htc/vive_cosmos_controller",
     "Vive Cosmos Controller",
     {kCosmosLeft, kCosmosRight},
     XR_HTC_VIVE_COSMOS_CONTROLLER_INTERACTION_EXTENSION_NAME},
    {"/interaction_profiles/htc/vive_focus3_controller",
     "Vive Focus 3 Controller",
     {kFocus3Left, kFocus3Right},
     XR_HTC_VIVE_FOCUS3_CONTROLLER_INTERACTION_EXTENSION_NAME},
    {"/interaction_profiles/bytedance/pico_neo3_controller",
     "PICO Neo3 Controller",
     {kNeo3Left, kNeo3Right},
     XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME},
    {"/interaction_profiles/bytedance/pico4_controller",
     "PICO 4 Controller",
     {kPico4Left, kPico4Right},
     XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME},
    {"/interaction_profiles/facebook/touch_controller_pro",
     "Touch Pro Controller",
     {kTouchProLeft, kTouchProRight},
     XR_FB_TOUCH_CONTROLLER_PRO_EXTENSION_NAME},
    {"/interaction_profiles/meta/touch_controller_plus",
     "Touch Plus Controller",
     {kTouchPlusLeft, kTouchPlusRight},
     XR_META_TOUCH_CONTROLLER_PLUS_EXTENSION_NAME},
    {"/interaction_profiles/samsung/odyssey_controller",
     "Odyssey Controller",
     {kMotion, kMotion},
     XR_EXT_SAMSUNG_ODYSSEY_CONTROLLER_EXTENSION_NAME},
};

// Calls visit(component) for each component until it returns true.
template <class Visit>
bool anyComponent(std::string_view list, Visit visit) {
    while (!list.empty()) {
        const std::size_t end = std::min(list.find(' '), list.size());
        if (visit(list.substr(0, end))) return true;
        list.remove_prefix(std::min(end + 1, list.size()));
    }
    return false;
}

bool listHas(std::string_view list, std::string_view component) {
    return anyComponent(list, [&](std::string_view each) { return each == component; });
}

}  // namespace

const Profile* findProfile(std::string_view path) {
    const auto* found = std::find_if(std::begin(kProfiles), std::end(kProfiles),
                                     [&](const Profile& profile) { return path == profile.path; });
    return found == std::end(kProfiles) ? nullptr : found;
}

const Profile* findProfile(std::string_view path, const Extensions& extensions) {
    const Profile* profile = findProfile(path);
    const bool usable =
        profile != nullptr && (profile->extension == nullptr || extensions.contains(profile->extension));
    return usable ? profile : nullptr;
}

std::string_view findComponents(const Profile& profile, User user) {
    return profile.components[static_cast<std::size_t>(user)];
}

bool isValueOfAnyProfile(User user, std::string_view component) {
    if (!component.starts_with("input/") || component.ends_with("/pose")) return false;
    return std::any_of(std::begin(kProfiles), std::end(kProfiles), [&](const Profile& profile) {
        return listHas(findComponents(profile, user), component);
    });
}

std::optional<BindingPath> splitBindingPath(std::string_view path) {
    // "/user/gamepad/..." has two levels before the component, "/user/hand/left/..." three.
    for (std::size_t end = path.find('/', 1); end != std::string_view::npos; end = path.find('/', end + 1))
        if (const auto user = findUser(path.substr(0, end)))
            return BindingPath{*user, std::string(path.substr(end + 1))};
    return std::nullopt;
}

bool hasComponent(const Profile& profile, const BindingPath& binding, const Extensions& extensions) {
    if (binding.component.starts_with("input/palm_ext") &&
        !extensions.contains(XR_EXT_PALM_POSE_EXTENSION_NAME)) {
        return false;
    }
    const std::string below = binding.component + "/";
    // "input" alone is the parent of every component but not a valid binding.
    return binding.component.find('/') != std::string::npos &&
           anyComponent(findComponents(profile, binding.user), [&](std::string_view each) {
               return each == binding.component || each.starts_with(below);
           });
}

std::vector<std::string> componentsFor(const Profile& profile, const BindingPath& binding,
                                       XrActionType type) {
    const std::string_view list = findComponents(profile, binding.user);
    const std::string& given = binding.component;
    const auto ends = [&](const char* suffix) { return given.ends_with(suffix); };
    const auto firstBelow = [&](std::initializer_list<const char*> suffixes) -> std::vector<std::string> {
        for (const char* suffix : suffixes)
            if (listHas(list, given + suffix)) return {given + suffix};
        return {};
    };
    const bool exact = listHas(list, given);
    switch (type) {
        case XR_ACTION_TYPE_BOOLEAN_INPUT:
        case XR_ACTION_TYPE_FLOAT_INPUT:
            if (exact)
                return ends("/pose") || given.starts_with("output/") ? std::vector<std::string>{}
                                                                     : std::vector{given};
            return type == XR_ACTION_TYPE_BOOLEAN_INPUT ? firstBelow({"/click", "/value", "/force"})
                                                        : firstBelow({"/value", "/force", "/click"});
        case XR_ACTION_TYPE_VECTOR2F_INPUT:
            if (exact || !listHas(list, given + "/x")) return {};
            return {given + "/x", given + "/y"};
        case XR_ACTION_TYPE_POSE_INPUT:
            if (exact) return ends("/pose") ? std::vector{given} : std::vector<std::string>{};
            return firstBelow({"/pose"});
        case XR_ACTION_TYPE_VIBRATION_OUTPUT:
            return exact && given.starts_with("output/") ? std::vector{given} : std::vector<std::string>{};
        default:
            return {};
    }
}

}  // namespace xrmock
