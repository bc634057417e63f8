#include "tests/support/spacemouse_emulator.h"

namespace stylet::test {

namespace {

// Identity of a multi-axis controller. Report 1 has six axes of 16 bits.
HidIdentity spaceMouseIdentity(SpaceMouseEmulator::Age age) {
    const bool old = age == SpaceMouseEmulator::Age::old;
    return {std::uint16_t(old ? 0x046D : 0x256F),
            std::uint16_t(old ? 0xC626 : 0xC635),
            "3Dconnexion",
            old ? "SpaceNavigator" : "SpaceMouse Compact",
            {0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xA1, 0x00, 0x85, 0x01, 0x16, 0xA2, 0xFE, 0x26,
             0x5E, 0x01, 0x36, 0x88, 0xFA, 0x46, 0x78, 0x05, 0x09, 0x30, 0x09, 0x31, 0x09, 0x32,
             0x09, 0x33, 0x09, 0x34, 0x09, 0x35, 0x75, 0x10, 0x95, 0x06, 0x81, 0x02, 0xC0, 0xC0}};
}

void add(std::vector<unsigned char>& report, int value) {
    const unsigned bits = unsigned(value) % 65536;
    report.push_back(static_cast<unsigned char>(bits % 256));
    report.push_back(static_cast<unsigned char>(bits / 256));
}

}  // namespace

SpaceMouseEmulator::SpaceMouseEmulator(Age age) : age_(age), node_(spaceMouseIdentity(age)) {}

bool SpaceMouseEmulator::push(const std::array<int, 6>& axes) {
    std::vector<unsigned char> report{1};
    for (std::size_t i = 0; i < (age_ == Age::recent ? 6u : 3u); ++i)
        add(report, axes[i]);
    return node_.send(report);
}

bool SpaceMouseEmulator::turn(const std::array<int, 6>& axes) {
    if (age_ == Age::recent) return true;
    std::vector<unsigned char> report{2};
    for (std::size_t i = 3; i < 6; ++i)
        add(report, axes[i]);
    return node_.send(report);
}

bool SpaceMouseEmulator::press(unsigned mask) {
    return node_.send(std::array<unsigned char, 3>{3, static_cast<unsigned char>(mask), 0});
}

}  // namespace stylet::test
