// stylet-registration-study [--trials N] --out FOLDER: writes the registration error over the number of
// points and the noise, as a table (tre.csv) and as a plot (tre.png).
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string_view>

#include <fmt/core.h>

#include "app/report/chart.h"
#include "tests/xr/registration/study.h"

namespace {

using namespace stylet;
using xr::registration::study::Case;
using xr::registration::study::Errors;
using xr::registration::study::Method;

constexpr std::array kPoints{4, 6, 8, 12, 20};
constexpr std::array kNoise_mm{0.2, 0.5, 1.0, 2.0};
constexpr std::array<report::Colour, 4> kColours{
    report::Colour{0.12, 0.47, 0.71}, {0.17, 0.63, 0.17}, {0.84, 0.37, 0.0}, {0.58, 0.25, 0.60}};
constexpr std::uint64_t kSeed = 1;

struct Series {
    std::string name;
    Case base;
    std::array<std::array<Errors, kPoints.size()>, kNoise_mm.size()> errors;  // noise, points
};

Series measured(const std::string& name, const Case& base, int trials) {
    Series series{name, base, {}};
    for (std::size_t n = 0; n < kNoise_mm.size(); ++n)
        for (std::size_t p = 0; p < kPoints.size(); ++p) {
            Case c = base;
            c.noise_m = 1e-3 * kNoise_mm[n], c.points = kPoints[p];
            series.errors[n][p] = xr::registration::study::run(c, trials, kSeed);
            series.errors[n][p].tre_m.clear();
        }
    return series;
}

void write(std::ofstream& csv, const Series& series) {
    for (std::size_t n = 0; n < kNoise_mm.size(); ++n)
        for (std::size_t p = 0; p < kPoints.size(); ++p) {
            const Errors& e = series.errors[n][p];
            csv << fmt::format("{},{:g},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n",
                               series.name, kNoise_mm[n], kPoints[p], e.trials, 1e3 * e.rms_m,
                               1e3 * e.expected_rms_m, 1e3 * e.mean_m, 1e3 * e.p999_m, 1e3 * e.fre_m,
                               e.accepted, 1e3 * e.mean_accepted_m, 1e3 * e.p999_accepted_m);
        }
}

// Plots the error over the number of points, one colour per noise level. Dots: measured. Lines: expected.
void draw(report::Canvas& canvas, const report::Box& box, const Series& series, const std::string& title) {
    report::Panel axes(canvas, box, {2.0, 22.0, 4.0}, {0.0, 3.0, 0.5});
    canvas.text({box.left, box.top - 16.0}, title, {.size = 17.0, .colour = report::kInk, .bold = true});
    axes.axes("points touched", "error in the 80 mm cube, root mean square [mm]");
    for (std::size_t n = 0; n < kNoise_mm.size(); ++n) {
        std::vector<report::Point> measured_at, expected_at;
        for (std::size_t p = 0; p < kPoints.size(); ++p) {
            const Errors& e = series.errors[n][p];
            measured_at.push_back({double(kPoints[p]), 1e3 * e.rms_m});
            expected_at.push_back({double(kPoints[p]), 1e3 * e.expected_rms_m});
        }
        axes.trace(expected_at, 2.0, kColours[n].faded(0.55));
        for (const report::Point& at : measured_at)
            if (at.y <= 3.0) canvas.disc(axes.at(at.x, at.y), 5.0, kColours[n]);
        const double y_px = box.top + 24.0 + 22.0 * double(n);
        canvas.disc({box.left + box.width - 92.0, y_px - 5.0}, 5.0, kColours[n]);
        canvas.text({box.left + box.width - 78.0, y_px}, fmt::format("{:g} mm", kNoise_mm[n]),
                    {.size = 14.0, .colour = report::kInk});
    }
}

int study(int trials, const std::filesystem::path& out) {
    std::filesystem::create_directories(out);
    const Series plain = measured("plain", {.method = Method::plain}, trials);
    const Series hard = measured(
        "held_hard",
        {.method = Method::held, .gimbal_m = 0.003, .scale_error = 0.005, .delay_s = 0.02, .outliers = 0.1},
        trials);
    std::ofstream csv(out / "tre.csv");
    csv << "series,noise_mm,points,trials,rms_mm,expected_rms_mm,mean_mm,p999_mm,fre_mm,accepted,"
           "mean_accepted_mm,p999_accepted_mm\n";
    write(csv, plain);
    write(csv, hard);
    if (!csv.flush()) throw std::runtime_error((out / "tre.csv").string() + ": cannot be written");

    report::Canvas canvas(1400, 640, report::kPaper);
    draw(canvas, {80.0, 60.0, 570.0, 470.0}, plain, "Points alone; lines: Fitzpatrick's theory");
    draw(canvas, {780.0, 60.0, 570.0, 470.0}, hard, "Everything wrong at once; lines: its own prediction");
    canvas.text({80.0, 612.0},
                std::to_string(trials) +
                    " trials a dot. Noise: standard deviation along an axis of a touched point. All at once: "
                    "3 mm gimbal offset, 0.5 % scale, 20 ms latency, a tenth of the points 10 to 60 mm off.",
                {.size = 14.0, .colour = report::kMuted});
    canvas.savePng(out / "tre.png");
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    int trials = 10'000;
    std::filesystem::path out;
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string_view option = argv[i];
        if (option == "--trials") trials = std::atoi(argv[i + 1]);
        if (option == "--out") out = argv[i + 1];
    }
    if (out.empty() || trials < 1) {
        std::fprintf(stderr, "usage: stylet-registration-study [--trials N] --out FOLDER\n");
        return 2;
    }
    try {
        return study(trials, out);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-registration-study: %s\n", e.what());
        return 1;
    }
}
