#include "app/report/breath.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/report/chart.h"
#include "base/whole_file.h"

namespace stylet::report {

using patient::Surrogate;

namespace {

constexpr int kBreathWidth = 1500, kBreathHeight = 560;
constexpr std::int16_t kTissue_hu = -300;  // halfway between lung and tissue
constexpr double kOffWall_m = 0.015;
constexpr Colour kDome{0.13, 0.33, 0.60}, kSignal{0.85, 0.45, 0.10}, kHeld{0.90, 0.93, 0.88},
    kFree{0.13, 0.33, 0.60, 0.55}, kHold{0.30, 0.60, 0.25};

// A step of 1, 2 or 5 times a power of ten that divides `span` into at most `parts` parts.
double niceStep(double span, int parts) {
    double step = 1e-3;
    for (int i = 0; step * parts < span; ++i)
        step *= i % 3 == 1 ? 2.5 : 2.0;
    return step;
}

Range axisRange(double low, double high, int parts) {
    const double step = niceStep(std::max(high - low, 1e-3), parts);
    return {step * std::floor(low / step), step * std::ceil(high / step), step};
}

// An axis range that covers `value` over all samples, and zero.
template <typename Value>
Range sampleRange(const std::vector<BreathSample>& samples, int parts, const Value& value) {
    double low = 0.0, high = 0.0;
    for (const BreathSample& s : samples)
        low = std::min(low, value(s)), high = std::max(high, value(s));
    return axisRange(low, high, parts);
}

// The time intervals of the breath-holds.
std::vector<std::array<double, 2>> breathHolds(const std::vector<BreathSample>& samples) {
    std::vector<std::array<double, 2>> found;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!samples[i].held) continue;
        if (i == 0 || !samples[i - 1].held) found.push_back({samples[i].t_s, samples[i].t_s});
        found.back()[1] = samples[i].t_s;
    }
    return found;
}

void legend(Canvas& canvas, double x, double y, Colour colour, const std::string& text) {
    canvas.line({x, y - 5}, {x + 28, y - 5}, 3, colour);
    canvas.text({x + 36, y}, text, {14, kInk});
}

}  // namespace

Vec3 domePoint(const patient::Patient& patient) {
    const LabelVolume& labels = patient.package().labels;
    Index3 i;
    for (i.z = labels.grid.dims.z - 1; i.z >= 0; --i.z)
        for (i.y = 0; i.y < labels.grid.dims.y; ++i.y)
            for (i.x = 0; i.x < labels.grid.dims.x; ++i.x) {
                const patient::Label* const label = patient.label(labels[i]);
                if (label && label->tissue == patient::Tissue::liver) return labels.grid.centre(i);
            }
    const CtVolume& ct = patient.package().ct;
    Vec3 farthest = ct.grid.centre(ct.grid.dims / 2);
    double most_m = 0.0;
    for (i.y = 0; i.y < ct.grid.dims.y; ++i.y)
        for (i.x = 0; i.x < ct.grid.dims.x; ++i.x) {
            for (i.z = 0; i.z < ct.grid.dims.z && ct[i] >= kTissue_hu;)
                ++i.z;
            const Vec3 top = ct.grid.centre(i - Index3(0, 0, 1));
            if (i.z == 0 || i.z == ct.grid.dims.z) continue;
            if (cavityLevel_m(patient.package().motion, top) > -kOffWall_m) continue;
            const double down_m = domeBelowExhale_m(patient, {1.0, 0.0}, top);
            if (down_m > most_m) most_m = down_m, farthest = top;
        }
    return farthest;
}

double domeBelowExhale_m(const patient::Patient& patient, const Surrogate& breath, const Vec3& dome_m) {
    const patient::MotionModel& motion = patient.package().motion;
    return deformedFromReference(motion, {}, dome_m).z - deformedFromReference(motion, breath, dome_m).z;
}

