// The patient on the table as somebody beside it sees him, and how far two pictures of him are apart.
#pragma once

#include <array>
#include <cstdint>

#include "patient/synth/synth.h"
#include "tests/bench/bench.h"
#include "tests/render/pictures.h"

namespace stylet::bench {

using Eyes = std::array<render::Image, 2>;

inline constexpr std::uint32_t kTile = 64;
inline constexpr double kPictureBound_db =
    40.0;  // of the worst tile: grain gathers, and a mean over the picture hides it

struct Bedside {
    render::Renderer& renderer;
    render::RenderScene scene;
    std::array<render::View, 2> eyes;
    std::uint32_t pixels = 256;

    // Of five frames, where a time is asked for: what the GPU took, whole and for the volume alone.
    struct Took {
        double whole_ms = 0.0, opaque_ms = 0.0, volume_ms = 0.0;
        render::RenderStats last;
    };
    Eyes picture(const render::RenderSettings&, Took* = nullptr);
};

// From beside the table, bent over; nearer by what `distance_m` leaves of the 0.55 m.
Bedside bedside(render::Renderer&, const patient::Patient&, double distance_m = 0.55);

patient::Package bedsidePatient();  // of 2 mm voxels

// Of the worse eye, dB. Equals have the number of one value in a million being off by one.
struct Distance {
    double whole_db = 108.0, tile_db = 108.0;
};
Distance distance(const Eyes&, const Eyes&);

// "worst 64 x 64 tile 41.2 dB", and "too coarse" below the bound.
std::string tileNote(const Distance&);

}  // namespace stylet::bench
