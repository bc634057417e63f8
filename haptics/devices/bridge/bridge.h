// A device whose closed SDK runs in a separate process. This is the driver's end of the protocol in
// bridge/README.md, over a UNIX socket. A crash in the SDK is only a lost connection here.
#pragma once

#include <memory>
#include <string>

#include "haptics/devices/bridge/local_socket_linux.h"
#include "haptics/devices/driver.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics {

namespace bridge {
class Link;
}

struct BridgeSettings {
    std::string socket_path;                // empty: bridgeSocketPath()
    std::int64_t answer_ns = 4'000'000;     // how long an exchange waits for its answer
    std::int64_t greeting_ns = 80'000'000;  // how long open() waits for the capabilities
};

// $STYLET_BRIDGE_SOCKET, else stylet-bridge.sock in $XDG_RUNTIME_DIR, else in /run/user/UID.
std::string bridgeSocketPath();

class BridgeDriver final : public Driver {
  public:
    // The clock must be CLOCK_MONOTONIC, which the bridge shares.
    explicit BridgeDriver(const Clock&, const BridgeSettings& = {});
    ~BridgeDriver() override;

    // The weakest known device until the bridge has first answered, then the bridge's capabilities.
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    // While the bridge applies zero force (its watchdog, or the device's own safety), the stage is
    // `opening`. Zero is sent in that stage, which resets the bridge's watchdog.
    DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) override;
    void close() noexcept override;

  private:
    DeviceStage greet(std::string& why);
    DeviceStage fail(std::string& why, const std::string& reason);
    DeviceStage sendFailed(std::string& why);
    bool receive(std::string& why);
    bool checkLink(std::string& why);

    std::int64_t now() const noexcept { return clock_.now(); }

    Clock clock_;
    BridgeSettings settings_;
    LocalSocket socket_;
    std::unique_ptr<bridge::Link> link_;  // of the current connection
    std::string name_, source_;           // storage for the strings of `profile_`
    DeviceProfile profile_;
};

}  // namespace stylet::haptics
