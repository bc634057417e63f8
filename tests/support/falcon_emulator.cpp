#include "tests/support/falcon_emulator.h"

#include <algorithm>
#include <utility>

namespace stylet::test {

namespace {

// Appends a number as four letters of four bits each. 'A' is 0; the lowest four bits come first.
void putNumber(std::vector<std::uint8_t>& out, int number) {
    for (int i = 0; i < 4; ++i, number >>= 4)
        out.push_back(std::uint8_t('A' + (number & 15)));
}

int getNumber(const std::uint8_t* letters) {
    int number = 0;
    for (int i = 3; i >= 0; --i)
        number = number * 16 + (letters[i] - 'A');
    return number < 32768 ? number : number - 65536;
}

// Returns true and decrements `count` if it is above 0.
bool consume(int& count) {
    return count > 0 && count-- > 0;
}

}  // namespace

void FalconEmulator::control(std::uint8_t request, std::uint16_t value) {
    if (request == 0 && value == 1) to_host_.clear();
    if (request == 1 && (value & 0x0100) != 0) {
        const bool high = (value & 1) != 0;
        reset_seen_ = high && !data_terminal_ready_;  // the rising edge starts the firmware loader
        if (reset_seen_) loader_ = Loader::waiting;
        data_terminal_ready_ = high;
    }
    if (request == 3) {
        baud_ = value;
        if (value == 2 && loader_ == Loader::loading && image_.size() == image_bytes) {
            running_ = true;
            homed_ = 0;
            loader_ = Loader::waiting;
        }
    }
    if (request == 4) line_ = value;
    if (request == 9) latency_ms_ = value;
}

void FalconEmulator::powerCycle() {
    running_ = false;
    homed_ = 0;
    motors_ = {};
    image_.clear();
    to_host_.clear();
    packet_.clear();
    loader_ = Loader::waiting;
}

void FalconEmulator::bulkOut(std::span<const std::uint8_t> bytes, std::int64_t t_ns) {
    for (const std::uint8_t byte : bytes) {
        if (faults.unplugged) return;
        if (faults.unplug_after_bytes >= 0 && faults.unplug_after_bytes-- == 0) {
            faults.unplugged = true;
            return;
        }
        if (running_ && baud_ == 2)
            firmwareByte(byte, t_ns);
        else if (!running_)
            loaderByte(byte);
    }
}

std::vector<std::uint8_t> FalconEmulator::bulkIn() {
    std::vector<std::uint8_t> packet{0x01, 0x60};  // modem and line status
    while (!to_host_.empty() && packet.size() < 64) {
        packet.push_back(to_host_.front());
        to_host_.pop_front();
    }
    return packet;
}

void FalconEmulator::queue(std::vector<std::uint8_t> bytes) {
    to_host_.insert(to_host_.end(), bytes.begin(), bytes.end());
}

void FalconEmulator::loaderByte(std::uint8_t byte) {
    switch (loader_) {
        case Loader::waiting:
            if (baud_ != 0x4138 || latency_ms_ != 16 || line_ != 8 || !reset_seen_ || faults.never_greets)
                return;
            greeting_.push_back(byte);
            if (greeting_.size() > 3) greeting_.erase(greeting_.begin());
            if (greeting_ != std::vector<std::uint8_t>{0x0A, 0x43, 0x0D}) return;
            greeting_.clear();
            queue({0x0A, 0x44, 0x2C, 0x0D});
            loader_ = Loader::greeted;
            return;
        case Loader::greeted:
            if (baud_ != 0x15 || data_terminal_ready_ || byte != 0x41) return;
            queue({0x41});
            image_.clear();
            loader_ = Loader::loading;
            return;
        case Loader::loading:
            if (baud_ != 0x15) return;
            if (consume(faults.no_echoes)) {
                loader_ = Loader::waiting;
                return;
            }
            image_.push_back(byte);
            if (consume(faults.wrong_echoes)) byte ^= 0x10;
            queue({byte});
            return;
    }
}

void FalconEmulator::firmwareByte(std::uint8_t byte, std::int64_t) {
    if (byte == '<') {
        bad_packets += !packet_.empty();
        packet_.clear();
    } else if (packet_.empty()) {
        ++bad_packets;
        return;
    }
    packet_.push_back(byte);
    if (packet_.size() < 16) return;
    const bool letters = std::all_of(packet_.begin() + 1, packet_.begin() + 15,
                                     [](std::uint8_t b) { return b >= 'A' && b < 'A' + 16; });
    if (packet_[15] == '>' && letters)
        processPacket();
    else
        ++bad_packets;
    packet_.clear();
}

void FalconEmulator::processPacket() {
    ++packets;
    for (std::size_t i = 0; i < 3; ++i)
        motors_[i] = getNumber(packet_.data() + 1 + 4 * i);
    const int flags = packet_[13] - 'A';
    homing_ = (flags & 1) != 0;
    leds_ = flags & 0xE;
    if (!homing_) homed_ = 0;
    reply();
}

void FalconEmulator::reply() {
    queue(std::exchange(late_, {}));
    if (faults.silent) return;
    std::vector<std::uint8_t> bytes{'<'};
    for (const int count : counts_)
        putNumber(bytes, homed_ == 7 ? count : count + 3000);  // the zero point jumps when homing completes
    bytes.push_back(std::uint8_t('A' + (buttons_ | homed_ << 4)));
    bytes.push_back('A');
    bytes.push_back('>');
    if (consume(faults.drop)) return;
    if (consume(faults.xor_count)) bytes[std::size_t(faults.xor_byte)] ^= faults.xor_mask;
    if (consume(faults.cut)) bytes.erase(bytes.begin() + 4);
    if (consume(faults.late)) {
        late_ = bytes;
        return;
    }
    queue(bytes);
    if (consume(faults.repeat)) queue(bytes);
}

}  // namespace stylet::test
