// Cameras, comparisons and a GPU for picture tests.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>

#include "render/render.h"

namespace stylet::test {

std::filesystem::path assetsFolder();

// Returns the reason why there is no GPU; empty if there is one. Tests that need one use GpuFixture
// (gpu_fixture.h).
std::string noGpuReason();

// An eye at `eye_m` that looks at `at_m`, with +y up and a symmetric field of view of `half_angle`.
render::View lookAt(const Vec3& eye_m, const Vec3& at_m, float half_angle);

// A left and a right eye, `ipd_m` apart, parallel.
std::array<render::View, 2> stereo(const render::View& centre, double ipd_m);

// Peak signal to noise ratio over the colour channels, dB. Infinity for equal pictures.
double psnr(const render::Image&, const render::Image&);

struct Blob {
    std::size_t pixels = 0;
    double x = 0.0, y = 0.0;  // centre, pixels from the top left corner of the picture
};
// Finds the pixels for which `match(r, g, b)` returns true.
Blob findBlob(const render::Image&, const std::function<bool(int, int, int)>& match);

}  // namespace stylet::test
