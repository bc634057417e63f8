#include "haptics/devices/bridge/protocol.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace stylet::haptics::bridge {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Parses "53 54 42" into bytes. "00*34" stands for 34 bytes 00.
Bytes hex(const std::string& text) {
    Bytes bytes;
    const char* at = text.c_str();
    while (*at != 0) {
        char* end = nullptr;
        const auto byte = std::uint8_t(std::strtoul(at, &end, 16));
        const unsigned long times = *end == '*' ? std::strtoul(end + 1, &end, 10) : 1;
        bytes.insert(bytes.end(), times, byte);
        at = *end == ' ' ? end + 1 : end;
    }
    return bytes;
}

Bytes bytesOf(const FrameBytes& frame) {
    return {frame.span().begin(), frame.span().end()};
}

// Written by hand from the tables in the README. The checksums come from another program.
const Bytes kHello = hex("53 54 42 47 01 01 04 00 01 00 00 00 01 01 00 00 24 2C F2 4F");
const Bytes kForce =
    hex("53 54 42 47 01 03 20 00 02 00 00 00 00 CA 9A 3B 00 00 00 00 00 00 00 00 00 00 E0 3F "
        "00 00 00 00 00 00 D0 BF 00 00 00 00 00 00 04 40 44 F7 AD F0");
const Bytes kState = hex(
    "53 54 42 47 01 04 50 00 02 00 00 00 02 00 00 00 00 00 01 00 20 6B A2 3B 00 00 00 00 "
    "00 00 00 00 00 00 C0 3F 00 00 00 00 00 00 E0 BF 00 00 00 00 00 00 B0 3F 00 00 00 00 00 00 E0 3F "
    "00 00 00 00 00 00 E0 3F 00 00 00 00 00 00 E0 BF 00 00 00 00 00 00 E0 3F 03 00 00 00 00*4 3B 75 17 D8");
const Bytes kCapabilities = hex(
    "53 54 42 47 01 02 F0 00 01 00 00 00 01 03 00 05 00*4 66 66 66 66 66 66 0A 40 29 5C 8F C2 F5 28 EC 3F "
    "00 00 00 00 00 00 79 40 00 00 00 00 00 40 8F 40 00*6 F8 7F 00*6 F8 7F 00*6 F8 7F "
    "4B B0 38 9C F9 D5 0C 3F 00*8 00*6 C0 3F 00*6 B0 BF 7B 14 AE 47 E1 7A B4 3F "
    "54 6F 75 63 68 00*35 64 61 74 61 20 73 68 65 65 74 00*86 CC 9A 3B 34");
const Bytes kBye = hex("53 54 42 47 01 05 09 00 07 00 00 00 75 6E 70 6C 75 67 67 65 64 BA 03 28 EE");

State goldenState() {
    State state;
    state.answers = 2;
    state.sampled_ns = 1'000'500'000;
    state.device_from_stylus = {Quat(0.5, 0.5, -0.5, 0.5), Vec3(0.125, -0.5, 0.0625)};
    state.buttons = 3;
    return state;
}

Capabilities goldenCapabilities() {
    Capabilities capabilities;
    capabilities.profile.force_peak_n = 3.3;
    capabilities.profile.force_continuous_n = 0.88;
    capabilities.profile.stiffness_n_per_m = 400.0;
    capabilities.profile.resolution_m = 5.5e-5;
    capabilities.profile.workspace_centre_m = {0.0, 0.125, -0.0625};
    capabilities.profile.workspace_radius_m = 0.08;
    putText(capabilities.name, "Touch");
    putText(capabilities.source, "data sheet");
    return capabilities;
}

template <typename T>
LinkFault decode(const Bytes& bytes, T& message) {
    Frame frame;
    if (const LinkFault fault = readFrame(bytes, frame); fault != LinkFault::none) return fault;
    EXPECT_EQ(frame.bytes, bytes.size());
    return parse(frame, message);
}

