#include "localized_names.h"

#include <cctype>

namespace xrmock {

namespace {

// "input/dpad_up/click" is "Dpad Up"; the click is understood.
std::string componentTitle(const std::string& component) {
    const std::size_t start = component.find('/') + 1;
    const std::size_t end = component.find('/', start);
    std::string title = component.substr(start, end == std::string::npos ? end : end - start);
    bool word_start = true;
    for (char& c : title) {
        if (c == '_') c = ' ';
        if (word_start) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        word_start = c == ' ';
    }
    return title;
}

std::string userTitle(const std::string& user_path) {
    if (user_path == "/user/hand/left") return "Left Hand";
    if (user_path == "/user/hand/right") return "Right Hand";
    if (user_path == "/user/head") return "Head";
    return user_path == "/user/gamepad" ? "Gamepad" : "Treadmill";
}

}  // namespace

std::string localizedName(const Profile& profile, const BindingPath& source,
                          XrInputSourceLocalizedNameFlags parts) {
    std::string name;
    const auto append = [&](XrInputSourceLocalizedNameFlags part, const std::string& title) {
        if ((parts & part) == 0) return;
        if (!name.empty()) name += ' ';
        name += title;
    };
    append(XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT, userTitle(source.user_path));
    append(XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT, profile.title);
    append(XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT, componentTitle(source.component));
    return name;
}

}  // namespace xrmock
