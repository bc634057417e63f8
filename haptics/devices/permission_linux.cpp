#include "haptics/devices/permission_linux.h"

#include <unistd.h>

#include <fmt/core.h>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace stylet::haptics {

std::string accessProblem(const std::string& node) {
    if (access(node.c_str(), R_OK | W_OK) == 0) return {};
    return accessProblem(node, errno);
}

std::string accessProblem(const std::string& node, int error) {
    switch (error) {
        case EACCES:
        case EPERM:
            if (std::error_code none;
                std::filesystem::exists("/usr/lib/udev/rules.d/70-stylet-usb.rules", none))
                return fmt::format(
                    "no permission for {}: the udev rules grant it to the user logged in at this machine: "
                    "log "
                    "in there (not over SSH), run \"sudo udevadm control --reload\" and plug the device in "
                    "again",
                    node);
            return fmt::format(
                "no permission for {}: run \"sudo cp packaging/udev/*.rules /etc/udev/rules.d/ && sudo "
                "udevadm "
                "control --reload\" and plug the device in again",
                node);
        case EBUSY:
            return node + " is in use: close the other program that uses the device";
        case ENOENT:
        case ENODEV:
        case ENXIO:
            return node + " is gone: plug the device in again";
        default:
            return fmt::format("{} cannot be opened: {}", node, std::strerror(error));
    }
}

}  // namespace stylet::haptics
