#include "haptics/devices/falcon/falcon_packet.h"

namespace stylet::haptics::falcon {

namespace {

constexpr std::uint8_t kPacketBegin = '<', kPacketEnd = '>', kZero = 'A';

bool isNibble(std::uint8_t byte) noexcept {
    return byte >= kZero && byte <= kZero + 0xF;
}

}  // namespace

Packet encode(const Command& command) noexcept {
    Packet packet{};
    packet[0] = kPacketBegin;
    for (std::size_t i = 0; i < 12; ++i) {
        const unsigned bits = std::uint16_t(command.motors[i / 4]);
        packet[1 + i] = std::uint8_t(kZero + (bits >> (4 * (i % 4)) & 0xF));
    }
    packet[13] = std::uint8_t(kZero + ((command.leds & 0xE) | (command.homing ? 1 : 0)));
    packet[14] = kZero;
    packet[15] = kPacketEnd;
    return packet;
}

std::optional<Reply> decode(const Packet& packet) noexcept {
    if (packet[0] != kPacketBegin || packet[15] != kPacketEnd || !isNibble(packet[14])) return std::nullopt;
    Reply reply;
    unsigned bits[3] = {};
    for (std::size_t i = 0; i < 12; ++i) {
        if (!isNibble(packet[1 + i])) return std::nullopt;
        bits[i / 4] |= unsigned(packet[1 + i] - kZero) << (4 * (i % 4));
    }
    for (std::size_t i = 0; i < 3; ++i)
        reply.encoders[i] = std::int16_t(std::uint16_t(bits[i]));
    // Four buttons and three homed bits: at most 0x7F.
    if (packet[13] < kZero || packet[13] > kZero + 0x7F) return std::nullopt;
    const unsigned flags = packet[13] - kZero;
    reply.buttons = std::uint8_t(flags & 0xF);
    reply.homed = std::uint8_t(flags >> 4);
    return reply;
}

std::optional<Reply> PacketReader::push(std::span<const std::uint8_t> bytes) noexcept {
    std::optional<Reply> newest;
    for (const std::uint8_t byte : bytes) {
        if (byte == kPacketBegin) {
            if (count_ != 0) ++refused_;
            count_ = 0;
        } else if (count_ == 0) {
            ++refused_;
            continue;
        }
        packet_[count_++] = byte;
        if (count_ < kPacketBytes) continue;
        count_ = 0;
        if (const auto reply = decode(packet_))
            newest = reply;
        else
            ++refused_;
    }
    return newest;
}

void PacketReader::clear() noexcept {
    if (count_ != 0) ++refused_;
    count_ = 0;
}

}  // namespace stylet::haptics::falcon
