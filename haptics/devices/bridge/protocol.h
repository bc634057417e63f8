// The frames between Stylet and a bridge, byte by byte as in README.md. All integers and doubles are
// little-endian. No I/O and no clock here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "haptics/tools/device.h"

namespace stylet::haptics::bridge {

inline constexpr std::uint8_t kVersion = 1;
inline constexpr std::size_t kHeaderBytes = 12, kChecksumBytes = 4;
inline constexpr std::size_t kMaxPayloadBytes = 240;
inline constexpr std::size_t kMaxFrameBytes = kHeaderBytes + kMaxPayloadBytes + kChecksumBytes;

// kSilenceTimeout_ns: after this much silence from either side the force is removed. That leaves 5 of the
// allowed 20 ms for the zero to reach the motors. kMaxClockLead_ns: how far the other side's clock (the same
// CLOCK_MONOTONIC) may be ahead of ours.
inline constexpr std::int64_t kSilenceTimeout_ns = 15'000'000;
inline constexpr std::int64_t kMaxClockLead_ns = 1'000'000;
// Limits that no desktop device reaches. Larger values are rejected.
inline constexpr double kFarthest_m = 2.0, kMaxForce_n = 100.0;

enum class FrameType : std::uint8_t { hello = 1, capabilities = 2, force = 3, state = 4, bye = 5 };

// Stylet to bridge, first frame.
struct Hello {
    std::uint8_t lowest_version = kVersion, highest_version = kVersion;
};
// Bridge to Stylet, the answer to hello. `profile.name` and `profile.source` are null; the texts are in the
// arrays.
struct Capabilities {
    std::uint8_t version = kVersion;
    DeviceProfile profile;
    std::array<char, 40> name{};    // printable ASCII, ended by a zero
    std::array<char, 96> source{};  // likewise
};
// Stylet to bridge, at its own rate.
struct Force {
    std::int64_t sent_ns = 0;
    Vec3 force_n{0.0};
};
enum class MotorStage : std::uint8_t {
    on,
    needsHoming,
    off,  // by the device's own safety, which shows the reason on its panel
};
// Bridge to Stylet, one per force.
struct State {
    std::uint32_t answers = 0;    // sequence number of the force answered
    std::int64_t sampled_ns = 0;  // when the device was read
    Pose device_from_stylus;
    std::uint32_t buttons = 0;
    MotorStage motors = MotorStage::on;
    bool hand_on = true;
    bool watchdog = false;  // the bridge applies zero until a force of exactly zero arrives
};
// Either direction, last frame.
struct Bye {
    std::array<char, 201> reason{};  // printable ASCII, ended by a zero
};

// Faults of a frame or of the other side. magic to type come from readFrame(), value and unexpected mostly
// from the parse functions, the rest from Link.
enum class LinkFault : std::uint8_t {
    none,
    magic,
    version,
    size,
    checksum,
    type,
    value,       // a field that is not finite or out of range
    unexpected,  // an unexpected frame, or an answer to a force never sent
    clock,       // a sample from the future, or older than the one before
    silent,      // nothing for 15 ms
    frozen,      // frames, but no new sample for 15 ms
    bye,         // the bridge closed, with a reason
};
std::string_view describe(LinkFault) noexcept;

struct Frame {
    FrameType type = FrameType::bye;
    std::uint32_t sequence = 0;
    std::span<const std::uint8_t> payload;
    std::size_t bytes = 0;  // of the whole frame; 0: more bytes are needed
};

// Reads one frame at the start of `bytes`. A fault is final: a stream with one wrong byte is not trusted.
LinkFault readFrame(std::span<const std::uint8_t> bytes, Frame&) noexcept;

// Each parse function rejects values that are not finite or out of range, and payloads of the wrong length.
LinkFault parse(const Frame&, Hello&) noexcept;
LinkFault parse(const Frame&, Capabilities&) noexcept;
LinkFault parse(const Frame&, Force&) noexcept;
LinkFault parse(const Frame&, State&) noexcept;
LinkFault parse(const Frame&, Bye&) noexcept;

// A complete frame with its own buffer.
struct FrameBytes {
    std::array<std::uint8_t, kMaxFrameBytes> bytes{};
    std::size_t size = 0;
    std::span<const std::uint8_t> span() const noexcept { return {bytes.data(), size}; }
};
FrameBytes encode(std::uint32_t sequence, const Hello&) noexcept;
FrameBytes encode(std::uint32_t sequence, const Capabilities&) noexcept;
FrameBytes encode(std::uint32_t sequence, const Force&) noexcept;
FrameBytes encode(std::uint32_t sequence, const State&) noexcept;
FrameBytes encodeBye(std::uint32_t sequence, std::string_view reason) noexcept;

// Copies a text into a fixed field, truncated to fit. Characters other than printable ASCII become '?'.
void putText(std::span<char> field, std::string_view text) noexcept;

}  // namespace stylet::haptics::bridge