// The golden bytes with `value` written over the payload at `at`, and the checksum corrected.
template <typename T>
Bytes with(Bytes bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + kHeaderBytes + at, &value, sizeof value);
    std::uint32_t sum = 0xFFFFFFFFu;
    for (std::size_t i = 0; i + 4 < bytes.size(); ++i) {
        sum ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit)
            sum = sum & 1u ? (sum >> 1) ^ 0xEDB88320u : sum >> 1;
    }
    sum = ~sum;
    std::memcpy(bytes.data() + bytes.size() - 4, &sum, 4);
    return bytes;
}

TEST(BridgeProtocol, EncodesTheGoldenBytes) {
    EXPECT_EQ(bytesOf(encode(1, Hello{})), kHello);
    EXPECT_EQ(bytesOf(encode(2, Force{1'000'000'000, {0.5, -0.25, 2.5}})), kForce);
    EXPECT_EQ(bytesOf(encode(2, goldenState())), kState);
    EXPECT_EQ(bytesOf(encode(1, goldenCapabilities())), kCapabilities);
    EXPECT_EQ(bytesOf(encodeBye(7, "unplugged")), kBye);
}

TEST(BridgeProtocol, DecodesTheGoldenBytes) {
    Hello hello;
    ASSERT_EQ(decode(kHello, hello), LinkFault::none);
    Force force;
    ASSERT_EQ(decode(kForce, force), LinkFault::none);
    EXPECT_EQ(force.sent_ns, 1'000'000'000);
    EXPECT_EQ(force.force_n, Vec3(0.5, -0.25, 2.5));
    State state;
    ASSERT_EQ(decode(kState, state), LinkFault::none);
    EXPECT_EQ(state.answers, 2u);
    EXPECT_EQ(state.sampled_ns, 1'000'500'000);
    EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.125, -0.5, 0.0625));
    EXPECT_EQ(state.device_from_stylus.rotation, Quat(0.5, 0.5, -0.5, 0.5));
    EXPECT_EQ(state.buttons, 3u);
    EXPECT_EQ(state.motors, MotorStage::on);
    EXPECT_TRUE(state.hand_on);
    EXPECT_FALSE(state.watchdog);
    Capabilities capabilities;
    ASSERT_EQ(decode(kCapabilities, capabilities), LinkFault::none);
    EXPECT_EQ(capabilities.profile.force_peak_n, 3.3);
    EXPECT_EQ(capabilities.profile.stiffness_n_per_m, 400.0);
    EXPECT_TRUE(std::isnan(capabilities.profile.mass_kg));
    EXPECT_TRUE(capabilities.profile.senses_rotation);
    EXPECT_FALSE(capabilities.profile.has_dead_man);
    EXPECT_EQ(capabilities.profile.workspace_centre_m, Vec3(0.0, 0.125, -0.0625));
    EXPECT_STREQ(capabilities.name.data(), "Touch");
    EXPECT_STREQ(capabilities.source.data(), "data sheet");
    Bye bye;
    ASSERT_EQ(decode(kBye, bye), LinkFault::none);
    EXPECT_STREQ(bye.reason.data(), "unplugged");
}

// HZ-FORCE-21
TEST(BridgeProtocol, EveryFlippedBitIsDetected) {
    for (const Bytes& golden : {kHello, kForce, kState, kCapabilities, kBye}) {
        for (std::size_t bit = 0; bit < 8 * golden.size(); ++bit) {
            Bytes bytes = golden;
            bytes[bit / 8] ^= std::uint8_t(1u << bit % 8);
            Frame frame;
            const LinkFault fault = readFrame(bytes, frame);
            // A longer length makes the reader wait for more bytes. On a real connection they arrive and fail
            // the checksum.
            const bool longer =
                fault == LinkFault::none && frame.bytes == 0 && (bit / 8 == 6 || bit / 8 == 7);
            EXPECT_TRUE(fault != LinkFault::none || longer) << "bit " << bit;
        }
    }
}

TEST(BridgeProtocol, TruncatedFramesWaitAndExtraBytesAreTheNextFrames) {
    for (const Bytes& golden : {kHello, kForce, kState, kCapabilities, kBye}) {
        Frame frame;
        for (std::size_t size = 0; size < golden.size(); ++size) {
            EXPECT_EQ(readFrame({golden.data(), size}, frame), LinkFault::none);
            EXPECT_EQ(frame.bytes, 0u);
        }
        Bytes two = golden;
        two.insert(two.end(), golden.begin(), golden.end());
        EXPECT_EQ(readFrame(two, frame), LinkFault::none);
        EXPECT_EQ(frame.bytes, golden.size());
    }
}

TEST(BridgeProtocol, BadHeadersAreRefused) {
    Frame frame;
    Bytes bytes = kForce;
    bytes[0] = 'X';
    EXPECT_EQ(readFrame({bytes.data(), 1}, frame), LinkFault::magic);
    bytes = kForce;
    bytes[4] = 2;
    EXPECT_EQ(readFrame(bytes, frame), LinkFault::version);
    bytes = kForce;
    bytes[6] = bytes[7] = 0xFF;
    EXPECT_EQ(readFrame(bytes, frame), LinkFault::size);
    bytes = kBye;
    bytes[5] = 6;
    EXPECT_EQ(readFrame(with(bytes, 0, 'u'), frame), LinkFault::type);
}

TEST(BridgeProtocol, AMessageOfAnotherTypeOrLengthIsRefused) {
    State state;
    EXPECT_EQ(decode(kForce, state), LinkFault::unexpected);
    Frame frame;
    ASSERT_EQ(readFrame(kState, frame), LinkFault::none);
    frame.payload = frame.payload.first(79);
    EXPECT_EQ(parse(frame, state), LinkFault::size);
}

// HZ-FORCE-21
TEST(BridgeProtocol, OutOfRangeValuesAreRefused) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double inf = std::numeric_limits<double>::infinity();
    State state;
    for (std::size_t at = 16; at < 72; at += 8)
        for (const double bad : {nan, inf, -inf, 1e300})
            EXPECT_EQ(decode(with(kState, at, bad), state), LinkFault::value) << at;
    EXPECT_EQ(decode(with(kState, 4, std::uint16_t(3)), state), LinkFault::value);   // motors
    EXPECT_EQ(decode(with(kState, 6, std::uint16_t(4)), state), LinkFault::value);   // flags
    EXPECT_EQ(decode(with(kState, 8, std::int64_t(-1)), state), LinkFault::value);   // time
    EXPECT_EQ(decode(with(kState, 76, std::uint32_t(1)), state), LinkFault::value);  // reserved
    Force force;
    EXPECT_EQ(decode(with(kForce, 8, nan), force), LinkFault::value);
    EXPECT_EQ(decode(with(kForce, 8, 101.0), force), LinkFault::value);
    Hello hello;
    EXPECT_EQ(decode(with(kHello, 0, std::uint16_t(0x0102)), hello),
              LinkFault::value);  // lowest above highest
    Capabilities capabilities;
    EXPECT_EQ(decode(with(kCapabilities, 0, std::uint8_t(2)), capabilities), LinkFault::version);
    EXPECT_EQ(decode(with(kCapabilities, 8, nan), capabilities), LinkFault::value);   // peak
    EXPECT_EQ(decode(with(kCapabilities, 24, 0.0), capabilities), LinkFault::value);  // stiffness
    EXPECT_EQ(decode(with(kCapabilities, 24, 1e12), capabilities), LinkFault::value);
    EXPECT_EQ(decode(with(kCapabilities, 40, -1.0), capabilities), LinkFault::value);  // mass
    EXPECT_EQ(decode(with(kCapabilities, 104, '\n'), capabilities), LinkFault::value);
    EXPECT_EQ(decode(with(kCapabilities, 110, 'x'), capabilities), LinkFault::value);  // after the end
    ASSERT_EQ(decode(with(kCapabilities, 96, nan), capabilities), LinkFault::none);
    EXPECT_TRUE(std::isnan(capabilities.profile.workspace_radius_m)) << "a bridge need not know it";
    Bye bye;
    EXPECT_EQ(decode(with(kBye, 3, '\x1b'), bye), LinkFault::value);
}

TEST(BridgeProtocol, NearUnitQuaternionIsNormalised) {
    State state;
    ASSERT_EQ(decode(with(kState, 40, 0.5004), state), LinkFault::none);
    EXPECT_NEAR(glm::length(state.device_from_stylus.rotation), 1.0, 1e-15);
}

}  // namespace
}  // namespace stylet::haptics::bridge
