// Human-readable names of input sources (English).
#pragma once

#include <string>

#include "scenario/profiles.h"

namespace xrmock {

constexpr XrInputSourceLocalizedNameFlags kAllNameComponents =
    XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT | XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT |
    XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT;

// "Left Hand Simple Controller Select", or only the requested parts.
std::string localizedName(const Profile& profile, const BindingPath& source,
                          XrInputSourceLocalizedNameFlags parts);

}  // namespace xrmock
