#include "tests/bench/bedside.h"
#include <fmt/core.h>

#include <algorithm>

namespace stylet::bench {

namespace {

constexpr int kRepeats = 5;

render::Image cropTile(const render::Image& image, std::uint32_t x0, std::uint32_t y0) {
    render::Image tile{kTile, kTile, {}};
    for (std::uint32_t y = y0; y < y0 + kTile; ++y) {
        const auto row = image.rgba.begin() + std::ptrdiff_t(4 * (y * image.width + x0));
        tile.rgba.insert(tile.rgba.end(), row, row + 4 * kTile);
    }
    return tile;
}

}  // namespace

Eyes Bedside::picture(const render::RenderSettings& settings, DrawTimes* times) {
    renderer.setSettings(settings);
    // Warm-up, not timed: compiles the pipelines that the settings need.
    Eyes seen = renderer.drawToImages(scene, eyes, pixels, pixels);
    if (!times) return seen;
    std::vector<double> whole, opaque, volume;
    for (int i = 0; i < kRepeats; ++i) {
        renderer.drawToImages(scene, eyes, pixels, pixels, &times->last);
        whole.push_back(times->last.gpu_ms);
        opaque.push_back(times->last.opaque_ms);
        volume.push_back(times->last.volume_ms);
    }
    times->whole_ms = median(whole), times->opaque_ms = median(opaque), times->volume_ms = median(volume);
    return seen;
}

Bedside bedside(render::Renderer& renderer, const patient::Patient& patient, double distance_m) {
    const Grid& grid = patient.grid();
    const Vec3 middle = grid.origin_m + 0.5 * grid.spacing_m * Vec3(grid.dims - 1);
    render::RenderScene scene;
    scene.stage_from_patient.position_m = Vec3(0.0, 1.0, 0.0) - middle;
    scene.breath = patient.package().motion.reference;
    scene.patient_from_needle = Pose{glm::angleAxis(1.2, Vec3(0, 1, 0)), middle + Vec3(0.08, 0.02, 0.0)};
    const Vec3 at(0.03, 1.0, 0.0), from(0.35, 1.35, 0.25);
    const Vec3 eye = at + (from - at) * (distance_m / glm::length(from - at));
    return {renderer, scene, test::stereo(test::lookAt(eye, at, 0.42f), 0.063)};
}

Distance distance(const Eyes& a, const Eyes& b) {
    Distance d;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        d.whole_db = std::min(d.whole_db, test::psnr(a[eye], b[eye]));
        for (std::uint32_t y = 0; y + kTile <= a[eye].height; y += kTile)
            for (std::uint32_t x = 0; x + kTile <= a[eye].width; x += kTile)
                d.tile_db = std::min(d.tile_db, test::psnr(cropTile(a[eye], x, y), cropTile(b[eye], x, y)));
    }
    return d;
}

std::string tileNote(const Distance& d) {
    return fmt::format("worst {} x {} tile {:.1f} dB{}", kTile, kTile, d.tile_db,
                       d.tile_db < kPictureBound_db ? ": too coarse" : "");
}

}  // namespace stylet::bench
