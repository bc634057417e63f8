#include "app/report/film.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "app/report/canvas.h"
#include "app/report/sheet_colours.h"
#include "app/report/slices.h"

namespace stylet::report {

namespace {

constexpr double kWidestPixel_m = 0.0006;
constexpr double kFewestPixels = 480;   // smallest width of a frame
constexpr double kAboveMark_m = 0.010;  // a CT taken in inspiration may end below the dome's highest position
constexpr int kFilmGap = 6, kFilmHeader = 64, kFilmCaption = 34;
constexpr double kScreen = 1.6;  // width over height
constexpr std::array<double, 3> kSurface{255.0, 170.0, 60.0}, kMark{90.0, 230.0, 255.0};
constexpr int kDash = 8;

void blend(std::uint8_t* pixel, const std::array<double, 3>& colour, double share) {
    for (std::size_t c = 0; c < 3; ++c)
        pixel[c] = std::uint8_t(std::lround(pixel[c] + share * (colour[c] - pixel[c])));
}

void drawFrame(Canvas& canvas, double x, double y, const FilmFrame& frame) {
    canvas.image(x, y, frame.width, frame.height, frame.rgb);
    canvas.rectangle(x, y + frame.height, frame.width, kFilmCaption, kDark);
    canvas.text({x + 12, y + frame.height + 23}, frame.caption, {16, kWhite});
}

}  // namespace

FilmFrame coronalFrame(const patient::Patient& patient, const patient::Surrogate& breath, double y_m,
                       double mark_z_m) {
    const Grid& grid = patient.grid();
    const Vec3 low = grid.origin_m;
    Vec3 high = grid.centre(grid.dims - 1);
    high.z = std::max(high.z, mark_z_m + kAboveMark_m);
    const double pixel_m = std::min(kWidestPixel_m, (high.x - low.x) / kFewestPixels);
    FilmFrame frame{int((high.x - low.x) / pixel_m), int((high.z - low.z) / pixel_m), {}, {}};
    const Vec3 middle = 0.5 * (low + high);
    const SlicePlane plane{"", Vec3(middle.x, y_m, middle.z), Vec3(-1, 0, 0), Vec3(0, 0, -1),
                           frame.width * pixel_m};
    std::array<std::size_t, 256> seen{};
    frame.rgb = samplePlane(patient, breath, plane, frame.width, frame.height, seen);
    const patient::MotionModel& motion = patient.package().motion;
    if (motion.empty()) return frame;
    const auto z = [&](int v) { return middle.z - (v - 0.5 * (frame.height - 1)) * pixel_m; };
    for (int v = 0; v < frame.height; ++v)
        for (int u = 0; u < frame.width; ++u) {
            std::uint8_t* const pixel =
                &frame.rgb[(std::size_t(v) * std::size_t(frame.width) + std::size_t(u)) * 3];
            const Vec3 p(middle.x - (u - 0.5 * (frame.width - 1)) * pixel_m, y_m, z(v));
            if (std::fabs(cavityLevel_m(motion, breath, p)) < 0.5 * pixel_m) blend(pixel, kSurface, 0.7);
            if (std::fabs(z(v) - mark_z_m) <= 0.5 * pixel_m && u / kDash % 2 == 0) blend(pixel, kMark, 0.8);
        }
    return frame;
}

FilmFrame sideBySide(const FilmFrame& left, const FilmFrame& right) {
    assert(left.height == right.height);
    FilmFrame both{left.width + right.width, left.height, {}, left.caption};
    for (int v = 0; v < both.height; ++v)
        for (const FilmFrame* eye : {&left, &right}) {
            const auto row = eye->rgb.begin() + std::ptrdiff_t(v) * eye->width * 3;
            both.rgb.insert(both.rgb.end(), row, row + std::ptrdiff_t(eye->width) * 3);
        }
    return both;
}

int sheetColumns(int frames, int width, int height) {
    int best = 1;
    double least = 1e9;
    for (int columns = 1; columns <= frames; ++columns) {
        const int rows = (frames + columns - 1) / columns;
        const double shape = std::fabs(std::log(double(columns) * width / (double(rows) * height) / kScreen));
        const double cost = shape + 4.0 * (columns * rows - frames) / frames;
        if (cost < least) least = cost, best = columns;
    }
    return best;
}

void writeFilm(const std::vector<FilmFrame>& frames, const std::string& title,
               const std::filesystem::path& folder, const std::string& name) {
    assert(!frames.empty());
    const int width = frames.front().width, height = frames.front().height + kFilmCaption;
    const int columns = sheetColumns(int(frames.size()), width, height);
    const int rows = (int(frames.size()) + columns - 1) / columns;
    Canvas sheet(columns * (width + kFilmGap) + kFilmGap, kFilmHeader + rows * (height + kFilmGap), kDark);
    TextStyle heading{24, kWhite, Align::left, true};
    const double room = columns * (width + kFilmGap) - 24.0;
    heading.size *= std::min(1.0, room / sheet.textWidth(title, heading));
    sheet.text({kFilmGap + 12, 42}, title, heading);
    for (int i = 0; i < int(frames.size()); ++i) {
        const FilmFrame& frame = frames[std::size_t(i)];
        drawFrame(sheet, kFilmGap + double(i % columns) * (width + kFilmGap),
                  kFilmHeader + double(i / columns) * (height + kFilmGap), frame);
        Canvas alone(width, height, kDark);
        drawFrame(alone, 0, 0, frame);
        alone.savePng(folder / fmt::format("{}-{:03}.png", name, i));
    }
    sheet.savePng(folder / (name + ".png"));
}

}  // namespace stylet::report
