#include "app/trainer/window/screens_beneath.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::trainer {
namespace {

constexpr std::uint32_t kBeneathPixels = 100;

// Returns an eye at the origin that looks along -z. Its field of view is 45 degrees to each side, and its
// picture is opaque grey. A screen 2 m wide and 1 m high stands 2 m in front of the eye. In the picture it
// covers half of the width and a quarter of the height. `facing`: the front of the screen faces the eye.
EyeUpdate eyeBefore(bool facing) {
    EyeUpdate eye;
    eye.image = {kBeneathPixels, kBeneathPixels,
                 std::vector<std::uint8_t>(4 * kBeneathPixels * kBeneathPixels, 50)};
    for (std::size_t i = 0; i < kBeneathPixels * kBeneathPixels; ++i)
        eye.image.rgba[4 * i + 3] = 255;
    const float angle = float(std::atan(1.0));
    eye.view = {{}, -angle, angle, angle, -angle};
    eye.screens[0] = {{Quat(1.0, 0.0, 0.0, 0.0), {0.0, 0.0, -2.0}}, 2.0, 1.0};
    if (!facing) eye.screens[0].stage_from_screen.rotation = Quat(0.0, 0.0, 1.0, 0.0);
    return eye;
}

void clear(EyeUpdate& eye) {
    std::fill(eye.image.rgba.begin(), eye.image.rgba.end(), std::uint8_t(0));
}

// Four pixels: red, green; blue, white.
const render::Image kScreen{2, 2, {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255}};

std::array<int, 3> colourAt(const EyeUpdate& eye, int x, int y) {
    const std::uint8_t* p = &eye.image.rgba[std::size_t(4 * (y * int(kBeneathPixels) + x))];
    return {p[0], p[1], p[2]};
}

TEST(ScreensBeneath, ScreenIsDrawnOnlyWhereTheEyeSeesIt) {
    EyeUpdate eye = eyeBefore(true);
    clear(eye);
    showBeneath(eye, {&kScreen, nullptr, nullptr});
    EXPECT_EQ(colourAt(eye, 26, 39), (std::array{255, 0, 0}));
    EXPECT_EQ(colourAt(eye, 73, 39), (std::array{0, 255, 0}));
    EXPECT_EQ(colourAt(eye, 26, 61), (std::array{0, 0, 255}));
    EXPECT_EQ(colourAt(eye, 73, 61), (std::array{255, 255, 255}));
    for (const auto& [x, y] : {std::pair{24, 50}, {75, 50}, {50, 36}, {50, 63}})
        EXPECT_EQ(colourAt(eye, x, y), (std::array{0, 0, 0})) << x << ", " << y;
}

TEST(ScreensBeneath, OpaquePixelsStayAndBackFacesAreSkipped) {
    EyeUpdate drawn = eyeBefore(true);
    showBeneath(drawn, {&kScreen, nullptr, nullptr});
    EXPECT_EQ(colourAt(drawn, 50, 50), (std::array{50, 50, 50}));
    EyeUpdate behind = eyeBefore(false);
    clear(behind);
    showBeneath(behind, {&kScreen, nullptr, nullptr});
    EXPECT_EQ(colourAt(behind, 30, 45), (std::array{0, 0, 0}));
}

}  // namespace
}  // namespace stylet::trainer
