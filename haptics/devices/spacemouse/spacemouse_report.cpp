#include "haptics/devices/spacemouse/spacemouse_report.h"

#include <algorithm>
#include <cstdlib>

namespace stylet::haptics {

namespace {

constexpr unsigned char kMotion = 1, kRotation = 2, kButtons = 3, kBattery = 0x17;
constexpr std::size_t kThreeAxes = 7, kSixAxes = 13;  // bytes, including the report id
constexpr std::size_t kMaskBytes = 4;
// No cap reports more than this: its physical range, four times the logical one.
constexpr int kMaxAxis = 4 * kSpaceMouseFullScale;

constexpr std::uint16_t kLogitech = 0x046d, k3Dconnexion = 0x256f;
constexpr std::uint16_t kGenericDesktop = 1, kMultiAxis = 8;
constexpr std::array<std::uint16_t, 11> kLogitechCaps{0xc603, 0xc605, 0xc606, 0xc621, 0xc623, 0xc625,
                                                      0xc626, 0xc627, 0xc628, 0xc629, 0xc62b};
constexpr std::array<std::uint16_t, 10> k3DconnexionCaps{0xc62e, 0xc62f, 0xc631, 0xc632, 0xc633,
                                                         0xc635, 0xc636, 0xc638, 0xc63a, 0xc652};

SpaceMouseReport parseAxes(std::span<const unsigned char> words, int* axes) noexcept {
    std::array<int, 6> read{};
    const std::size_t count = words.size() / 2;
    for (std::size_t i = 0; i < count; ++i) {
        read[i] = std::int16_t(std::uint16_t(words[2 * i] | words[2 * i + 1] << 8));
        if (std::abs(read[i]) > kMaxAxis) return SpaceMouseReport::malformed;
    }
    std::copy_n(read.begin(), count, axes);
    return SpaceMouseReport::motion;
}

}  // namespace

SpaceMouseReport parseSpaceMouseReport(std::span<const unsigned char> bytes,
                                       SpaceMouseInput& input) noexcept {
    if (bytes.size() < 2) return SpaceMouseReport::malformed;
    const std::span<const unsigned char> content = bytes.subspan(1);
    switch (bytes[0]) {
        case kMotion:
            if (bytes.size() != kThreeAxes && bytes.size() != kSixAxes) return SpaceMouseReport::malformed;
            return parseAxes(content, input.axes.data());
        case kRotation:
            if (bytes.size() != kThreeAxes) return SpaceMouseReport::malformed;
            return parseAxes(content, input.axes.data() + 3);
        case kButtons:
            input.buttons = 0;
            for (std::size_t i = 0; i < std::min(content.size(), kMaskBytes); ++i)
                input.buttons |= std::uint32_t(content[i]) << (8 * i);
            return SpaceMouseReport::other;
        case kBattery:
            if (content[0] > 100) return SpaceMouseReport::malformed;
            input.battery_percent = content[0];
            return SpaceMouseReport::other;
        default:
            return SpaceMouseReport::other;
    }
}

bool isSpaceMouse(std::uint16_t vendor, std::uint16_t product, std::uint16_t usage_page,
                  std::uint16_t usage) noexcept {
    const auto among = [product](const auto& list) {
        return std::find(list.begin(), list.end(), product) != list.end();
    };
    const bool known =
        (vendor == kLogitech && among(kLogitechCaps)) || (vendor == k3Dconnexion && among(k3DconnexionCaps));
    const bool described = usage_page != 0 || usage != 0;
    return known && (!described || (usage_page == kGenericDesktop && usage == kMultiAxis));
}

}  // namespace stylet::haptics
