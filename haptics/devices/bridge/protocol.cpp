#include "haptics/devices/bridge/protocol.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "base/text.h"

namespace stylet::haptics::bridge {

namespace {

constexpr std::array<std::uint8_t, 4> kMagic{'S', 'T', 'B', 'G'};

// CRC-32 of IEEE 802.3 (reflected polynomial 0xEDB88320), as in zlib and Ethernet.
constexpr std::array<std::uint32_t, 256> kCrcTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t value = i;
        for (int bit = 0; bit < 8; ++bit)
            value = value & 1u ? (value >> 1) ^ 0xEDB88320u : value >> 1;
        table[i] = value;
    }
    return table;
}();

std::uint32_t crc32(std::span<const std::uint8_t> bytes) noexcept {
    std::uint32_t value = 0xFFFFFFFFu;
    for (const std::uint8_t byte : bytes)
        value = kCrcTable[(value ^ byte) & 0xFFu] ^ (value >> 8);
    return value ^ 0xFFFFFFFFu;
}

class Writer {
  public:
    Writer(FrameType type, std::uint32_t sequence) noexcept {
        for (const std::uint8_t byte : kMagic)
            integer(byte);
        integer(kVersion);
        integer(std::uint8_t(type));
        integer(std::uint16_t(0));  // the payload's length, set by finish()
        integer(sequence);
    }
    template <typename T>
    void integer(T value) noexcept {
        const auto bits = std::uint64_t(value);
        for (std::size_t i = 0; i < sizeof(T); ++i)
            out_.bytes[out_.size++] = std::uint8_t(bits >> (8 * i));
    }
    void real(double value) noexcept { integer(std::bit_cast<std::uint64_t>(value)); }
    void vector(const Vec3& v) noexcept { real(v.x), real(v.y), real(v.z); }
    void text(std::span<const char> field) noexcept {
        std::memcpy(out_.bytes.data() + out_.size, field.data(), field.size());
        out_.size += field.size();
    }
    FrameBytes finish() noexcept {
        const std::size_t payload = out_.size - kHeaderBytes;
        out_.bytes[6] = std::uint8_t(payload);
        out_.bytes[7] = std::uint8_t(payload >> 8);
        integer(crc32(out_.span()));
        return out_;
    }

  private:
    FrameBytes out_;
};

// Reads a payload whose length has been checked.
class Reader {
  public:
    explicit Reader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}
    template <typename T>
    T integer() noexcept {
        std::uint64_t bits = 0;
        for (std::size_t i = 0; i < sizeof(T); ++i)
            bits |= std::uint64_t(bytes_[at_++]) << (8 * i);
        return T(bits);
    }
    double real() noexcept { return std::bit_cast<double>(integer<std::uint64_t>()); }
    Vec3 vector() noexcept {
        const double x = real(), y = real(), z = real();
        return {x, y, z};
    }
    // Returns false unless the field is printable ASCII, terminated and padded with zeros.
    bool text(std::span<char> field) noexcept {
        bool ended = false, good = true;
        for (char& c : field) {
            c = char(bytes_[at_++]);
            if (ended ? c != 0 : c != 0 && (c < ' ' || c > '~')) good = false;
            ended = ended || c == 0;
        }
        return good && ended;
    }

  private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
};

bool within(double value, double low, double high) noexcept {
    return value >= low && value <= high;
}
// Unknown values are sent as NaN.
bool withinOrUnknown(double value, double high) noexcept {
    return std::isnan(value) || within(value, 0.0, high);
}

constexpr std::size_t kHelloBytes = 4, kCapabilitiesBytes = 240, kForceBytes = 32, kStateBytes = 80;

LinkFault expect(const Frame& frame, FrameType type, std::size_t bytes) noexcept {
    if (frame.type != type) return LinkFault::unexpected;
    return frame.payload.size() == bytes ? LinkFault::none : LinkFault::size;
}

bool possible(const DeviceProfile& p) noexcept {
    return within(p.force_peak_n, 0.0, kMaxForce_n) && withinOrUnknown(p.force_continuous_n, kMaxForce_n) &&
           within(p.stiffness_n_per_m, 1.0, 1e5) && within(p.rate_hz, 100.0, 20'000.0) &&
           withinOrUnknown(p.mass_kg, 10.0) && withinOrUnknown(p.damping_n_s_per_m, 1000.0) &&
           withinOrUnknown(p.friction_n, kMaxForce_n) && withinOrUnknown(p.resolution_m, 0.01) &&
           isFinite(p.workspace_centre_m) && glm::length(p.workspace_centre_m) <= kFarthest_m &&
           withinOrUnknown(p.workspace_radius_m, kFarthest_m) && p.force_axes <= 3 && p.torque_axes <= 3;
}

// The first doubles of a capabilities frame, in the order of the frame.
constexpr double DeviceProfile::* kReals[] = {
    &DeviceProfile::force_peak_n,      &DeviceProfile::force_continuous_n,
    &DeviceProfile::stiffness_n_per_m, &DeviceProfile::rate_hz,
    &DeviceProfile::mass_kg,           &DeviceProfile::damping_n_s_per_m,
    &DeviceProfile::friction_n,        &DeviceProfile::resolution_m};

enum CapabilityFlag : std::uint8_t { kSensesRotation = 1, kHasDeadMan = 2, kForceCalibrated = 4 };
enum StateFlag : std::uint16_t { kHandOn = 1, kWatchdog = 2 };

}  // namespace

