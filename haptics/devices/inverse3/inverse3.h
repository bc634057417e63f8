// Haply's Inverse3 with a VerseGrip, through Haply's service on this machine: a WebSocket with JSON
// messages, one state per command. Facts as in inverse3_messages.h. A command lasts for one tick of the
// service, which goes idle when commands stop. That acts as a dead-man switch; its timeout is undocumented.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "haptics/devices/driver.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics {

namespace inverse3 {
enum class Spelling;
struct Update;
}  // namespace inverse3

struct Inverse3Settings {
    std::string address = {};  // loopback address; empty: 127.0.0.1, then ::1
    unsigned short port = 10001;
    std::optional<inverse3::Spelling> spelling = {};  // unset: derived from the service's version
    // Force limit from the device's data sheet; Haply publishes none. Unset: that of the weakest known
    // device.
    std::optional<double> force_peak_n = {};
    std::int64_t answer_ns = 4'000'000;     // how long an exchange waits for its answer
    std::int64_t silent_ns = 15'000'000;    // without an answer for this long the connection is lost
    std::int64_t greeting_ns = 80'000'000;  // time limit for open()
};

class Inverse3Driver final : public Driver {
  public:
    explicit Inverse3Driver(const Clock&, const Inverse3Settings& = {});
    ~Inverse3Driver() override;

    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceStage open(std::string& why) override;
    DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) override;
    void close() noexcept override;

  private:
    struct Connection;
    DeviceStage connect(const std::string& address, std::int64_t deadline_ns, std::string& why);
    DeviceStage readInventory(std::int64_t deadline_ns, std::string& why);
    DeviceStage evaluate(const inverse3::Update&, DeviceState&, std::string& why) const;
    DeviceStage fail(std::string& why, const std::string& reason);

    Clock clock_;
    Inverse3Settings settings_;
    DeviceProfile profile_;
    std::string device_id_;  // of the first device opened; no other is accepted
    bool known_ = false, has_grip_ = false;
    std::unique_ptr<Connection> connection_;
};

}  // namespace stylet::haptics
