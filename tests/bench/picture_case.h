// The scene that both renderers draw: one volume, one transfer function over HU, one camera.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "render/scene/scene.h"
#include "render/volume/look.h"
#include "tests/bench/bench.h"

namespace stylet::bench {

inline constexpr std::array<const char*, 3> kPictureLooks{"soft", "bone", "skin"};
inline constexpr double kMatched_db = 40.0;  // each renderer against its own picture at 0.1 voxel

struct PictureCase {
    patient::Package package;
    // The eye is 0.70 m in front of the middle of the body, which fills most of the view.
    Vec3 eye_m, at_m;
    double half_angle = 0.28;

    PictureCase();  // 16 million voxels, as many as 256^3; takes some seconds
};

render::LookStyle pictureLook(const std::string& name);  // tests/bench/looks

// A look's values for every HU in [-1024, 3072): extinction in 1/m, linear colour.
struct HuTable {
    std::vector<double> extinction_per_m;
    std::vector<glm::vec3> colour_linear;
};
HuTable huTable(const render::LookStyle&, const patient::Patient&);

// 8-bit RGBA picture of any renderer.
struct Pixels {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};
double psnr(const Pixels&, const Pixels&);
void writePpm(const std::string& path,
              const Pixels&);  // for viewing, if STYLET_BENCH_PICTURES names a folder

// Draws a square picture of `size` pixels with this step; 0: the reference.
using Draw = std::function<Pixels(int size, double step_voxels)>;
// Appends a row for each step up to the coarsest one that reaches kMatched_db at 512 x 512, with its median
// time. Then a row for that step at 1024 x 1024; only the long form renders a reference for it. `share`: part
// of a draw's time that belongs to one view.
void matchedRows(const std::string& name, const std::string& note, const std::vector<double>& steps,
                 const Draw&, std::vector<Row>&, double share = 1.0);

}  // namespace stylet::bench