std::string_view describe(LinkFault fault) noexcept {
    // In the order of LinkFault.
    static constexpr std::array<std::string_view, 12> kTexts{
        "nothing wrong",
        "a frame does not begin with STBG",
        "another version of the protocol",
        "a frame of the wrong length",
        "a frame with a wrong checksum",
        "a frame of unknown type",
        "a value that is not finite or out of range",
        "an unexpected frame",
        "a sample's time went back or is in the future",
        "nothing from the bridge for 15 ms",
        "no new sample from the device for 15 ms",
        "the bridge closed",
    };
    return enumName(kTexts, fault);
}

LinkFault readFrame(std::span<const std::uint8_t> bytes, Frame& frame) noexcept {
    frame = {};
    for (std::size_t i = 0; i < kMagic.size() && i < bytes.size(); ++i)
        if (bytes[i] != kMagic[i]) return LinkFault::magic;
    if (bytes.size() < kHeaderBytes) return LinkFault::none;

    Reader header(bytes.subspan(kMagic.size()));
    const auto version = header.integer<std::uint8_t>();
    const auto type = header.integer<std::uint8_t>();
    const auto payload = header.integer<std::uint16_t>();
    const auto sequence = header.integer<std::uint32_t>();
    if (version != kVersion) return LinkFault::version;
    if (payload > kMaxPayloadBytes) return LinkFault::size;
    const std::size_t whole = kHeaderBytes + payload + kChecksumBytes;
    if (bytes.size() < whole) return LinkFault::none;

    Reader checksum(bytes.subspan(whole - kChecksumBytes));
    if (checksum.integer<std::uint32_t>() != crc32(bytes.first(whole - kChecksumBytes)))
        return LinkFault::checksum;
    if (type < std::uint8_t(FrameType::hello) || type > std::uint8_t(FrameType::bye)) return LinkFault::type;
    frame = {FrameType(type), sequence, bytes.subspan(kHeaderBytes, payload), whole};
    return LinkFault::none;
}

LinkFault parse(const Frame& frame, Hello& hello) noexcept {
    if (const LinkFault fault = expect(frame, FrameType::hello, kHelloBytes); fault != LinkFault::none)
        return fault;
    Reader in(frame.payload);
    hello.lowest_version = in.integer<std::uint8_t>();
    hello.highest_version = in.integer<std::uint8_t>();
    const bool reserved = in.integer<std::uint16_t>() != 0;
    return reserved || hello.lowest_version > hello.highest_version ? LinkFault::value : LinkFault::none;
}

LinkFault parse(const Frame& frame, Capabilities& capabilities) noexcept {
    if (const LinkFault fault = expect(frame, FrameType::capabilities, kCapabilitiesBytes);
        fault != LinkFault::none)
        return fault;
    Reader in(frame.payload);
    DeviceProfile& p = capabilities.profile;
    p.name = p.source = nullptr;
    capabilities.version = in.integer<std::uint8_t>();
    p.force_axes = in.integer<std::uint8_t>();
    p.torque_axes = in.integer<std::uint8_t>();
    const auto flags = in.integer<std::uint8_t>();
    const bool reserved = in.integer<std::uint32_t>() != 0 || flags > 7;
    p.senses_rotation = flags & kSensesRotation;
    p.has_dead_man = flags & kHasDeadMan;
    p.force_calibrated = flags & kForceCalibrated;
    for (const auto member : kReals)
        p.*member = in.real();
    p.workspace_centre_m = in.vector();
    p.workspace_radius_m = in.real();
    const bool name = in.text(capabilities.name), source = in.text(capabilities.source);
    if (capabilities.version != kVersion) return LinkFault::version;
    return name && source && !reserved && possible(p) ? LinkFault::none : LinkFault::value;
}

LinkFault parse(const Frame& frame, Force& force) noexcept {
    if (const LinkFault fault = expect(frame, FrameType::force, kForceBytes); fault != LinkFault::none)
        return fault;
    Reader in(frame.payload);
    force.sent_ns = in.integer<std::int64_t>();
    force.force_n = in.vector();
    const bool good =
        force.sent_ns >= 0 && isFinite(force.force_n) && glm::length(force.force_n) <= kMaxForce_n;
    return good ? LinkFault::none : LinkFault::value;
}

