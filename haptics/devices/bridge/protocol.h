// The frames between Stylet and a bridge, byte by byte as README.md has them. All integers and doubles are
// little-endian. Nothing here does I/O or reads a clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "haptics/device.h"

namespace stylet::haptics::bridge {

inline constexpr std::uint8_t kVersion = 1;
inline constexpr std::size_t kHeaderBytes = 12, kChecksumBytes = 4;
inline constexpr std::size_t kMostPayloadBytes = 240;
inline constexpr std::size_t kMostFrameBytes = kHeaderBytes + kMostPayloadBytes + kChecksumBytes;

// Either side's silence after which there is no force (5 ms are left to get zero to the motors within 20),
// and how far ahead of ours the other side's clock (the same CLOCK_MONOTONIC) may be.
inline constexpr std::int64_t kSilent_ns = 15'000'000;
inline constexpr std::int64_t kAhead_ns = 1'000'000;
// What no desktop device reaches: refused as nonsense.
inline constexpr double kFarthest_m = 2.0, kMostForce_n = 100.0;

enum class FrameType : std::uint8_t { hello = 1, capabilities = 2, force = 3, state = 4, bye = 5 };

// Stylet to bridge, first.
struct Hello {
    std::uint8_t lowest_version = kVersion, highest_version = kVersion;
};
// Bridge to Stylet, the answer. `profile.name` and `profile.source` are null: the texts are here.
struct Capabilities {
    std::uint8_t version = kVersion;
    DeviceProfile profile;
    std::array<char, 40> name{};    // printable ASCII, ended by a zero
    std::array<char, 96> source{};  // likewise
};
// Stylet to bridge, at its own pace.
struct Force {
    std::int64_t sent_ns = 0;
    Vec3 force_n{0.0};
};
enum class MotorStage : std::uint8_t {
    on,
    needsHoming,
    off,  // by the device's own safety: it says why on its own panel
};
// Bridge to Stylet, one for each force.
struct State {
    std::uint32_t answers = 0;    // the sequence number of the force
    std::int64_t sampled_ns = 0;  // when the device was read
    Pose device_from_stylus;
    std::uint32_t buttons = 0;
    MotorStage motors = MotorStage::on;
    bool hand_on = true;
    bool watchdog = false;  // the bridge holds zero until a force of exactly zero arrives
};
// Either way, last.
struct Bye {
    std::array<char, 201> reason{};  // printable ASCII, ended by a zero
};

// What is wrong with a frame, or with the other side. The first is found by readFrame(), the next by the
// parse functions, the rest by Link.
enum class LinkFault : std::uint8_t {
    none,
    magic,
    version,
    size,
    checksum,
    type,
    value,    // a field that is not finite or out of its range
    unasked,  // a frame that does not belong here, or answers a force never sent
    clock,    // a sample from the future, or older than the one before
    silent,   // nothing for 15 ms
    frozen,   // frames, but no new sample for 15 ms
    bye,      // the bridge closed, with a reason
};
const char* describe(LinkFault) noexcept;

struct Frame {
    FrameType type = FrameType::bye;
    std::uint32_t sequence = 0;
    std::span<const std::uint8_t> payload;
    std::size_t bytes = 0;  // of the whole frame; 0: more bytes are needed
};

// Looks for one frame at the start of `bytes`. A fault is final: a stream with one wrong byte is not trusted.
LinkFault readFrame(std::span<const std::uint8_t> bytes, Frame&) noexcept;

// Each refuses what is not finite, out of range or of the wrong length.
LinkFault parse(const Frame&, Hello&) noexcept;
LinkFault parse(const Frame&, Capabilities&) noexcept;
LinkFault parse(const Frame&, Force&) noexcept;
LinkFault parse(const Frame&, State&) noexcept;
LinkFault parse(const Frame&, Bye&) noexcept;

// A whole frame in a buffer of its own.
struct FrameBytes {
    std::array<std::uint8_t, kMostFrameBytes> bytes{};
    std::size_t size = 0;
    std::span<const std::uint8_t> span() const noexcept { return {bytes.data(), size}; }
};
FrameBytes encode(std::uint32_t sequence, const Hello&) noexcept;
FrameBytes encode(std::uint32_t sequence, const Capabilities&) noexcept;
FrameBytes encode(std::uint32_t sequence, const Force&) noexcept;
FrameBytes encode(std::uint32_t sequence, const State&) noexcept;
FrameBytes encode(std::uint32_t sequence, const Bye&) noexcept;

// Puts a text into a fixed field, cut to fit; what is not printable ASCII becomes '?'.
void putText(std::span<char> field, const char* text) noexcept;

}  // namespace stylet::haptics::bridge
