#include "tests/support/bridge_emulator.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace stylet::test {

namespace {

constexpr std::int64_t kWatchdog_ns = 15'000'000;
// Equal to the driver's timeout for an answer.
constexpr std::int64_t kLostBridgeAnswer_ns = 4'000'000;

template <typename T>
void put(std::vector<std::uint8_t>& out, T value) {
    std::uint8_t bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);  // all supported machines are little-endian
    out.insert(out.end(), bytes, bytes + sizeof value);
}

template <typename T>
T get(std::span<const std::uint8_t> bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

void putText(std::vector<std::uint8_t>& out, std::string text, std::size_t size) {
    text.resize(size, '\0');
    out.insert(out.end(), text.begin(), text.end());
}

std::uint32_t checksum(std::span<const std::uint8_t> bytes) {
    return std::uint32_t(crc32(0, bytes.data(), uInt(bytes.size())));
}

double size(const std::array<double, 3>& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

}  // namespace

std::int64_t monotonicNow_ns() {
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

std::uint32_t BridgeEmulator::random() {
    noise_ = noise_ * 1664525u + 1013904223u;
    return noise_ >> 8;
}

bool BridgeEmulator::receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns,
                             std::vector<std::uint8_t>& out) {
    in_.insert(in_.end(), bytes.begin(), bytes.end());
    while (in_.size() >= 12) {
        const std::size_t whole = 16u + get<std::uint16_t>(in_, 6);
        if (std::memcmp(in_.data(), "STBG", 4) != 0 || in_[4] != 1)
            return complain("not a frame of version 1");
        if (in_.size() < whole) break;
        const std::span<const std::uint8_t> first(in_.data(), whole);
        if (get<std::uint32_t>(first, whole - 4) != checksum(first.first(whole - 4)))
            return complain("checksum");
        if (!frame(first, now_ns, out)) return false;
        in_.erase(in_.begin(), in_.begin() + std::ptrdiff_t(whole));
    }
    return true;
}

bool BridgeEmulator::frame(std::span<const std::uint8_t> bytes, std::int64_t now_ns,
                           std::vector<std::uint8_t>& out) {
    const std::uint8_t type = bytes[5];
    const auto sequence = get<std::uint32_t>(bytes, 8);
    if (sequence != ++last_in_) complaint_ = "a sequence number was left out";
    if (type == 1 && !greeted_ && bytes.size() == 20) {
        greeted_ = true;
        const auto hello = capabilities();
        out.insert(out.end(), hello.begin(), hello.end());
        return true;
    }
    if (type == 5) {
        received_bye_ = true;
        return false;
    }
    if (type != 3 || !greeted_ || bytes.size() != 48) return complain("a frame out of turn");
    force_ns_ = get<std::int64_t>(bytes, 12);
    for (std::size_t i = 0; i < 3; ++i)
        force_n_[i] = get<double>(bytes, 20 + 8 * i);
    if (size(force_n_) == 0.0) tripped_ = false;
    return answer(sequence, script_.time_of_forces ? force_ns_ : now_ns, out);
}

std::array<double, 3> BridgeEmulator::motors_n(std::int64_t now_ns) {
    if (force_ns_ < 0 || now_ns - force_ns_ > kWatchdog_ns) tripped_ = true;
    return tripped_ ? std::array<double, 3>{} : force_n_;
}

double BridgeEmulator::commanded_n() const {
    return size(force_n_);
}

bool BridgeEmulator::answer(std::uint32_t force, std::int64_t now_ns, std::vector<std::uint8_t>& out) {
    motors_n(now_ns);
    const std::uint64_t number = answered_++;
    const bool faulty = number >= script_.from_answer && number < script_.from_answer + script_.answers;
    const BridgeFault fault = faulty ? script_.fault : BridgeFault::none;
    if (fault != BridgeFault::none && fault_began_ns_ == 0) fault_began_ns_ = now_ns;
    if (fault != BridgeFault::none) ++faulty_;

    std::vector<std::uint8_t> bytes;
    if (fault == BridgeFault::garbage) {
        for (int i = 0; i < 96; ++i)
            bytes.push_back(std::uint8_t(random()));
    } else {
        bytes = state(force, now_ns);
    }
    if (fault == BridgeFault::drop) return true;
    if (fault == BridgeFault::duplicate) out.insert(out.end(), bytes.begin(), bytes.end());
    if (fault == BridgeFault::corrupt) bytes[random() % bytes.size()] ^= std::uint8_t(1u << random() % 8);
    if (fault == BridgeFault::disconnect) {
        out.insert(out.end(), bytes.begin(), bytes.begin() + 48);
        return false;
    }
    if (fault == BridgeFault::stall && release_ns_ == 0) release_ns_ = now_ns + script_.stall_ns;
    if (release_ns_ > now_ns) {
        withheld_.insert(withheld_.end(), bytes.begin(), bytes.end());
        return true;
    }
    release(now_ns, out);
    out.insert(out.end(), bytes.begin(), bytes.end());
    return true;
}

void BridgeEmulator::release(std::int64_t now_ns, std::vector<std::uint8_t>& out) {
    if (now_ns < release_ns_) return;
    out.insert(out.end(), withheld_.begin(), withheld_.end());
    withheld_.clear();
}

std::vector<std::uint8_t> BridgeEmulator::sealed(std::uint8_t type, std::vector<std::uint8_t> payload) {
    std::vector<std::uint8_t> bytes{'S', 'T', 'B', 'G', 1, type};
    put(bytes, std::uint16_t(payload.size()));
    put(bytes, ++sent_);
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    put(bytes, checksum(bytes));
    return bytes;
}

std::vector<std::uint8_t> BridgeEmulator::capabilities() {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<std::uint8_t> p{1, 3, 0, 1 | 4, 0, 0, 0, 0};
    for (const double value : {script_.force_peak_n, 0.88, 400.0, 1000.0, nan, nan, nan, 5.5e-5, 0.0, 0.0,
                               0.1, script_.workspace_radius_m})
        put(p, value);
    putText(p, script_.name, 40);
    putText(p, "emulator", 96);
    return sealed(2, p);
}

std::vector<std::uint8_t> BridgeEmulator::state(std::uint32_t force, std::int64_t now_ns) {
    const bool faulty = answered_ > script_.from_answer && answered_ <= script_.from_answer + script_.answers;
    const BridgeFault fault = faulty ? script_.fault : BridgeFault::none;
    std::int64_t sampled_ns = now_ns;
    if (fault == BridgeFault::future) sampled_ns += 1'000'000'000;
    if (fault == BridgeFault::past) sampled_ns -= 1'000'000'000;
    if (fault == BridgeFault::frozen) sampled_ns = frozen_ns_ == 0 ? frozen_ns_ = now_ns : frozen_ns_;
    std::array<double, 3> position = script_.position_m;
    if (moving_ns_ == 0) moving_ns_ = now_ns;
    const double turns = 1e-9 * double(now_ns - moving_ns_) / script_.period_s;
    position[2] += out_m_ - 0.5 * script_.stroke_m * (1.0 - std::cos(2.0 * std::numbers::pi * turns));
    std::array<double, 4> turn{1.0, 0.0, 0.0, 0.0};
    if (placed_) {
        std::copy_n(placed_->begin(), 3, position.begin());
        std::copy_n(placed_->begin() + 3, 4, turn.begin());
    }
    if (fault == BridgeFault::notAUnit) turn = {2.0, 0.0, 0.0, 0.0};
    if (fault == BridgeFault::notFinite) position[random() % 3] = std::numeric_limits<double>::quiet_NaN();
    if (fault == BridgeFault::farAway) position[0] = 1e6;

    std::vector<std::uint8_t> p;
    put(p, fault == BridgeFault::unasked ? force + 1000 : force);
    put(p, std::uint16_t(0));
    put(p, std::uint16_t(1 | (tripped_ ? 2 : 0)));
    put(p, sampled_ns);
    for (const double value : position)
        put(p, value);
    for (const double value : turn)
        put(p, value);
    put(p, buttons_);
    put(p, std::uint32_t(0));
    auto bytes = sealed(4, p);
    const auto reseal = [&bytes] {
        bytes.erase(bytes.end() - 4, bytes.end());
        put(bytes, checksum(bytes));
    };
    if (fault == BridgeFault::tooLong) bytes[6] = bytes[7] = 0xFF, reseal();
    if (fault == BridgeFault::version) bytes[4] = 2, reseal();
    return bytes;
}

int listenOn(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    const int listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    ::unlink(path.c_str());
    if (::bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
        ::listen(listener, 4) != 0)
        throw std::runtime_error("cannot listen on " + path);
    return listener;
}

BridgeServer::BridgeServer(const std::string& path, const BridgeScript& script)
    : script_(script), listener_(listenOn(path)), thread_([this] { run(); }) {}

BridgeServer::~BridgeServer() {
    stop_.store(true);
    thread_.join();
    ::close(listener_);
}

void BridgeServer::run() {
    while (!stop_.load()) {
        pollfd wait{listener_, POLLIN, 0};
        if (::poll(&wait, 1, 5) <= 0) continue;
        const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (client < 0) continue;
        connections_.fetch_add(1);
        serveClient(client);
        ::close(client);
        motor_n_.store(0.0);
    }
}

void BridgeServer::serveClient(int client) {
    BridgeEmulator emulator(script_);
    std::vector<std::uint8_t> out;
    bool on = true;
    while (on && !stop_.load()) {
        pollfd wait{client, POLLIN, 0};
        ::poll(&wait, 1, 1);
        std::uint8_t bytes[4096];
        const ssize_t got = ::recv(client, bytes, sizeof bytes, 0);
        const std::int64_t now_ns = this->now_ns();
        if (got == 0) break;
        emulator.hold(out_m_.load(), buttons_.load());
        {
            const std::lock_guard lock(trajectory_mutex_);
            if (trajectory_) emulator.place(trajectory_(now_ns));
        }
        const std::uint64_t before = emulator.answered(), faulty = emulator.faulty();
        if (got > 0) on = emulator.receive({bytes, std::size_t(got)}, now_ns, out);
        answered_.fetch_add(emulator.answered() - before);
        emulator.release(now_ns, out);
        motor_n_.store(size(emulator.motors_n(now_ns)));
        commanded_n_.store(emulator.commanded_n());
        if (emulator.fault_began_ns() != 0) fault_began_ns_.store(emulator.fault_began_ns());
        received_bye_.store(emulator.receivedBye());
        if (!out.empty()) ::send(client, out.data(), out.size(), MSG_NOSIGNAL);
        out.clear();
        if (script_.time_ns)
            script_.time_ns->fetch_add(std::int64_t(emulator.faulty() - faulty) * kLostBridgeAnswer_ns);
    }
}

}  // namespace stylet::test
