#include "haptics/devices/bridge/bridge.h"

#include <array>
#include <cstdlib>

#include "haptics/devices/bridge/link.h"

namespace stylet::haptics {

namespace {

// Maximum number of socket reads in one call of receive(), each of up to 4 KiB. The bridge answers each force
// with one message of 96 bytes. If more than 64 KiB are waiting, the bridge is faulty and the connection
// fails.
constexpr int kMostReads = 16;

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
    profile_.source = "no bridge has answered yet: taken for a Touch";
}

BridgeDriver::~BridgeDriver() {
    close();
}

DeviceStage BridgeDriver::open(std::string& why) {
    close();
    const DeviceStage stage = connect(why);
    if (stage != DeviceStage::opening) return stage;
    link_ = std::make_unique<bridge::Link>();
    return greet(why);
}

DeviceStage BridgeDriver::connect(std::string& why) {
    switch (socket_.connect(settings_.socket_path, why)) {
        case LocalSocket::Connected::yes:
            return DeviceStage::opening;
        case LocalSocket::Connected::nobodyListens:
            why = "no bridge listens on " + settings_.socket_path;
            return DeviceStage::absent;
        case LocalSocket::Connected::failed:
            break;
    }
    return DeviceStage::failed;
}

DeviceStage BridgeDriver::greet(std::string& why) {
    const std::int64_t deadline_ns = now() + settings_.greeting_ns;
    if (!socket_.sendWhole(link_->hello().span())) return refused(why);
    while (!link_->introduced()) {
        if (!receive(why) || !sound(why)) return DeviceStage::failed;
        const std::int64_t left_ns = deadline_ns - now();
        if (link_->introduced()) break;
        if (left_ns <= 0) return fail(why, "the bridge does not introduce itself");
        socket_.waitReadable(left_ns);
    }
    const bridge::Capabilities& said = link_->capabilities();
    if (name_.empty()) {
        // Written only once, because other threads may read these strings from now on.
        name_ = said.name.data();
        source_ = said.source.data();
    } else if (name_ != said.name.data()) {
        return fail(why, "another device answers: " + std::string(said.name.data()));
    }
    profile_ = said.profile;
    profile_.name = name_.c_str();
    profile_.source = source_.c_str();
    return DeviceStage::opening;
}

DeviceStage BridgeDriver::exchange(const Vec3& force_n, DeviceState& state, std::string& why) {
    const std::int64_t began_ns = now();
    if (!socket_.sendWhole(link_->force(force_n, began_ns).span())) return refused(why);
    bridge::State said;
    while (true) {
        if (!receive(why) || !sound(why)) return DeviceStage::failed;
        state.fresh = link_->take(said);
        const std::int64_t left_ns = began_ns + settings_.answer_ns - now();
        if (state.fresh || left_ns <= 0) break;
        socket_.waitReadable(left_ns);
    }
    if (link_->counts().states == 0) {
        state.flags = 0;
        why = "the bridge has not answered yet";
        return DeviceStage::opening;
    }
    const bool on = said.motors == bridge::MotorStage::on;
    state.device_from_stylus = said.device_from_stylus;
    state.buttons = said.buttons;
    state.flags = (on && !said.watchdog ? kDeviceReady : 0u) |
                  (said.hand_on || !profile_.has_dead_man ? kDeviceHandOn : 0u);
    if (on && !said.watchdog) return DeviceStage::ready;
    if (on) why = "the bridge's watchdog cut the force";
    if (said.motors == bridge::MotorStage::off) why = "the device has switched its motors off";
    if (said.motors == bridge::MotorStage::needsHoming) why = "calibrate the device as its maker says";
    return said.motors == bridge::MotorStage::needsHoming ? DeviceStage::needsHoming : DeviceStage::opening;
}

// Call after a failed send. Reads the frames that the bridge has already sent, because one of them may say
// why it stopped. Sets `why` and returns DeviceStage::failed.
DeviceStage BridgeDriver::refused(std::string& why) {
    if (!receive(why) || !sound(why)) return DeviceStage::failed;
    return fail(why, "the bridge accepts no more data");
}

// Returns false if the connection is gone. Data received earlier is processed first, because it may contain
// the reason.
bool BridgeDriver::receive(std::string& why) {
    std::array<std::uint8_t, 4096> bytes;
    std::span<const std::uint8_t> got;
    for (int turn = 0; turn < kMostReads; ++turn) {
        std::string reason;
        switch (socket_.receive(bytes, got, reason)) {
            case LocalSocket::Received::bytes:
                link_->receive(got, now());
                if (link_->fault() != bridge::LinkFault::none) return sound(why);
                break;
            case LocalSocket::Received::nothingYet:
                return true;
            case LocalSocket::Received::ended:
                fail(why, "the bridge is gone" + (reason.empty() ? "" : ": " + reason));
                return false;
        }
    }
    fail(why, "a flood from the bridge: more than can be answers");
    return false;
}

bool BridgeDriver::sound(std::string& why) {
    link_->watch(now());
    const bridge::LinkFault fault = link_->fault();
    if (fault == bridge::LinkFault::none) return true;
    std::string reason = bridge::describe(fault);
    if (fault == bridge::LinkFault::bye) reason += std::string(": ") + link_->reason();
    fail(why, reason);
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
        socket_.sendWhole(link_->force(Vec3(0.0), now()).span());
        socket_.sendWhole(link_->bye("closed by Stylet").span());
    }
    socket_.close();
    link_.reset();
}

}  // namespace stylet::haptics
