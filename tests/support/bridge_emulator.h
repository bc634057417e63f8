// Emulates a bridge, the driver's peer in haptics/devices/bridge/README.md. Written from that page alone: it
// shares no header with the driver and uses zlib's checksum. It can inject faults.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace stylet::test {

enum class BridgeFault {
    none,
    drop,       // answers are not sent
    duplicate,  // sent twice
    corrupt,    // one bit is flipped
    stall,      // withheld, then sent all at once
    hangUp,     // half a frame, then the connection is closed
    notFinite,  // a NaN with a good checksum
    farAway,    // a position outside every room
    notAUnit,   // a quaternion of length 2
    future,     // the bridge's clock jumps a second ahead
    past,       // the bridge's clock jumps a second back
    frozen,     // the device gives no new sample
    tooLong,    // a length of 65,535
    version,    // version 2
    unasked,    // answers a force that was never sent
    garbage,    // noise
};
inline constexpr int kBridgeFaultCount = int(BridgeFault::garbage) + 1;

struct BridgeScript {
    BridgeFault fault = BridgeFault::none;
    std::uint64_t from_answer = 0, answers = 1;  // the faulty answers
    std::int64_t stall_ns = 0;
    std::uint32_t seed = 1;
    std::array<double, 3> position_m{0.0, 0.0, 0.1};
    double stroke_m = 0.0, period_s = 1.0;  // the stylus moves down z by the stroke and back
    double force_peak_n = 3.3;
    double workspace_radius_m = 0.08;
    std::string name = "emulated Touch";
    // Clock of BridgeServer if a test steps it; a faulty answer then advances it by the driver's whole wait.
    // Null: CLOCK_MONOTONIC.
    std::atomic<std::int64_t>* time_ns = nullptr;
    bool time_of_forces = false;  // use the time in the newest force as clock (driver in another process)
};

// Bytes and times in, bytes out.
class BridgeEmulator {
  public:
    explicit BridgeEmulator(const BridgeScript& script) : script_(script), noise_(script.seed) {}
    // Processes bytes from the driver and appends the answer to `out`. False: close the connection after
    // that.
    bool receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns, std::vector<std::uint8_t>& out);
    // Appends withheld answers that are due.
    void release(std::int64_t now_ns, std::vector<std::uint8_t>& out);

    // Sets the stylus pose from now on, instead of the script's motion: position, and quaternion w x y z.
    void place(const std::array<double, 7>& device_from_stylus) { placed_ = device_from_stylus; }
    // Sets the hand's offset from the script's position, and the pressed buttons.
    void hold(double out_m, std::uint32_t buttons) { out_m_ = out_m, buttons_ = buttons; }

    // Force of the motors. Zero after 15 ms without a force message, and until a zero force has then arrived.
    std::array<double, 3> motors_n(std::int64_t now_ns);
    double asked_n() const;  // magnitude of the last force received
    std::uint64_t answered() const { return answered_; }
    std::int64_t fault_began_ns() const { return fault_began_ns_; }  // 0: not yet
    std::uint64_t faulty() const { return faulty_; }                 // faulty answers so far
    const std::string& complaint() const { return complaint_; }      // error in the driver's bytes
    bool byed() const { return byed_; }

  private:
    bool frame(std::span<const std::uint8_t> bytes, std::int64_t now_ns, std::vector<std::uint8_t>& out);
    bool answer(std::uint32_t force, std::int64_t now_ns, std::vector<std::uint8_t>& out);
    std::vector<std::uint8_t> sealed(std::uint8_t type, std::vector<std::uint8_t> payload);
    std::vector<std::uint8_t> capabilities();
    std::vector<std::uint8_t> state(std::uint32_t force, std::int64_t now_ns);
    std::uint32_t random();

    BridgeScript script_;
    std::vector<std::uint8_t> in_, withheld_;
    std::int64_t release_ns_ = 0, fault_began_ns_ = 0, frozen_ns_ = 0, moving_ns_ = 0;
    std::uint32_t sent_ = 0, noise_, last_in_ = 0;
    std::uint64_t answered_ = 0, faulty_ = 0;
    bool greeted_ = false, byed_ = false, tripped_ = true;
    std::array<double, 3> force_n_{};
    std::int64_t force_ns_ = -1;
    double out_m_ = 0.0;
    std::uint32_t buttons_ = 0;
    std::optional<std::array<double, 7>> placed_;
    std::string complaint_;
};

std::int64_t monotonicNow_ns();

// BridgeEmulator on a UNIX socket, on its own thread. Serves one connection at a time and restarts the script
// for each.
class BridgeServer {
  public:
    BridgeServer(const std::string& path, const BridgeScript&);
    ~BridgeServer();
    BridgeServer(const BridgeServer&) = delete;
    BridgeServer& operator=(const BridgeServer&) = delete;

    // From now on the hand is `out_m` along +z from the script's position, with these buttons pressed.
    void hold(double out_m, std::uint32_t buttons = 0) { out_m_.store(out_m), buttons_.store(buttons); }
    // From now on `way` gives the stylus pose for a time of CLOCK_MONOTONIC. Called on the server's thread.
    using Way = std::function<std::array<double, 7>(std::int64_t now_ns)>;
    void follow(Way way) {
        const std::lock_guard lock(way_mutex_);
        way_ = std::move(way);
    }
    std::int64_t fault_began_ns() const { return fault_began_ns_.load(); }
    double motor_n() const { return motor_n_.load(); }  // magnitude of the motors' force
    double asked_n() const { return asked_n_.load(); }  // magnitude of the last force received, however old
    int connections() const { return connections_.load(); }
    std::uint64_t answered() const { return answered_.load(); }  // over all connections
    bool byed() const { return byed_.load(); }

  private:
    std::int64_t now_ns() const { return script_.time_ns ? script_.time_ns->load() : monotonicNow_ns(); }
    void run();
    void converse(int client);

    BridgeScript script_;
    int listener_ = -1;
    std::atomic<bool> stop_{false}, byed_{false};
    std::atomic<std::int64_t> fault_began_ns_{0};
    std::atomic<double> motor_n_{0.0}, asked_n_{0.0}, out_m_{0.0};
    std::atomic<std::uint32_t> buttons_{0};
    std::atomic<int> connections_{0};
    std::atomic<std::uint64_t> answered_{0};
    std::mutex way_mutex_;
    Way way_;
    std::thread thread_;
};

}  // namespace stylet::test