DomeRegression fitDomeMotion(const std::vector<BreathSample>& samples) {
    DomeRegression f;
    double n = 0.0, v = 0.0, d = 0.0, vv = 0.0, vd = 0.0, dd = 0.0, lowest_m = 1e9, highest_m = -1e9;
    bool any_held = false;
    for (const BreathSample& s : samples) {
        if (s.held) {
            f.held_from_m = any_held ? std::min(f.held_from_m, s.dome_m) : s.dome_m;
            f.held_to_m = any_held ? std::max(f.held_to_m, s.dome_m) : s.dome_m;
            any_held = true;
            continue;
        }
        n += 1.0, v += s.breath.v, d += s.dome_m;
        vv += s.breath.v * s.breath.v, vd += s.breath.v * s.dome_m, dd += s.dome_m * s.dome_m;
        lowest_m = std::min(lowest_m, s.dome_m), highest_m = std::max(highest_m, s.dome_m);
    }
    if (n < 2.0) return f;
    const double of_v = vv - v * v / n, of_both = vd - v * d / n, of_dome = dd - d * d / n;
    f.travel_m = highest_m - lowest_m;
    if (of_v <= 0.0 || of_dome <= 0.0) return f;
    f.correlation = of_both / std::sqrt(of_v * of_dome);
    f.slope_m = of_both / of_v;
    f.residual_rms_m = std::sqrt(std::max(0.0, of_dome - of_both * of_both / of_v) / n);
    return f;
}

void writeBreathCsv(const std::vector<BreathSample>& samples, const std::filesystem::path& file) {
    std::string csv = "time_s,v,rate_per_s,creep_v,held,dome_mm\n";
    for (const BreathSample& s : samples)
        csv += fmt::format("{:.3f},{:.5f},{:.5f},{:.5f},{:d},{:.4f}\n", s.t_s, s.breath.v,
                           s.breath.rate_per_s, s.breath.creep_v, s.held, 1e3 * s.dome_m);
    writeWholeFile(file, csv);
}

void drawBreath(const std::vector<BreathSample>& samples, const std::string& title, const std::string& signal,
                const std::filesystem::path& png) {
    const DomeRegression regression = fitDomeMotion(samples);
    const double per_v_mm = 1e3 * regression.slope_m;
    const auto dome_mm = [](const BreathSample& s) { return 1e3 * s.dome_m; };
    const auto v = [](const BreathSample& s) { return s.breath.v; };
    Range mm =
        sampleRange(samples, 7, [&](const BreathSample& s) { return std::max(dome_mm(s), per_v_mm * v(s)); });
    mm.low = std::min(mm.low, sampleRange(samples, 7, dome_mm).low);
    const double end_s = samples.empty() ? 1.0 : samples.back().t_s;
    const Range time{0.0, end_s, niceStep(end_s, 12)};

    Canvas canvas(kBreathWidth, kBreathHeight, kPaper);
    canvas.text({24, 40}, title, {21, kInk, Align::left, true});
    Panel course(canvas, {76, 96, 920, 390}, time, mm);
    for (const auto& [from, to] : breathHolds(samples))
        course.band(from, to, kHeld, "held");
    course.axes("time [s]", "toward the feet [mm]");
    std::vector<Point> dome, driven;
    for (const BreathSample& s : samples) {
        dome.push_back({s.t_s, dome_mm(s)});
        driven.push_back({s.t_s, per_v_mm * v(s)});
    }
    course.trace(driven, 2.0, kSignal);
    course.trace(dome, 2.5, kDome);
    legend(canvas, 84, 80, kDome, "dome");
    legend(canvas, 200, 80, kSignal, fmt::format("{}, times {:.1f} mm", signal, per_v_mm));

    Panel loop(canvas, {1080, 96, 390, 390}, sampleRange(samples, 5, v), mm);
    loop.axes("signal v", "toward the feet [mm]");
    std::vector<Point> stretch;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        stretch.push_back({v(samples[i]), dome_mm(samples[i])});
        if (i + 1 < samples.size() && samples[i + 1].held == samples[i].held) continue;
        loop.trace(stretch, samples[i].held ? 5.0 : 1.8, samples[i].held ? kHold : kFree);
        stretch.assign(1, stretch.back());
    }
    canvas.text({1080, 80},
                fmt::format("r = {:.3f}, beside the line {:.2f} mm", regression.correlation,
                            1e3 * regression.residual_rms_m),
                {14, kInk});
    canvas.savePng(png);
}

}  // namespace stylet::report
