#include "haptics/devices/falcon/falcon_packet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "patient/synth/random.h"

namespace stylet::haptics::falcon {
namespace {

Packet bytes(const char* text) {
    Packet packet{};
    std::memcpy(packet.data(), text, kPacketBytes);
    return packet;
}

std::string text(const Packet& packet) {
    return {packet.begin(), packet.end()};
}

std::vector<std::uint8_t> stream(const std::string& s) {
    return {s.begin(), s.end()};
}

// Golden bytes from the description of the protocol.
TEST(FalconPacket, CommandsAreTheDocumentedBytes) {
    EXPECT_EQ(text(encode({.homing = false})), "<AAAAAAAAAAAAAA>");
    EXPECT_EQ(text(encode({})), "<AAAAAAAAAAAABA>");
    EXPECT_EQ(text(encode({.motors = {1, 16, 256}})), "<BAAAABAAAABABA>");
    EXPECT_EQ(text(encode({.motors = {4095, -4095, -1}})), "<PPPABAAPPPPPBA>");
    EXPECT_EQ(text(encode({.motors = {0x1234, 0, 0}, .leds = kLedGreen})), "<EDCBAAAAAAAADA>");
    EXPECT_EQ(text(encode({.homing = false, .leds = kLedRed | kLedBlue})), "<AAAAAAAAAAAAMA>");
}

TEST(FalconPacket, RepliesAreReadAsDocumented) {
    // The example in the header of the public driver: nibbles J F K P are 0xFA59.
    const Reply reply = decode(bytes("<JFKPAAAAPPPPAA>")).value();
    EXPECT_EQ(reply.encoders[0], std::int16_t(0xFA59));
    EXPECT_EQ(reply.encoders[0], -1447);
    EXPECT_EQ(reply.encoders[1], 0);
    EXPECT_EQ(reply.encoders[2], -1);
    EXPECT_EQ(reply.buttons, 0);
    EXPECT_EQ(reply.homed, 0);

    Packet flags = bytes("<AAAAAAAAAAAAAA>");
    flags[13] = 0x41 + (0x70 | 0x05);  // homed, right and centre button: 0xB6, not a letter
    EXPECT_EQ(decode(flags)->homed, kHomedAll);
    EXPECT_EQ(decode(flags)->buttons, kButtonRight | kButtonCentre);
}

TEST(FalconPacket, MotorAndEncoderValuesShareOneEncoding) {
    for (int n = -32768; n <= 32767; n += 7) {
        const auto i = std::int16_t(n);
        EXPECT_EQ(decode(encode({.motors = {i, std::int16_t(~i), 5}}))->encoders,
                  (std::array<std::int16_t, 3>{i, std::int16_t(~i), 5}));
    }
}

TEST(FalconPacket, ImpossibleRepliesAreRefused) {
    const Packet good = bytes("<JFKPAAAAPPPPAA>");
    ASSERT_TRUE(decode(good));
    for (std::size_t i = 0; i < kPacketBytes; ++i) {
        int accepted = 0;
        for (int value = 0; value < 256; ++value) {
            Packet packet = good;
            packet[i] = std::uint8_t(value);
            accepted += decode(packet).has_value();
        }
        EXPECT_EQ(accepted, i == 0 || i == 15 ? 1 : i == 13 ? 128 : 16) << "byte " << i;
    }
}

TEST(FalconPacket, ReaderResynchronises) {
    PacketReader reader;
    EXPECT_FALSE(reader.push(stream("AAAA>PPPA")));  // the tail of a packet
    EXPECT_EQ(reader.refused(), 9u);
    EXPECT_FALSE(reader.push(stream("<JFKPAAAA")));
    EXPECT_EQ(reader.push(stream("PPPPAA>"))->encoders[0], -1447);
    EXPECT_EQ(reader.refused(), 9u);
    // A packet with a byte lost, a packet with a byte doubled, then a valid one.
    EXPECT_FALSE(reader.push(stream("<JFKAAAAPPPPAA>")));
    EXPECT_EQ(reader.push(stream("<BAAAAAAAAAAAAA>"))->encoders[0], 1);
    EXPECT_EQ(reader.refused(), 10u);
    EXPECT_FALSE(reader.push(stream("<JJFKPAAAAPPPPAA>")));
    EXPECT_EQ(reader.refused(), 12u);  // the packet and the byte after its sixteenth
    EXPECT_EQ(reader.push(stream("<CAAAAAAAAAAAAA>"))->encoders[0], 2);
    // The newer of two packets counts.
    EXPECT_EQ(reader.push(stream("<BAAAAAAAAAAAAA><CAAAAAAAAAAAAA><DA"))->encoders[0], 2);
    reader.clear();
    EXPECT_FALSE(reader.push(stream("AAAAAAAAAAAA>")));
}

TEST(FalconPacket, ReaderRecoversFromNoiseWithTheNextPacket) {
    patient::synth::Random random(7, 0);
    const char alphabet[] = "<>ABCP\xff\x01";
    PacketReader reader;
    for (int round = 0; round < 2000; ++round) {
        std::vector<std::uint8_t> noise(std::size_t(random.uniform(0.0, 80.0)));
        for (std::uint8_t& byte : noise)
            byte = std::uint8_t(alphabet[std::size_t(random.uniform(0.0, 8.0))]);
        reader.push(noise);
        const auto i = std::int16_t(round);
        const Packet packet = encode({.motors = {i, 0, 0}});
        ASSERT_EQ(reader.push(packet)->encoders[0], i);
    }
}

}  // namespace
}  // namespace stylet::haptics::falcon
