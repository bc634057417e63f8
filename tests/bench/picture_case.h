// The picture that both renderers are asked for: one volume, one transfer function over HU, one camera.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "render/scene.h"
#include "render/volume/look.h"
#include "tests/bench/bench.h"

namespace stylet::bench {

inline constexpr std::array<const char*, 3> kPictureLooks{"soft", "bone", "skin"};
inline constexpr double kMatched_db = 40.0;  // of each against its own picture at a tenth of a voxel

struct PictureCase {
    patient::Package package;
    // The eye stands 0.70 m before the middle of the body, which fills most of the view.
    render::Vec3 eye_m, at_m;
    double half_angle = 0.28;

    PictureCase();  // 16 million voxels, as many as 256^3; takes some seconds
};

render::LookStyle pictureLook(const std::string& name);  // tests/bench/looks

// What a look says of every HU in [-1024, 3072): extinction in 1/m, linear colour.
struct HuTable {
    std::vector<double> extinction_per_m;
    std::vector<glm::vec3> colour_linear;
};
HuTable huTable(const render::LookStyle&, const patient::Patient&);

// 8-bit RGBA, of any renderer.
struct Pixels {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};
double psnr(const Pixels&, const Pixels&);
void writePpm(const std::string& path,
              const Pixels&);  // to look at, where STYLET_BENCH_PICTURES names a folder

// Draws a square picture of `size` with a step of so many voxels; 0: the reference.
using Draw = std::function<Pixels(int size, double step_voxels)>;
// The coarsest step that is matched at 512 x 512, what it costs (median), and the steps on the way to it;
// then that step at 1024 x 1024, whose own reference only the long form waits for. `share`: of a draw that is
// one view's.
void matchedRows(const std::string& name, const std::string& note, const std::vector<double>& steps,
                 const Draw&, std::vector<Row>&, double share = 1.0);

}  // namespace stylet::bench