LinkFault parse(const Frame& frame, State& state) noexcept {
    if (const LinkFault fault = expect(frame, FrameType::state, kStateBytes); fault != LinkFault::none)
        return fault;
    Reader in(frame.payload);
    state.answers = in.integer<std::uint32_t>();
    const auto motors = in.integer<std::uint16_t>();
    const auto flags = in.integer<std::uint16_t>();
    state.sampled_ns = in.integer<std::int64_t>();
    state.device_from_stylus.position_m = in.vector();
    Quat& q = state.device_from_stylus.rotation;
    q.w = in.real(), q.x = in.real(), q.y = in.real(), q.z = in.real();
    state.buttons = in.integer<std::uint32_t>();
    const bool reserved = in.integer<std::uint32_t>() != 0;
    state.hand_on = flags & kHandOn;
    state.watchdog = flags & kWatchdog;

    const Vec3& p = state.device_from_stylus.position_m;
    const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    if (motors > std::uint16_t(MotorStage::off) || flags > 3 || reserved || state.sampled_ns < 0)
        return LinkFault::value;
    if (!isFinite(p) || glm::length(p) > kFarthest_m || !within(norm, 0.999, 1.001)) return LinkFault::value;
    state.motors = MotorStage(motors);
    q = Quat(q.w / norm, q.x / norm, q.y / norm, q.z / norm);
    return LinkFault::none;
}

LinkFault parse(const Frame& frame, Bye& bye) noexcept {
    if (frame.type != FrameType::bye) return LinkFault::unexpected;
    if (frame.payload.size() >= bye.reason.size()) return LinkFault::size;
    bye = {};
    for (std::size_t i = 0; i < frame.payload.size(); ++i) {
        const char c = char(frame.payload[i]);
        if (c < ' ' || c > '~') return LinkFault::value;
        bye.reason[i] = c;
    }
    return LinkFault::none;
}

FrameBytes encode(std::uint32_t sequence, const Hello& hello) noexcept {
    Writer out(FrameType::hello, sequence);
    out.integer(hello.lowest_version);
    out.integer(hello.highest_version);
    out.integer(std::uint16_t(0));
    return out.finish();
}

FrameBytes encode(std::uint32_t sequence, const Capabilities& capabilities) noexcept {
    const DeviceProfile& p = capabilities.profile;
    Writer out(FrameType::capabilities, sequence);
    out.integer(capabilities.version);
    out.integer(std::uint8_t(p.force_axes));
    out.integer(std::uint8_t(p.torque_axes));
    out.integer(std::uint8_t((p.senses_rotation ? kSensesRotation : 0) | (p.has_dead_man ? kHasDeadMan : 0) |
                             (p.force_calibrated ? kForceCalibrated : 0)));
    out.integer(std::uint32_t(0));
    for (const auto member : kReals)
        out.real(p.*member);
    out.vector(p.workspace_centre_m);
    out.real(p.workspace_radius_m);
    out.text(capabilities.name);
    out.text(capabilities.source);
    return out.finish();
}

FrameBytes encode(std::uint32_t sequence, const Force& force) noexcept {
    Writer out(FrameType::force, sequence);
    out.integer(force.sent_ns);
    out.vector(force.force_n);
    return out.finish();
}

FrameBytes encode(std::uint32_t sequence, const State& state) noexcept {
    Writer out(FrameType::state, sequence);
    out.integer(state.answers);
    out.integer(std::uint16_t(state.motors));
    out.integer(std::uint16_t((state.hand_on ? kHandOn : 0) | (state.watchdog ? kWatchdog : 0)));
    out.integer(state.sampled_ns);
    out.vector(state.device_from_stylus.position_m);
    const Quat& q = state.device_from_stylus.rotation;
    out.real(q.w), out.real(q.x), out.real(q.y), out.real(q.z);
    out.integer(state.buttons);
    out.integer(std::uint32_t(0));
    return out.finish();
}

FrameBytes encodeBye(std::uint32_t sequence, std::string_view reason) noexcept {
    Bye bye;
    putText(bye.reason, reason);
    Writer out(FrameType::bye, sequence);
    out.text({bye.reason.data(), std::strlen(bye.reason.data())});
    return out.finish();
}

void putText(std::span<char> field, std::string_view text) noexcept {
    for (std::size_t i = 0; i < field.size(); ++i) {
        const char c = i < text.size() && i + 1 < field.size() ? text[i] : '\0';
        field[i] = c != 0 && (c < ' ' || c > '~') ? '?' : c;
    }
}

}  // namespace stylet::haptics::bridge
