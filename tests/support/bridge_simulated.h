// Simulates a vendor's SDK behind the interface of bridge/server.h. A servo thread at 1 kHz moves the stylus
// along a circle of 20 mm once a second and ignores the force. With Ticks::test there is no such thread; the
// test calls tick().
#pragma once

#include <atomic>
#include <thread>

#include "haptics/devices/bridge/serve_linux.h"

namespace stylet::test {

class SimulatedSdk final : public haptics::bridge::Sdk {
  public:
    enum class Ticks { thread, test };
    explicit SimulatedSdk(Ticks ticks = Ticks::thread) : threaded_(ticks == Ticks::thread) {}
    ~SimulatedSdk() override { stop(); }
    bool open(haptics::bridge::Capabilities&, std::string& why) override;
    bool start(haptics::bridge::Servo&, std::string& why) override;
    void stop() noexcept override;

    // One tick of the servo. False: the device was unplugged.
    bool tick(std::int64_t now_ns);
    bool running() const { return running_.load(); }
    double motor_n() const { return motor_n_.load(); }
    std::uint64_t ticks() const { return ticks_.load(); }
    std::int64_t last_force_ns() const { return last_force_ns_.load(); }  // time of the motors' last force
    void unplug() { unplugged_.store(true); }
    std::atomic<bool> missing{false};  // if set before serve(), open() fails

  private:
    void run();
    const bool threaded_;
    haptics::bridge::Servo* servo_ = nullptr;
    std::atomic<bool> running_{false}, unplugged_{false};
    std::atomic<double> motor_n_{0.0};
    std::atomic<std::uint64_t> ticks_{0};
    std::atomic<std::int64_t> last_force_ns_{0};
    std::thread thread_;
};

}  // namespace stylet::test
