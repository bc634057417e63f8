// Emulates a bridge, the driver's peer. It was written only from haptics/devices/bridge/README.md: it shares
// no header with the driver and uses zlib's checksum. It can inject faults.
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
    drop,        // answers are not sent
    duplicate,   // sent twice
    corrupt,     // one bit is flipped
    stall,       // answers are withheld, then sent all at once
    disconnect,  // sends half a frame, then closes the connection
    notFinite,   // a NaN with a valid checksum
    farAway,     // a position outside every room
    notAUnit,    // a quaternion of length 2
    future,      // the bridge's clock jumps a second ahead
    past,        // the bridge's clock jumps a second back
    frozen,      // the device delivers no new sample
    tooLong,     // a length of 65,535
    version,     // version 2
    unasked,     // answers a force that was never sent
    garbage,     // random bytes
};
inline constexpr int kBridgeFaultCount = int(BridgeFault::garbage) + 1;

struct BridgeScript {
    BridgeFault fault = BridgeFault::none;
    std::uint64_t from_answer = 0, answers = 1;  // the first faulty answer, and their number
    std::int64_t stall_ns = 0;
    std::uint32_t seed = 1;
    std::array<double, 3> position_m{0.0, 0.0, 0.1};
    double stroke_m = 0.0, period_s = 1.0;  // the stylus moves along -z by the stroke and back
    double force_peak_n = 3.3;
    double workspace_radius_m = 0.08;
    std::string name = "emulated Touch";
    // The clock that BridgeServer reads, if a test steps it. A faulty answer advances it by the driver's
    // whole timeout. Null: CLOCK_MONOTONIC.
    std::atomic<std::int64_t>* time_ns = nullptr;
    bool time_of_forces = false;  // the clock is the newest force message (driver in another process)
};

// The protocol without a socket: bytes and times go in, bytes come out.
class BridgeEmulator {
  public:
    explicit BridgeEmulator(const BridgeScript& script) : script_(script), noise_(script.seed) {}
    // Processes bytes from the driver and appends the answer to `out`. Returns false if the connection must
    // then be closed.
    bool receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns, std::vector<std::uint8_t>& out);
    // Appends withheld answers that are due.
    void release(std::int64_t now_ns, std::vector<std::uint8_t>& out);

    // Replaces the script's motion with a fixed stylus pose: position, and quaternion w x y z.
    void place(const std::array<double, 7>& device_from_stylus) { placed_ = device_from_stylus; }
    // Sets the hand's offset from the script's position, and the pressed buttons.
    void hold(double out_m, std::uint32_t buttons) { out_m_ = out_m, buttons_ = buttons; }

    // Force of the motors. The watchdog sets it to zero 15 ms after the last force message. It stays zero
    // until a force message with zero force arrives.
    std::array<double, 3> motors_n(std::int64_t now_ns);
    double commanded_n() const;  // magnitude of the last force received
    std::uint64_t answered() const { return answered_; }
    std::int64_t fault_began_ns() const { return fault_began_ns_; }  // 0: not yet
    std::uint64_t faulty() const { return faulty_; }                 // faulty answers so far
    const std::string& complaint() const { return complaint_; }      // error in the driver's bytes
    bool receivedBye() const { return received_bye_; }

  private:
    bool frame(std::span<const std::uint8_t> bytes, std::int64_t now_ns, std::vector<std::uint8_t>& out);
    bool answer(std::uint32_t force, std::int64_t now_ns, std::vector<std::uint8_t>& out);
    std::vector<std::uint8_t> sealed(std::uint8_t type, std::vector<std::uint8_t> payload);
    std::vector<std::uint8_t> capabilities();
    std::vector<std::uint8_t> state(std::uint32_t force, std::int64_t now_ns);
    std::uint32_t random();
    bool complain(const char* what) { return complaint_ = what, false; }

    BridgeScript script_;
    std::vector<std::uint8_t> in_, withheld_;
    std::int64_t release_ns_ = 0, fault_began_ns_ = 0, frozen_ns_ = 0, moving_ns_ = 0;
    std::uint32_t sent_ = 0, noise_, last_in_ = 0;
    std::uint64_t answered_ = 0, faulty_ = 0;
    bool greeted_ = false, received_bye_ = false, tripped_ = true;
    std::array<double, 3> force_n_{};
    std::int64_t force_ns_ = -1;
    double out_m_ = 0.0;
    std::uint32_t buttons_ = 0;
    std::optional<std::array<double, 7>> placed_;
    std::string complaint_;
};

std::int64_t monotonicNow_ns();

// A UNIX socket that listens on this path. Throws std::runtime_error.
int listenOn(const std::string& path);

// BridgeEmulator on a UNIX socket, on its own thread. Serves one connection at a time and restarts the script
// for each.
class BridgeServer {
  public:
    BridgeServer(const std::string& path, const BridgeScript&);
    ~BridgeServer();
    BridgeServer(const BridgeServer&) = delete;
    BridgeServer& operator=(const BridgeServer&) = delete;

    // Moves the hand to `out_m` along +z from the script's position and presses these buttons.
    void hold(double out_m, std::uint32_t buttons = 0) { out_m_.store(out_m), buttons_.store(buttons); }
    // `trajectory` gives the stylus pose from now on. Its argument is a time of CLOCK_MONOTONIC. It is called
    // on the server's thread.
    using Trajectory = std::function<std::array<double, 7>(std::int64_t now_ns)>;
    void follow(Trajectory trajectory) {
        const std::lock_guard lock(trajectory_mutex_);
        trajectory_ = std::move(trajectory);
    }
    std::int64_t fault_began_ns() const { return fault_began_ns_.load(); }
    double motor_n() const { return motor_n_.load(); }  // magnitude of the motors' force
    double commanded_n() const {
        return commanded_n_.load();
    }  // magnitude of the last force received, however old
    int connections() const { return connections_.load(); }
    std::uint64_t answered() const { return answered_.load(); }  // over all connections
    bool receivedBye() const { return received_bye_.load(); }

  private:
    std::int64_t now_ns() const { return script_.time_ns ? script_.time_ns->load() : monotonicNow_ns(); }
    void run();
    void serveClient(int client);

    BridgeScript script_;
    int listener_ = -1;
    std::atomic<bool> stop_{false}, received_bye_{false};
    std::atomic<std::int64_t> fault_began_ns_{0};
    std::atomic<double> motor_n_{0.0}, commanded_n_{0.0}, out_m_{0.0};
    std::atomic<std::uint32_t> buttons_{0};
    std::atomic<int> connections_{0};
    std::atomic<std::uint64_t> answered_{0};
    std::mutex trajectory_mutex_;
    Trajectory trajectory_;
    std::thread thread_;
};

}  // namespace stylet::test
