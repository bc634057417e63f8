#include "app/report/breath.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "app/report/chart.h"
#include "base/format.h"
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

Range rangeOf(double low, double high, int parts) {
    const double step = niceStep(std::max(high - low, 1e-3), parts);
    return {step * std::floor(low / step), step * std::ceil(high / step), step};
}

// An axis range that covers `value` over all samples, and zero.
template <typename Value>
Range rangeOver(const std::vector<BreathSample>& samples, int parts, const Value& value) {
    double low = 0.0, high = 0.0;
    for (const BreathSample& s : samples)
        low = std::min(low, value(s)), high = std::max(high, value(s));
    return rangeOf(low, high, parts);
}

// The time intervals of the breath-holds.
std::vector<std::array<double, 2>> holds(const std::vector<BreathSample>& samples) {
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
    canvas.text({x + 36, y}, text, {14, kInk, Align::left, false});
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

DomeFollows domeFollows(const std::vector<BreathSample>& samples) {
    DomeFollows f;
    double n = 0.0, v = 0.0, d = 0.0, vv = 0.0, vd = 0.0, dd = 0.0, least = 1e9, most = -1e9;
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
        least = std::min(least, s.dome_m), most = std::max(most, s.dome_m);
    }
    if (n < 2.0) return f;
    const double of_v = vv - v * v / n, of_both = vd - v * d / n, of_dome = dd - d * d / n;
    f.travel_m = most - least;
    if (of_v <= 0.0 || of_dome <= 0.0) return f;
    f.correlation = of_both / std::sqrt(of_v * of_dome);
    f.per_v_m = of_both / of_v;
    f.off_line_m = std::sqrt(std::max(0.0, of_dome - of_both * of_both / of_v) / n);
    return f;
}

void writeBreathCsv(const std::vector<BreathSample>& samples, const std::filesystem::path& file) {
    std::string csv;
    csv += "time_s,v,rate_per_s,creep_v,held,dome_mm\n";
    for (const BreathSample& s : samples) {
        std::array<char, 120> line{};
        std::snprintf(line.data(), line.size(), "%.3f,%.5f,%.5f,%.5f,%d,%.4f\n", s.t_s, s.breath.v,
                      s.breath.rate_per_s, s.breath.creep_v, s.held ? 1 : 0, 1e3 * s.dome_m);
        csv += line.data();
    }
    writeWholeFile(file, csv);
}

void drawBreath(const std::vector<BreathSample>& samples, const std::string& title, const std::string& signal,
                const std::filesystem::path& png) {
    const DomeFollows follows = domeFollows(samples);
    const double per_v_mm = 1e3 * follows.per_v_m;
    const auto dome_mm = [](const BreathSample& s) { return 1e3 * s.dome_m; };
    const auto v = [](const BreathSample& s) { return s.breath.v; };
    Range mm =
        rangeOver(samples, 7, [&](const BreathSample& s) { return std::max(dome_mm(s), per_v_mm * v(s)); });
    mm.low = std::min(mm.low, rangeOver(samples, 7, dome_mm).low);
    const double end_s = samples.empty() ? 1.0 : samples.back().t_s;
    const Range time{0.0, end_s, niceStep(end_s, 12)};

    Canvas canvas(kBreathWidth, kBreathHeight, kPaper);
    canvas.text({24, 40}, title, {21, kInk, Align::left, true});
    Panel course(canvas, {76, 96, 920, 390}, time, mm);
    for (const auto& [from, to] : holds(samples))
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
    legend(canvas, 200, 80, kSignal, signal + formatted(", times %.1f mm", per_v_mm));

    Panel loop(canvas, {1080, 96, 390, 390}, rangeOver(samples, 5, v), mm);
    loop.axes("signal v", "toward the feet [mm]");
    std::vector<Point> stretch;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        stretch.push_back({v(samples[i]), dome_mm(samples[i])});
        if (i + 1 < samples.size() && samples[i + 1].held == samples[i].held) continue;
        loop.trace(stretch, samples[i].held ? 5.0 : 1.8, samples[i].held ? kHold : kFree);
        stretch.assign(1, stretch.back());
    }
    canvas.text({1080, 80},
                formatted("r = %.3f", follows.correlation) +
                    formatted(", beside the line %.2f mm", 1e3 * follows.off_line_m),
                {14, kInk, Align::left, false});
    canvas.savePng(png);
}

}  // namespace stylet::report
