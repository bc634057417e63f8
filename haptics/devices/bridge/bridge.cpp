#include "haptics/devices/bridge/bridge.h"

#include <array>
#include <cstdlib>

#include "haptics/devices/bridge/link.h"

namespace stylet::haptics {

namespace {

// Maximum number of socket reads in one call of receive(), each of up to 4 KiB. The bridge answers each force
// with one message of 96 bytes. If more than 64 KiB are waiting, the bridge is faulty and the connection
// fails.
constexpr int kMaxReads = 16;

}  // namespace

std::string bridgeSocketPath() {
    if (const char* path = std::getenv("STYLET_BRIDGE_SOCKET")) return path;
    return userSocketFolder() + "/stylet-bridge.sock";
}

BridgeDriver::BridgeDriver(const Clock& clock, const BridgeSettings& settings)
    : clock_(clock), settings_(settings) {
    if (settings_.socket_path.empty()) settings_.socket_path = bridgeSocketPath();
    profile_.name = "bridge";
    profile_.force_peak_n = kWeakestForce_n;
    profile_.stiffness_n_per_m = kWeakestStiffness_n_per_m;
    profile_.source = "no bridge has answered yet: treated as a Touch";
}

BridgeDriver::~BridgeDriver() {
    close();
}

DeviceStage BridgeDriver::open(std::string& why) {
    close();
    const DeviceStage stage = socket_.connect(settings_.socket_path, why);
    if (stage != DeviceStage::opening) return stage;
    link_ = std::make_unique<bridge::Link>();
    return greet(why);
}

DeviceStage BridgeDriver::greet(std::string& why) {
    const std::int64_t deadline_ns = now() + settings_.greeting_ns;
    if (!socket_.sendAll(link_->hello().span())) return sendFailed(why);
    while (!link_->hasCapabilities()) {
        if (!receive(why) || !checkLink(why)) return DeviceStage::failed;
        const std::int64_t left_ns = deadline_ns - now();
        if (link_->hasCapabilities()) break;
        if (left_ns <= 0) return fail(why, "the bridge does not send its capabilities");
        socket_.waitReadable(left_ns);
    }
    const bridge::Capabilities& received = link_->capabilities();
    if (name_.empty()) {
        // Written only once, because other threads may read these strings from now on.
        name_ = received.name.data();
        source_ = received.source.data();
    } else if (name_ != received.name.data()) {
        return fail(why, "another device answers: " + std::string(received.name.data()));
    }
    profile_ = received.profile;
    profile_.name = name_.c_str();
    profile_.source = source_.c_str();
    return DeviceStage::opening;
}

DeviceStage BridgeDriver::exchange(const Vec3& force_n, DeviceState& state, std::string& why) {
    const std::int64_t began_ns = now();
    if (!socket_.sendAll(link_->force(force_n, began_ns).span())) return sendFailed(why);
    bridge::State received;
    while (true) {
        if (!receive(why) || !checkLink(why)) return DeviceStage::failed;
        state.fresh = link_->readState(received);
        const std::int64_t left_ns = began_ns + settings_.answer_ns - now();
        if (state.fresh || left_ns <= 0) break;
        socket_.waitReadable(left_ns);
    }
    if (link_->counts().states == 0) {
        state.flags = 0;
        why = "the bridge has not answered yet";
        return DeviceStage::opening;
    }
    const bool on = received.motors == bridge::MotorStage::on;
    state.device_from_stylus = received.device_from_stylus;
    state.buttons = received.buttons;
    state.flags = (on && !received.watchdog ? kDeviceReady : 0u) |
                  (received.hand_on || !profile_.has_dead_man ? kDeviceHandOn : 0u);
    if (received.motors == bridge::MotorStage::needsHoming) {
        why = "calibrate the device as described by its maker";
        return DeviceStage::needsHoming;
    }
    if (on && !received.watchdog) return DeviceStage::ready;
    why = on ? "the bridge's watchdog cut the force" : "the device has switched its motors off";
    return DeviceStage::opening;
}

// Call after a failed send. Reads the frames that the bridge has already sent, because one of them may say
// why it stopped. Sets `why` and returns DeviceStage::failed.
DeviceStage BridgeDriver::sendFailed(std::string& why) {
    if (!receive(why) || !checkLink(why)) return DeviceStage::failed;
    return fail(why, "the bridge accepts no more data");
}

// Returns false if the connection is gone. Data received earlier is processed first, because it may contain
// the reason.
bool BridgeDriver::receive(std::string& why) {
    std::array<std::uint8_t, 4096> bytes;
    std::span<const std::uint8_t> got;
    for (int turn = 0; turn < kMaxReads; ++turn) {
        std::string reason;
        switch (socket_.receive(bytes, got, reason)) {
            case LocalSocket::Received::bytes:
                link_->receive(got, now());
                if (link_->fault() != bridge::LinkFault::none) return checkLink(why);
                break;
            case LocalSocket::Received::noData:
                return true;
            case LocalSocket::Received::ended:
                fail(why, "the bridge is gone" + (reason.empty() ? "" : ": " + reason));
                return false;
        }
    }
    fail(why, "the bridge sent more data than its answers can be: restart it");
    return false;
}

bool BridgeDriver::checkLink(std::string& why) {
    link_->checkTimeout(now());
    const bridge::LinkFault fault = link_->fault();
    if (fault == bridge::LinkFault::none) return true;
    const std::string farewell = fault == bridge::LinkFault::bye ? std::string(": ") + link_->reason() : "";
    fail(why, std::string(bridge::describe(fault)) + farewell);
    return false;
}

DeviceStage BridgeDriver::fail(std::string& why, const std::string& reason) {
    why = reason;
    close();
    return DeviceStage::failed;
}

void BridgeDriver::close() noexcept {
    if (!socket_.isOpen()) return;
    if (link_) {
        socket_.sendAll(link_->force(Vec3(0.0), now()).span());
        socket_.sendAll(link_->bye("closed by Stylet").span());
    }
    socket_.close();
    link_.reset();
}

}  // namespace stylet::haptics
