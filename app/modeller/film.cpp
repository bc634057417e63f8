#include "app/modeller/film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace stylet::modeller {

namespace {

using patient::Index3;
using patient::Package;
using patient::Surrogate;
using patient::Vec3;

constexpr double kTick_s = 0.001;
constexpr int kColumns = 6, kShrink = 2;
constexpr std::array<double, 3> kSurfaceColour{255.0, 170.0, 60.0};

// Linear between voxels; air beyond the image.
double ctAt(const patient::CtVolume& ct, const Vec3& p) {
    const Vec3 at = ct.grid.toVoxels(p);
    const Index3 low(glm::floor(at));
    if (!ct.grid.contains(low) || !ct.grid.contains(low + 1)) return ct.nearestOr(p, -1000);
    const Vec3 f = at - Vec3(low);
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const Index3 up{corner & 1, corner >> 1 & 1, corner >> 2};
        const double wx = up.x ? f.x : 1.0 - f.x, wy = up.y ? f.y : 1.0 - f.y, wz = up.z ? f.z : 1.0 - f.z;
        sum += wx * wy * wz * double(ct[low + up]);
    }
    return sum;
}

template <typename Visit>
void forEachLiverVoxel(const Package& package, const Visit& visit) {
    const patient::Patient patient(package);
    const patient::Grid& grid = package.labels.grid;
    Index3 i;
    for (i.z = 0; i.z < grid.dims.z; ++i.z)
        for (i.y = 0; i.y < grid.dims.y; ++i.y)
            for (i.x = 0; i.x < grid.dims.x; ++i.x) {
                const patient::Label* const label = patient.label(package.labels[i]);
                if (label && label->tissue == patient::Tissue::liver) visit(grid.centre(i));
            }
}

Picture contactSheet(const std::vector<Picture>& frames) {
    const int width = frames.front().width / kShrink, height = frames.front().height / kShrink;
    const int rows = (int(frames.size()) + kColumns - 1) / kColumns;
    Picture sheet{width * kColumns, height * rows, {}};
    sheet.rgb.resize(std::size_t(sheet.width) * std::size_t(sheet.height) * 3);
    for (std::size_t k = 0; k < frames.size(); ++k)
        for (int v = 0; v < height; ++v)
            for (int u = 0; u < width; ++u)
                for (int c = 0; c < 3; ++c) {
                    int sum = 0;
                    for (int dv = 0; dv < kShrink; ++dv)
                        for (int du = 0; du < kShrink; ++du)
                            sum += frames[k].rgb[std::size_t(
                                ((v * kShrink + dv) * frames[k].width + u * kShrink + du) * 3 + c)];
                    const int x = int(k) % kColumns * width + u, y = int(k) / kColumns * height + v;
                    sheet.rgb[std::size_t((y * sheet.width + x) * 3 + c)] =
                        std::uint8_t(sum / (kShrink * kShrink));
                }
    return sheet;
}

}  // namespace

Picture breathingSlice(const Package& package, const Surrogate& breath, double y_m, const Window& window) {
    const patient::Grid& grid = package.ct.grid;
    const double pixel_m = std::min(grid.spacing_m.x, grid.spacing_m.z);
    Picture picture;
    picture.width = int(std::floor(grid.spacing_m.x * grid.dims.x / pixel_m));
    picture.height = int(std::floor(grid.spacing_m.z * grid.dims.z / pixel_m));
    picture.rgb.resize(std::size_t(picture.width) * std::size_t(picture.height) * 3);
    const Vec3 far = grid.centre(grid.dims - 1);
    for (int v = 0; v < picture.height; ++v)
        for (int u = 0; u < picture.width; ++u) {
            const Vec3 p(far.x - u * pixel_m, y_m, far.z - v * pixel_m);
            const double hu = ctAt(package.ct, referenceFromDeformed(package.motion, breath, p));
            const double grey = 255.0 * std::clamp((hu - window.level_hu) / window.width_hu + 0.5, 0.0, 1.0);
            const double level_m = cavityLevel_m(package.motion, breath, p);
            const double over = package.motion.empty() || std::fabs(level_m) > 0.5 * pixel_m ? 0.0 : 0.7;
            std::uint8_t* const out =
                &picture.rgb[(std::size_t(v) * std::size_t(picture.width) + std::size_t(u)) * 3];
            for (std::size_t c = 0; c < 3; ++c)
                out[c] = std::uint8_t(grey * (1.0 - over) + kSurfaceColour[c] * over + 0.5);
        }
    return picture;
}

Film planFilm(const Package& package, const patient::BreathPlan& plan, int frames, double seconds) {
    Film film;
    Vec3 dome(0.0), sum(0.0);
    double count = 0.0;
    forEachLiverVoxel(package, [&](const Vec3& p) {
        if (count == 0.0 || p.z > dome.z) dome = p;
        sum += p, count += 1.0;
    });
    film.y_m = count > 0.0 ? sum.y / count : package.ct.grid.centre(package.ct.grid.dims / 2).y;
    const double exhaled_m = deformedFromReference(package.motion, {}, dome).z;
    patient::BreathingState state;
    const int ticks = int(std::floor(seconds / kTick_s + 0.5));
    for (int frame = 0, tick = 0; frame < frames; ++frame) {
        for (; tick < int(std::int64_t(ticks) * frame / frames); ++tick)
            stepBreathing(state, plan, kTick_s);
        const Surrogate breath = surrogateAt(state, plan, kTick_s);
        film.moments.push_back(
            {tick * kTick_s, breath, exhaled_m - deformedFromReference(package.motion, breath, dome).z});
    }
    return film;
}

void writeFilm(const Package& package, const Film& film, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    std::ofstream csv(folder / "dome.csv");
    csv << "time_s,v,rate_per_s,dome_mm\n";
    std::vector<Picture> frames;
    for (const FilmMoment& moment : film.moments) {
        frames.push_back(breathingSlice(package, moment.breath, film.y_m, {}));
        char name[32], line[120];
        std::snprintf(name, sizeof name, "frame-%03d.png", int(frames.size()) - 1);
        writePng(frames.back(), folder / name);
        std::snprintf(line, sizeof line, "%.3f,%.4f,%.4f,%.3f\n", moment.t_s, moment.breath.v,
                      moment.breath.rate_per_s, 1e3 * moment.dome_m);
        csv << line;
    }
    csv.close();
    if (!csv) throw patient::DataError(folder / "dome.csv", "file", "cannot be written");
    writePng(contactSheet(frames), folder / "sheet.png");
}

}  // namespace stylet::modeller
