#include "haptics/devices/bridge/bridge.h"
#include "haptics/devices/entry.h"
#include "haptics/devices/inverse3/service_linux.h"
#include "haptics/devices/permission_linux.h"

namespace stylet::haptics {

namespace {

std::string socketOf(const DeviceOptions& options) {
    return options.socket.empty() ? bridgeSocketPath() : options.socket;
}

void findBridge(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::string socket = socketOf(options);
    std::error_code error;
    if (!std::filesystem::is_socket(socket, error)) return;
    std::string problem = accessProblem(socket);
    if (problem.empty() && !hasListener(socket))
        problem = "stale socket, no program listens: start the bridge again";
    found.push_back({"bridge", socket, "a bridge's socket", problem});
}

DeviceProfile bridgeProfile(const DeviceOptions&) {
    return {.name = "bridge",
            .force_peak_n = kUnknown,
            .stiffness_n_per_m = kUnknown,
            .source = "the bridge tells once it is connected"};
}

std::unique_ptr<Driver> makeBridge(const DeviceOptions& options, const Clock& clock) {
    return std::make_unique<BridgeDriver>(clock, BridgeSettings{.socket_path = socketOf(options)});
}

}  // namespace

extern const DeviceEntry kBridgeEntry{
    {"bridge", "a device behind a closed SDK, in a process of its own", nullptr},
    findBridge,
    bridgeProfile,
    makeBridge};

}  // namespace stylet::haptics
