#include "tests/render/pictures.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

namespace stylet::test {

std::filesystem::path assetsFolder() {
    const char* assets = std::getenv("STYLET_ASSETS");
    if (!assets) throw std::runtime_error("STYLET_ASSETS is not set: run through ctest");
    return assets;
}

std::string noGpuReason() {
    static const std::string reason = [] {
        try {
            const render::Gpu gpu({});
            return std::string();
        } catch (const render::GpuError& e) {
            return std::string("no Vulkan device: ") + e.what();
        }
    }();
    return reason;
}

render::View lookAt(const Vec3& eye_m, const Vec3& at_m, float half_angle) {
    const Vec3 back = glm::normalize(eye_m - at_m);
    const Vec3 right = glm::normalize(glm::cross(Vec3(0, 1, 0), back));
    render::View view;
    view.stage_from_eye = {glm::quat_cast(glm::dmat3(right, glm::cross(back, right), back)), eye_m};
    view.angle_left = view.angle_down = -half_angle;
    view.angle_right = view.angle_up = half_angle;
    return view;
}

std::array<render::View, 2> stereo(const render::View& centre, double ipd_m) {
    std::array<render::View, 2> eyes{centre, centre};
    const Vec3 half = centre.stage_from_eye.direction(Vec3(0.5 * ipd_m, 0, 0));
    eyes[0].stage_from_eye.position_m -= half;
    eyes[1].stage_from_eye.position_m += half;
    return eyes;
}

double psnr(const render::Image& a, const render::Image& b) {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        const double d = double(a.rgba[i]) - double(b.rgba[i]);
        sum += d * d;
        ++count;
    }
    return sum == 0.0 ? std::numeric_limits<double>::infinity()
                      : 10.0 * std::log10(255.0 * 255.0 * double(count) / sum);
}

Blob findBlob(const render::Image& image, const std::function<bool(int, int, int)>& match) {
    Blob blob;
    for (std::uint32_t y = 0; y < image.height; ++y)
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const std::uint8_t* p = &image.rgba[(std::size_t(y) * image.width + x) * 4];
            if (!match(p[0], p[1], p[2])) continue;
            ++blob.pixels;
            blob.x += x + 0.5;
            blob.y += y + 0.5;
        }
    if (blob.pixels) {
        blob.x /= double(blob.pixels);
        blob.y /= double(blob.pixels);
    }
    return blob;
}

}  // namespace stylet::test
