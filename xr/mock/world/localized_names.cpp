#include "world/localized_names.h"

#include <cctype>

namespace xrmock {

namespace {

// "input/dpad_up/click" becomes "Dpad Up"; "click" is omitted.
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

constexpr const char* kUserTitles[kUserCount] = {"Left Hand", "Right Hand", "Head", "Gamepad", "Treadmill"};

}  // namespace

std::string localizedName(const Profile& profile, const BindingPath& source,
                          XrInputSourceLocalizedNameFlags parts) {
    std::string name;
    const auto append = [&](XrInputSourceLocalizedNameFlags part, const std::string& title) {
        if ((parts & part) == 0) return;
        if (!name.empty()) name += ' ';
        name += title;
    };
    append(XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT, kUserTitles[static_cast<std::size_t>(source.user)]);
    append(XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT, profile.title);
    append(XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT, componentTitle(source.component));
    return name;
}

}  // namespace xrmock
