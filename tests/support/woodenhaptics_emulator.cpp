#include "tests/support/woodenhaptics_emulator.h"

#include <algorithm>
#include <cstdlib>

namespace stylet::test {

namespace {

constexpr std::size_t kCommandBytes = 15, kReportBytes = 14;

// The vendor-defined collection of an mbed board: 14 bytes in each direction.
HidIdentity woodenIdentity() {
    return {
        0x1234, 0x0006, "mbed.org", "HID DEVICE", {0x06, 0x00, 0xFF, 0x0A, 0x00, 0x01, 0xA1, 0x01, 0x75, 0x08,
                                                   0x15, 0x00, 0x26, 0xFF, 0x00, 0x95, 0x0E, 0x09, 0x01, 0x81,
                                                   0x02, 0x95, 0x0E, 0x09, 0x02, 0x91, 0x02, 0xC0}};
}

std::int16_t word(const std::vector<unsigned char>& command, std::size_t index) {
    const std::size_t at = 1 + 2 * index;
    return std::int16_t(command[at] + 256 * command[at + 1]);
}

}  // namespace

WoodenHapticsEmulator::WoodenHapticsEmulator() : node_(woodenIdentity()), thread_([this] { run(); }) {}

WoodenHapticsEmulator::~WoodenHapticsEmulator() {
    stop();
}

void WoodenHapticsEmulator::stop() {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
}

void WoodenHapticsEmulator::moveTo(const std::array<std::int16_t, 3>& encoders) {
    const std::lock_guard lock(mutex_);
    std::copy(encoders.begin(), encoders.end(), encoders_.begin());
}

void WoodenHapticsEmulator::turnWristTo(const std::array<std::int16_t, 3>& encoders) {
    const std::lock_guard lock(mutex_);
    std::copy(encoders.begin(), encoders.end(), encoders_.begin() + 3);
}

void WoodenHapticsEmulator::pressButton() {
    const std::lock_guard lock(mutex_);
    button_ = true;
}

void WoodenHapticsEmulator::unplug() {
    stop();
    node_.unplug();
}

void WoodenHapticsEmulator::block() {
    stop();
    node_.block();
}

WoodenHapticsEmulator::CommandLog WoodenHapticsEmulator::commandLog() const {
    const std::lock_guard lock(mutex_);
    return command_log_;
}

std::array<std::int16_t, 6> WoodenHapticsEmulator::encoders() const {
    const std::lock_guard lock(mutex_);
    return encoders_;
}

void WoodenHapticsEmulator::run() {
    bool answered = report();
    while (!stop_.load()) {
        if (!answered) answered = report();
        if (fault_.load() == Fault::deaf) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            continue;
        }
        auto command = node_.receive(kCommandBytes, 10);
        if (!command) continue;
        std::uint64_t count = 1;
        // If several commands are waiting, use the newest one.
        for (; auto newer = node_.receive(kCommandBytes, 0); ++count)
            command = std::move(newer);
        execute(*command);
        if (fault_.load() != Fault::drop) answered = report();
        received_.fetch_add(count);
        if (fault_.load() == Fault::duplicate && answered) answered = sendLast();
    }
}

void WoodenHapticsEmulator::execute(const std::vector<unsigned char>& command) {
    const std::lock_guard lock(mutex_);
    ++command_log_.commands;
    const std::int16_t kind = word(command, 3);
    command_log_.malformed = command_log_.malformed || command[0] != 0 || (kind != 0 && kind != 1);
    command_log_.motor_ma = {};
    if (kind == 1) {
        encoders_ = {word(command, 4), word(command, 5), word(command, 6),
                     word(command, 0), word(command, 1), word(command, 2)};
        button_ = false;
        ++command_log_.calibrations;
        return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        command_log_.motor_ma[i] = word(command, i);
        command_log_.largest_ma = std::max(command_log_.largest_ma, std::abs(command_log_.motor_ma[i]));
    }
    if (command_log_.motor_ma != std::array<int, 3>{}) ++command_log_.powered;
}

bool WoodenHapticsEmulator::report() {
    std::array<unsigned char, kReportBytes> bytes{};
    const Fault fault = fault_.load();
    {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = 0; i < 7; ++i) {
            unsigned value = i < 6 ? unsigned(std::uint16_t(encoders_[i]))
                                   : unsigned(garbled_button_.exchange(false) || button_);
            if (fault == Fault::corrupt && i < 6) value = (noise_ = noise_ * 1664525u + 1013904223u) >> 16;
            bytes[2 * i] = static_cast<unsigned char>(value % 256);
            bytes[2 * i + 1] = static_cast<unsigned char>(value / 256 % 256);
        }
    }
    const std::size_t length = fault == Fault::cut ? kReportBytes - 3 : kReportBytes;
    last_.assign(bytes.begin(), bytes.begin() + std::ptrdiff_t(length));
    return sendLast();
}

bool WoodenHapticsEmulator::sendLast() {
    sending_.store(true);
    const bool sent = node_.send(last_);
    sending_.store(false);
    return sent;
}

}  // namespace stylet::test
