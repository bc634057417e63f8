// What a SpaceMouse says, as bytes, and which HID devices are one.
// Facts from FreeSpacenav/spacenavd (src/dev.c), andunhh.github.io/spacemouse and several client programs.
// Old and new devices are told apart by the length of their reports, never by their product number.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace stylet::haptics {

inline constexpr int kSpaceMouseFullScale = 350;  // logical units at the cap's stop

// The cap and the buttons as last reported.
struct SpaceMouseInput {
    // x to the right, y toward the user, z down, and about them by the right hand; logical units.
    std::array<int, 6> axes{};
    std::uint32_t buttons = 0;
    int battery_percent = -1;  // unknown

    bool atRest() const noexcept { return axes == std::array<int, 6>{}; }
};

enum class SpaceMouseReport : std::uint8_t {
    motion,     // taken: axes
    other,      // taken or not for us: buttons, battery, what newer devices add
    malformed,  // neither; nothing was changed
};
SpaceMouseReport takeSpaceMouseReport(std::span<const unsigned char> bytes, SpaceMouseInput&) noexcept;

// By USB numbers and, where the descriptor could be read, usage page and usage (0, 0 where not). The makers'
// mice and keyboards are not among them.
bool isSpaceMouse(std::uint16_t vendor, std::uint16_t product, std::uint16_t usage_page,
                  std::uint16_t usage) noexcept;

}  // namespace stylet::haptics
