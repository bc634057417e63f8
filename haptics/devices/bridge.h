// A device whose closed SDK lives in a process of its own: the driver's end of the protocol of
// bridge/README.md, on a UNIX socket. A crash over there is a lost connection here.
#pragma once

#include <memory>
#include <string>

#include "haptics/devices/driver.h"
#include "haptics/devices/local_socket_linux.h"
#include "haptics/loop.h"

namespace stylet::haptics {

namespace bridge {
class Link;
}

struct BridgeSettings {
    std::string socket_path;                // empty: bridgeSocketPath()
    std::int64_t answer_ns = 4'000'000;     // an exchange waits so long for its answer
    std::int64_t greeting_ns = 80'000'000;  // and open() for the capabilities
};

// $STYLET_BRIDGE_SOCKET, else stylet-bridge.sock in $XDG_RUNTIME_DIR, else in /run/user/UID.
std::string bridgeSocketPath();

class BridgeDriver final : public Driver {
  public:
    // The clock is CLOCK_MONOTONIC, which the bridge shares.
    explicit BridgeDriver(const Clock&, const BridgeSettings& = {});
    ~BridgeDriver() override;

    // Before the first greeting, the weakest device we know; afterwards what the bridge said.
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    // While the bridge holds zero (its watchdog, or the device's own safety) the stage is `opening`, so that
    // zero is sent, which is what makes it let go of that.
    DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) override;
    void close() noexcept override;

  private:
    DeviceStage connect(std::string& why);
    DeviceStage greet(std::string& why);
    DeviceStage fail(std::string& why, const std::string& reason);
    DeviceStage refused(std::string& why);
    bool receive(std::string& why);
    bool sound(std::string& why);

    std::int64_t now() const noexcept { return clock_.now_ns(clock_.context); }

    Clock clock_;
    BridgeSettings settings_;
    LocalSocket socket_;
    std::unique_ptr<bridge::Link> link_;  // of this connection
    std::string name_, source_;           // that `profile_` points to
    DeviceProfile profile_;
};

}  // namespace stylet::haptics
