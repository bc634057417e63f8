#include "app/trainer/window/metrics.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "app/trainer/session/flight.h"
#include "base/statistics.h"
#include "patient/tissue/tissue.h"

namespace stylet::trainer {
namespace {

constexpr report::Colour kGlass{0.035, 0.045, 0.055}, kGrid{0.13, 0.17, 0.20},
    kMetricsQuiet{0.52, 0.58, 0.62}, kMetricsWords{0.86, 0.90, 0.92}, kForce{0.98, 0.78, 0.25},
    kOther{0.62, 0.86, 0.60}, kFrame{0.45, 0.80, 0.98}, kAlarm{1.0, 0.42, 0.36};

std::string milliseconds(double ms) {
    return fmt::format("{:.{}f} ms", ms, ms < 100.0 ? 1 : 0);
}

constexpr std::array<std::string_view, 3> kNeedleStates{"outside", "held", "passing"};  // by haptics::Phase

struct Row {
    std::string what, value;
    bool alarm = false;
};

// Smallest force difference that a hand can perceive (Mastmeyer et al. 2017).
constexpr double kPerceptible_n = 0.145;

// Rows that span the whole width.
std::vector<Row> truthRows(const ForceComparisonReading& truth) {
    if (!truth.known) return {{"force truth", "no full segmentation of this patient"}};
    const ForceError& error = truth.insertion;
    return {{"force truth",
             fmt::format("full {:.2f} N, partial {:.2f} N, error {:+.2f} N", truth.full_n, truth.partial_n,
                         truth.error_n()),
             std::fabs(truth.error_n()) > kPerceptible_n},
            {"this insertion",
             error.ticks == 0
                 ? "\u2013"
                 : fmt::format("RMS {:.2f} N, largest {:.2f} N, {:.1f} % equal", error.rms_n(),
                               error.largest_n, 100.0 * double(error.equal_ticks) / double(error.ticks))}};
}

std::vector<Row> rowsOf(const StateUpdate& state, const std::deque<FrameSample>& samples, bool show_hidden) {
    const haptics::TickOutput& tick = state.seen.tick;
    std::vector<double> frames_ms;
    for (const FrameSample& sample : samples)
        frames_ms.push_back(sample.frame_ms);
    const bool inside = tick.phase != haptics::Phase::outside;
    const bool off = tick.stage == haptics::ForceStage::off || tick.stage == haptics::ForceStage::fading;
    const std::string tool(haptics::kToolNames[std::size_t(tick.tool)]);
    std::vector<Row> rows{
        {"tool", tool},
        {"needle", std::string(enumName(kNeedleStates, tick.phase))},
        {"depth", inside ? fmt::format("{:.1f} mm", 1e3 * tick.depth_m) : "\u2013"},
        {"tissue", inside ? std::string(patient::tissueName(tick.tissue)) : "\u2013"},
        {"force", fmt::format("{:.2f} N", toolForce_n(tick))},
        {"device",
         state.seen.input_only
             ? "input only"
             : fmt::format("{}, {:.0f} %", enumName(kForceStageNames, tick.stage), 100.0 * tick.level),
         off},
        {"breath", tick.breath_held ? "held" : fmt::format("{:.0f} %", 100.0 * tick.breath.v)},
        {"frame", milliseconds(lowerQuantile(frames_ms, 0.5))},
        {"slowest 1 %", milliseconds(lowerQuantile(frames_ms, 0.99))},
        {"seen\u2013felt",
         state.hand_offset_m ? fmt::format("{:.1f} mm", 1e3 * *state.hand_offset_m) : "not measured"},
        {"headset",
         !state.headset                          ? "none"
         : state.attention == Attention::focused ? "worn"
         : state.attention == Attention::away    ? "away: paused"
                                                 : "not yet worn",
         state.attention == Attention::away},
        {"faults", tick.faults == 0 ? "none" : joinFaults(tick.faults, ", ", &haptics::FaultText::name),
         tick.faults != 0},
    };
    if (!show_hidden) rows.erase(rows.begin() + 1, rows.begin() + 5);  // needle, depth, tissue, force
    return rows;
}

struct Graph {
    double x, y, width, height, unit;
};

struct Curve {
    std::string name;
    report::Colour colour;
    double (*value)(const FrameSample&);
};

// Draws the curves over the time window, the first one on top. Writes the largest value into the corner.
void drawGraph(report::Canvas& canvas, const Graph& g, const std::deque<FrameSample>& samples,
               const std::vector<Curve>& curves, fmt::format_string<double> format, double least_top) {
    double top = least_top;
    for (const FrameSample& sample : samples)
        for (const Curve& curve : curves)
            top = std::max(top, curve.value(sample));
    canvas.rectangle(g.x, g.y, g.width, g.height, {0.02, 0.027, 0.033});
    for (int i = 1; i < 4; ++i)
        canvas.line({g.x, g.y + g.height * i / 4.0}, {g.x + g.width, g.y + g.height * i / 4.0}, 1.0, kGrid);
    const double now_s = samples.empty() ? 0.0 : samples.back().time_s, size = 0.78 * g.unit;
    canvas.clip(g.x, g.y, g.width, g.height);
    for (std::size_t i = curves.size(); i-- > 0;) {
        std::vector<report::Point> line;
        for (const FrameSample& sample : samples)
            line.push_back({g.x + g.width * (1.0 - (now_s - sample.time_s) / Metrics::kWindow_s),
                            g.y + g.height * (1.0 - 0.75 * curves[i].value(sample) / top)});
        if (line.size() > 1) canvas.polyline(line, std::max(1.2, 0.12 * g.unit), curves[i].colour);
        canvas.text({g.x + (0.4 + 3.4 * double(i)) * g.unit, g.y + 1.0 * g.unit}, curves[i].name,
                    {size, curves[i].colour});
    }
    canvas.unclip();
    canvas.text({g.x + g.width - 0.4 * g.unit, g.y + 1.0 * g.unit}, fmt::format(format, double(top)),
                {size, kMetricsQuiet, report::Align::right});
}

}  // namespace

void Metrics::add(const FrameSample& sample) {
    // A capture may be drawn after later ticks. A replay may start again from the beginning.
    if (!samples_.empty() && sample.time_s < samples_.back().time_s) {
        if (sample.time_s > samples_.front().time_s) return;
        samples_.clear();
    }
    samples_.push_back(sample);
    while (samples_.front().time_s < sample.time_s - kWindow_s)
        samples_.pop_front();
}

void Metrics::draw(report::Canvas& canvas, int width, int height, const StateUpdate& state,
                   bool show_hidden) const {
    canvas.rectangle(0, 0, width, height, kGlass);
    const std::vector<Row> rows = rowsOf(state, samples_, show_hidden);
    const double unit = std::clamp(std::min(width / 30.0, height / 18.0), 9.0, 26.0);
    const double margin = 0.8 * unit, pitch = 1.5 * unit;
    const std::size_t columns = 2, each = (rows.size() + columns - 1) / columns;
    const double column = (width - margin) / double(columns);
    const auto drawRow = [&](const Row& row, double x, double y, double w) {
        canvas.text({x, y}, row.what, {0.85 * unit, kMetricsQuiet});
        canvas.text({x + w, y}, row.value,
                    {unit, row.alarm ? kAlarm : kMetricsWords, report::Align::right, row.alarm});
    };
    const auto lineAt = [&](std::size_t i) { return margin + unit + pitch * double(i); };
    for (std::size_t i = 0; i < rows.size(); ++i)
        drawRow(rows[i], margin + column * double(i / each), lineAt(i % each), column - margin);
    const std::vector<Row> truth = show_hidden ? truthRows(state.seen.truth) : std::vector<Row>{};
    for (std::size_t i = 0; i < truth.size(); ++i)
        drawRow(truth[i], margin, lineAt(each + i), width - 2.0 * margin);
    const double top = 1.6 * margin + pitch * double(each + truth.size()), room = height - top - margin;
    if (room < 3.0 * unit) return;
    const std::vector<Curve> frames{{"frame", kFrame, [](const FrameSample& s) { return s.frame_ms; }}};
    if (!show_hidden)
        return drawGraph(canvas, {margin, top, width - 2.0 * margin, room, unit}, samples_, frames,
                         "{:.0f} ms", 10.0);
    const bool beside = room < 0.35 * width;
    const double w = beside ? (width - 3.0 * margin) / 2.0 : width - 2.0 * margin;
    const double h = beside ? room : (room - margin) / 2.0;
    std::vector<Curve> forces{
        {"force", kForce, [](const FrameSample& s) { return std::max(0.0, s.force_n); }}};
    if (state.seen.truth.known)
        forces.push_back({state.seen.truth.felt_is_full ? "partial" : "full", kOther,
                          [](const FrameSample& s) { return std::max(0.0, s.other_n); }});
    drawGraph(canvas, {margin, top, w, h, unit}, samples_, forces, "{:.1f} N", 1.0);
    drawGraph(canvas, {beside ? 2.0 * margin + w : margin, beside ? top : top + h + margin, w, h, unit},
              samples_, frames, "{:.0f} ms", 10.0);
}

}  // namespace stylet::trainer
