// Where the OpenXR loader looks for the active runtime on Linux. Sources: "Linux Active Runtime Location"
// in the OpenXR loader's specification, and the files that Debian's loader 1.0.20 was observed to open.
#include <cstdlib>
#include <sstream>

#include "xr/xr.h"

namespace stylet::xr {
namespace {

std::string variable(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

}  // namespace

std::vector<std::string> runtimeSearchPath() {
    // If the variable is set, the loader looks nowhere else, even if the file is missing.
    if (const std::string chosen = variable("XR_RUNTIME_JSON"); !chosen.empty()) return {chosen};

    std::vector<std::string> folders;
    const std::string user = variable("XDG_CONFIG_HOME"), home = variable("HOME");
    if (!user.empty()) {
        folders.push_back(user);
    } else if (!home.empty()) {
        folders.push_back(home + "/.config");
    }
    std::string shared = variable("XDG_CONFIG_DIRS");
    if (shared.empty()) shared = "/etc/xdg";
    std::istringstream list(shared);
    for (std::string folder; std::getline(list, folder, ':');)
        if (!folder.empty()) folders.push_back(folder);
    folders.push_back("/etc");

    for (std::string& folder : folders)
        folder += "/openxr/1/active_runtime.json";
    return folders;
}

}  // namespace stylet::xr
