// SpaceMouse reports as bytes, and which HID devices are SpaceMice.
// Facts from FreeSpacenav/spacenavd (src/dev.c), andunhh.github.io/spacemouse and several client programs.
// Old and new devices are distinguished by the length of their reports, never by product number.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace stylet::haptics {

inline constexpr int kSpaceMouseFullScale = 350;  // logical units at the cap's stop

// The cap and the buttons as last reported.
struct SpaceMouseInput {
    // x right, y toward the user, z down, then right-handed rotations about them; logical units.
    std::array<int, 6> axes{};
    std::uint32_t buttons = 0;
    int battery_percent = -1;  // -1: unknown

    bool atRest() const noexcept { return axes == std::array<int, 6>{}; }
};

enum class SpaceMouseReport : std::uint8_t {
    motion,     // axes updated
    other,      // buttons or battery updated, or a report that is not used
    malformed,  // invalid; nothing was changed
};
SpaceMouseReport parseSpaceMouseReport(std::span<const unsigned char> bytes, SpaceMouseInput&) noexcept;

// Decides by USB ids and, if the descriptor could be read, by usage page and usage (else 0, 0). Mice and
// keyboards of the same makers are excluded.
bool isSpaceMouse(std::uint16_t vendor, std::uint16_t product, std::uint16_t usage_page,
                  std::uint16_t usage) noexcept;

}  // namespace stylet::haptics
