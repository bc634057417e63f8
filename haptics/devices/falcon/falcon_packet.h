// Protocol of the Falcon's running firmware: packets of 16 bytes, one reply per write.
//
// Facts from libnifalcon's FalconFirmwareNovintSDK.cpp. Byte 0 '<'; 1-12 three int16 as four nibbles each,
// the least significant first, a nibble sent as 'A' + nibble; 13 'A' + flags; 14 unknown; 15 '>'. There is
// no checksum and no sequence number.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace stylet::haptics::falcon {

inline constexpr std::size_t kPacketBytes = 16;
using Packet = std::array<std::uint8_t, kPacketBytes>;

// Colours as in libnifalcon's code; its comments disagree (unproven).
enum Led : std::uint8_t { kLedGreen = 0x02, kLedBlue = 0x04, kLedRed = 0x08 };
enum Button : std::uint8_t {
    kButtonRight = 0x01,  // plus
    kButtonCentre = 0x04,
};
inline constexpr std::uint8_t kHomedAll = 0x7;  // top, right, left encoder

// To the device.
struct Command {
    std::array<std::int16_t, 3> motors{};
    bool homing = true;  // if one packet omits this bit, the device loses its zero position
    std::uint8_t leds = 0;
};
Packet encode(const Command&) noexcept;

// From the device.
struct Reply {
    std::array<std::int16_t, 3> encoders{};
    std::uint8_t buttons = 0, homed = 0;
};
// Empty unless every byte is one that the firmware can send.
std::optional<Reply> decode(const Packet&) noexcept;

// Finds replies in a stream that may start anywhere and lose or repeat bytes. '<' occurs only as the first
// byte.
class PacketReader {
  public:
    // Returns the newest complete reply in `bytes` and the bytes pushed earlier.
    std::optional<Reply> push(std::span<const std::uint8_t> bytes) noexcept;
    // Discards a partial reply.
    void clear() noexcept;
    // Number of bytes and packets that did not belong to a valid reply.
    std::uint64_t refused() const noexcept { return refused_; }

  private:
    Packet packet_{};
    std::size_t count_ = 0;
    std::uint64_t refused_ = 0;
};

}  // namespace stylet::haptics::falcon
