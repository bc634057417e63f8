// Renders the patient on the table as seen by a user beside it, and measures the difference of two pictures.
#pragma once

#include <array>
#include <cstdint>

#include "tests/bench/bench.h"
#include "tests/render/pictures.h"

namespace stylet::bench {

using Eyes = std::array<render::Image, 2>;

inline constexpr std::uint32_t kTile = 64;
inline constexpr double kPictureBound_db =
    40.0;  // of the worst tile: grain is local, and a mean over the picture hides it

struct Bedside {
    render::Renderer& renderer;
    render::RenderScene scene;
    std::array<render::View, 2> eyes;
    std::uint32_t pixels = 256;

    // GPU times over five frames, if times are requested.
    struct DrawTimes {
        double whole_ms = 0.0, opaque_ms = 0.0, volume_ms = 0.0;
        render::RenderStats last;
    };
    Eyes picture(const render::RenderSettings&, DrawTimes* = nullptr);
};

// The view from beside the table, leaning over it, at `distance_m`.
Bedside bedside(render::Renderer&, const patient::Patient&, double distance_m = 0.55);

// PSNR of the worse eye [dB]. Equal pictures get the PSNR of a single difference of 1 among a million values.
struct Distance {
    double whole_db = 108.0, tile_db = 108.0;
};
Distance distance(const Eyes&, const Eyes&);

// "worst 64 x 64 tile 41.2 dB", and "too coarse" below the bound.
std::string tileNote(const Distance&);

}  // namespace stylet::bench
