#include "haptics/devices/bridge.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "haptics/devices/bridge/link.h"

namespace stylet::haptics {

namespace {

// In one go. Each force has one answer of 96 bytes: 64 KiB are nobody's answers.
constexpr int kMostReads = 16;

std::int64_t monotonic_ns() noexcept {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return std::int64_t(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

void waitReadable(int socket, std::int64_t for_ns) noexcept {
    pollfd wait{socket, POLLIN, 0};
    const timespec limit{time_t(for_ns / 1'000'000'000), long(for_ns % 1'000'000'000)};
    ppoll(&wait, 1, &limit, nullptr);
}

// Whole or not at all: a bridge that lets the socket fill up has been silent for long.
bool sendWhole(int socket, std::span<const std::uint8_t> bytes) noexcept {
    const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    return sent == ssize_t(bytes.size());
}

// Whoever else could have put a socket there must not move a trainee's hand.
bool trusted(int socket) noexcept {
    ucred peer{};
    socklen_t size = sizeof peer;
    return getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 &&
           (peer.uid == geteuid() || peer.uid == 0);
}

}  // namespace

std::string bridgeSocketPath() {
    if (const char* path = std::getenv("STYLET_BRIDGE_SOCKET")) return path;
    const char* folder = std::getenv("XDG_RUNTIME_DIR");
    return (folder ? std::string(folder) : "/run/user/" + std::to_string(geteuid())) + "/stylet-bridge.sock";
}

BridgeDriver::BridgeDriver(const BridgeSettings& settings) : settings_(settings) {
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
    const std::string& path = settings_.socket_path;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) return fail(why, path + ": too long for a socket's path");
    std::memcpy(address.sun_path, path.c_str(), path.size());

    socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket_ < 0) return fail(why, std::string("no socket: ") + std::strerror(errno));
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        const int error = errno;
        fail(why, path + ": " + std::strerror(error));
        if (error != ENOENT && error != ECONNREFUSED) return DeviceStage::failed;
        why = "no bridge listens on " + path;
        return DeviceStage::absent;
    }
    if (!trusted(socket_)) return fail(why, path + ": the bridge runs as another user");
    return DeviceStage::opening;
}

DeviceStage BridgeDriver::greet(std::string& why) {
    const std::int64_t deadline_ns = monotonic_ns() + settings_.greeting_ns;
    if (!sendWhole(socket_, link_->hello().span())) return refused(why);
    while (!link_->introduced()) {
        if (!receive(why) || !sound(why)) return DeviceStage::failed;
        const std::int64_t left_ns = deadline_ns - monotonic_ns();
        if (link_->introduced()) break;
        if (left_ns <= 0) return fail(why, "the bridge does not introduce itself");
        waitReadable(socket_, left_ns);
    }
    const bridge::Capabilities& said = link_->capabilities();
    if (name_.empty()) {
        // Others may be reading the texts from now on: they are written once.
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
    const std::int64_t began_ns = monotonic_ns();
    if (!sendWhole(socket_, link_->force(force_n, began_ns).span())) return refused(why);
    bridge::State said;
    while (true) {
        if (!receive(why) || !sound(why)) return DeviceStage::failed;
        state.fresh = link_->take(said);
        const std::int64_t left_ns = began_ns + settings_.answer_ns - monotonic_ns();
        if (state.fresh || left_ns <= 0) break;
        waitReadable(socket_, left_ns);
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
    if (on) why = "the bridge's watchdog took the force";
    if (said.motors == bridge::MotorStage::off) why = "the device has switched its motors off";
    if (said.motors == bridge::MotorStage::needsHoming) why = "calibrate the device as its maker says";
    return said.motors == bridge::MotorStage::needsHoming ? DeviceStage::needsHoming : DeviceStage::opening;
}

// Nothing can be sent any more. Its last words may say why.
DeviceStage BridgeDriver::refused(std::string& why) {
    if (!receive(why) || !sound(why)) return DeviceStage::failed;
    return fail(why, "the bridge takes nothing more");
}

// False when the connection is gone. What had come before is taken first: it may be the reason.
bool BridgeDriver::receive(std::string& why) {
    std::array<std::uint8_t, 4096> bytes;
    for (int turn = 0; turn < kMostReads; ++turn) {
        const ssize_t got = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (got > 0) {
            link_->receive({bytes.data(), std::size_t(got)}, monotonic_ns());
            if (link_->fault() != bridge::LinkFault::none) return sound(why);
        } else if (got < 0 && errno == EINTR) {
            continue;
        } else if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
            return true;
        } else {
            fail(why, got == 0 ? "the bridge is gone"
                               : std::string("the bridge is gone: ") + std::strerror(errno));
            return false;
        }
    }
    fail(why, "a flood from the bridge: more than can be answers");
    return false;
}

bool BridgeDriver::sound(std::string& why) {
    link_->watch(monotonic_ns());
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
    if (socket_ < 0) return;
    if (link_) {
        sendWhole(socket_, link_->force(Vec3(0.0), monotonic_ns()).span());
        sendWhole(socket_, link_->bye("closed by Stylet").span());
    }
    ::close(socket_);
    socket_ = -1;
    link_.reset();
}

}  // namespace stylet::haptics
