#include "app/trainer/window/screens_beneath.h"

#include <algorithm>
#include <cmath>

namespace stylet::trainer {
namespace {

// A screen as seen by the eye. In the screen's frame, the ray through (x, y, -1) starts at origin_m and has
// the direction x * across + y * up + ahead.
struct Glass {
    Vec3 origin_m, across, up;  // position and axes of the eye, in the screen's frame
    Vec3 ahead;
    double width_m = 0.0, height_m = 0.0;
    const render::Image* picture = nullptr;
};

Glass projectScreen(const render::ScreenPlace& place, const Pose& stage_from_eye,
                    const render::Image& picture) {
    const Pose screen_from_eye = place.stage_from_screen.inverse() * stage_from_eye;
    return {screen_from_eye.position_m,
            screen_from_eye.direction({1.0, 0.0, 0.0}),
            screen_from_eye.direction({0.0, 1.0, 0.0}),
            screen_from_eye.direction({0.0, 0.0, -1.0}),
            place.width_m,
            place.height_m,
            &picture};
}

// Returns the pixel at which the ray meets the screen's front, or null.
const std::uint8_t* hit(const Glass& glass, double x, double y) {
    const Vec3 ray = x * glass.across + y * glass.up + glass.ahead;
    if (glass.origin_m.z <= 0.0 || ray.z >= 0.0) return nullptr;
    const Vec3 at = glass.origin_m - (glass.origin_m.z / ray.z) * ray;
    const double u = at.x / glass.width_m + 0.5, v = 0.5 - at.y / glass.height_m;
    if (u < 0.0 || u >= 1.0 || v < 0.0 || v >= 1.0) return nullptr;
    const render::Image& picture = *glass.picture;
    const std::size_t column = std::size_t(u * picture.width), row = std::size_t(v * picture.height);
    return picture.rgba.data() + 4 * (row * picture.width + column);
}

}  // namespace

void showBeneath(EyeUpdate& eye, const std::array<const render::Image*, 3>& screens) {
    std::array<Glass, 3> glasses;
    std::size_t count = 0;
    for (std::size_t i = 0; i < screens.size(); ++i)
        if (screens[i] && screens[i]->width > 0 && eye.screens[i].width_m > 0.0)
            glasses[count++] = projectScreen(eye.screens[i], eye.view.stage_from_eye, *screens[i]);
    if (count == 0) return;
    const double left = std::tan(eye.view.angle_left), right = std::tan(eye.view.angle_right),
                 up = std::tan(eye.view.angle_up), down = std::tan(eye.view.angle_down);
    render::Image& image = eye.image;
    std::uint8_t* pixel = image.rgba.data();
    for (std::uint32_t j = 0; j < image.height; ++j)
        for (std::uint32_t i = 0; i < image.width; ++i, pixel += 4) {
            if (pixel[3] == 255) continue;
            const double x = left + (right - left) * (i + 0.5) / image.width;
            const double y = up + (down - up) * (j + 0.5) / image.height;
            const int clear = 255 - pixel[3];
            for (std::size_t g = 0; g < count; ++g) {
                const std::uint8_t* below = hit(glasses[g], x, y);
                if (!below) continue;
                for (int c = 0; c < 3; ++c)
                    pixel[c] = std::uint8_t(std::min(255, pixel[c] + below[c] * clear / 255));
                break;
            }
        }
}

}  // namespace stylet::trainer
