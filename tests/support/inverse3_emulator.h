// Emulates Haply's Inverse Service as its documentation describes it: a WebSocket (RFC 6455) on a loopback
// port, implemented without any library, and GET /version. It can inject faults.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace stylet::test {

enum class Inverse3Fault {
    none,
    drop,        // messages are not answered
    duplicate,   // answered twice
    stall,       // answers are withheld, then sent all at once
    cut,         // half of a WebSocket frame, then the connection is reset
    close,       // a close frame
    brokenJson,  // a message that ends early
    flipped,     // one bit of the text flipped
    notFinite,   // NaN
    huge,        // 1e999
    farAway,     // a position outside every room
    wrongType,   // a position of strings
    noPosition,
    notAUnit,   // a quaternion of length 2
    deep,       // a hundred thousand brackets
    big,        // a message of 300 KiB
    binary,     // a binary message
    masked,     // a masked frame, which only clients may send
    unplugged,  // the device is no longer in the list
    otherDevice,
    uncalibrated,
    noPower,
    gripMissing,
    pings,      // control frames before the answer
    fragments,  // the answer in pieces of 100 bytes
    flood,      // endless valid answers, until the driver hangs up
};
inline constexpr int kInverse3FaultCount = int(Inverse3Fault::flood) + 1;

struct Inverse3Script {
    Inverse3Fault fault = Inverse3Fault::none;
    std::uint64_t from_answer = 0, answers = 1'000'000'000;
    int stall_ms = 1000;
    // The driver's clock, if a test steps it. The duration of a fault is measured on this clock. A lost
    // answer advances it by the driver's whole timeout. Null: the machine's clock.
    std::atomic<std::int64_t>* time_ns = nullptr;
    std::string version = "3.5.0.0";  // empty: GET /version returns 404
    bool data_envelope = false;       // wrap the answer to GET, as version 3.5 does
    std::string device_id = "049D";
    bool device = true, grip = true;
    std::array<double, 3> cursor_m{0.01, -0.12, 0.15};
    std::array<double, 4> grip_wxyz{1.0, 0.0, 0.0, 0.0};
};

class Inverse3Emulator {
  public:
    explicit Inverse3Emulator(const Inverse3Script&);
    ~Inverse3Emulator();
    Inverse3Emulator(const Inverse3Emulator&) = delete;
    Inverse3Emulator& operator=(const Inverse3Emulator&) = delete;

    unsigned short port() const { return port_; }
    // Moves the hand to `out_m` toward the user (-y) from the script's position.
    void hold(double out_m) { out_m_.store(out_m); }
    // The last force command in this version's message format; NaN before the first.
    std::array<double, 3> force_n() const;
    std::uint64_t answered() const { return answered_.load(); }
    std::int64_t fault_began_ns() const { return fault_began_ns_.load(); }
    int connections() const { return connections_.load(); }
    std::string complaint() const;  // error in the driver's bytes

  private:
    std::int64_t now_ns() const;
    void run();
    void serve(int client);
    void serveClient(int client);
    bool answer(int client);
    bool flood(int client, const std::vector<std::uint8_t>& message);
    std::string state(bool inventory, Inverse3Fault) const;
    void command(const std::string& message);
    void complain(const std::string& what);

    Inverse3Script script_;
    int listener_ = -1;
    unsigned short port_ = 0;
    mutable std::mutex mutex_;
    std::array<double, 3> force_n_;
    std::string complaint_;
    std::vector<std::uint8_t> withheld_;
    std::int64_t release_ns_ = 0;
    std::atomic<bool> stop_{false};
    std::atomic<double> out_m_{0.0};
    std::atomic<int> connections_{0};
    std::atomic<std::uint64_t> answered_{0};
    std::atomic<std::int64_t> fault_began_ns_{0};
    std::thread thread_;
};

// The two functions of RFC 6455 for which its text has examples.
std::string webSocketAccept(const std::string& key);
std::vector<std::uint8_t> unmask(std::span<const std::uint8_t> frame);  // payload of a short client frame

}  // namespace stylet::test
