#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "haptics/devices/bridge/link.h"
#include "haptics/devices/bridge/server.h"

namespace {

using namespace stylet::haptics;
using namespace stylet::haptics::bridge;

// Corrects the checksums, so that the fuzzer also reaches the code that runs after the checksum test.
std::vector<std::uint8_t> sealed(std::span<const std::uint8_t> bytes) {
    std::vector<std::uint8_t> out(bytes.begin(), bytes.end());
    for (std::size_t at = 0; at + kHeaderBytes + kChecksumBytes <= out.size();) {
        const std::size_t payload = std::size_t(out[at + 6]) | std::size_t(out[at + 7]) << 8;
        const std::size_t whole = kHeaderBytes + payload + kChecksumBytes;
        if (at + whole > out.size()) break;
        std::uint32_t sum = 0xFFFFFFFFu;
        for (std::size_t i = at; i < at + whole - kChecksumBytes; ++i) {
            sum ^= out[i];
            for (int bit = 0; bit < 8; ++bit)
                sum = sum & 1u ? (sum >> 1) ^ 0xEDB88320u : sum >> 1;
        }
        for (std::size_t i = 0; i < kChecksumBytes; ++i)
            out[at + whole - kChecksumBytes + i] = std::uint8_t(~sum >> (8 * i));
        at += whole;
    }
    return out;
}

void check(bool good) {
    if (!good) std::abort();
}

void checkVector(const stylet::Vec3& v, double most) {
    check(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) &&
          glm::length(v) <= most * (1 + 1e-12));
}

// Feeds the bytes to a link as if a bridge had sent them. Every state must be valid, and the first fault must
// persist.
void attackLink(std::span<const std::uint8_t> bytes) {
    Link link;
    link.hello();
    std::int64_t now_ns = 1'000'000'000;
    for (std::size_t at = 0; at < bytes.size(); at += 64) {
        link.receive(bytes.subspan(at, std::min<std::size_t>(64, bytes.size() - at)), now_ns);
        if (link.hasCapabilities()) link.force(stylet::Vec3(0.0), now_ns);
        link.checkTimeout(now_ns);
        const LinkFault fault = link.fault();
        State state;
        if (link.readState(state)) {
            checkVector(state.device_from_stylus.position_m, kFarthest_m);
            check(std::fabs(glm::length(state.device_from_stylus.rotation) - 1.0) < 1e-9);
            check(link.hasCapabilities());
        }
        if (fault != LinkFault::none) {
            link.receive(bytes, now_ns);
            check(link.fault() == fault);
            return;
        }
        now_ns += 1'000'000;
    }
}

// Feeds the bytes to a session as if a trainer had sent them. The motors must never exceed the peak force.
void attackSession(std::span<const std::uint8_t> bytes) {
    Capabilities capabilities;
    Servo servo;
    Session session(capabilities, servo);
    std::vector<std::uint8_t> out;
    std::int64_t now_ns = 1'000'000'000;
    bool on = true;
    for (std::size_t at = 0; on && at < bytes.size(); at += 64) {
        on = session.receive(bytes.subspan(at, std::min<std::size_t>(64, bytes.size() - at)), out);
        checkVector(servo.tick({now_ns, {}, 0, MotorStage::on, true}, 3.3), 3.3);
        now_ns += 1'000'000;
    }
    Frame frame;
    for (std::size_t at = 0; at < out.size(); at += frame.bytes)
        check(readFrame(std::span(out).subspan(at), frame) == LinkFault::none && frame.bytes > 0);
}

}  // namespace

// HZ-FORCE-21, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::span<const std::uint8_t> bytes(data, size);
    const std::vector<std::uint8_t> good = sealed(bytes);
    for (const auto& input : {bytes, std::span<const std::uint8_t>(good)}) {
        attackLink(input);
        attackSession(input);
    }
    return 0;
}
