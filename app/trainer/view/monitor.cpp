#include "app/trainer/view/monitor.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace stylet::trainer {

namespace {

constexpr double kWindow_s = 16.0, kEvery_s = 0.1;
constexpr double kDeepest_v = 1.5;    // breath signal at the top of the trace
constexpr double kCrossing_v = 0.35;  // every inhalation crosses it once
constexpr report::Colour kMonitorGlass{0.015, 0.03, 0.04}, kMonitorGrid{0.10, 0.16, 0.19},
    kTrace{0.98, 0.84, 0.25}, kHeld{0.35, 0.85, 1.0}, kPain{1.0, 0.42, 0.36}, kMonitorQuiet{0.55, 0.62, 0.66};

}  // namespace

BreathMonitor::BreathMonitor() : canvas_(kWidth, kHeight, kMonitorGlass) {}

void BreathMonitor::update(double t_s, const patient::Surrogate& breath, bool held, double pain) {
    if (!samples_.empty() && t_s < samples_.front().t_s) samples_.clear();
    if (!samples_.empty()) {
        const double since_s = t_s - samples_.back().t_s;
        // A capture may be drawn after later ticks.
        if (since_s <= 0.0 || (held == held_ && since_s < kEvery_s)) return;
    }
    held_ = held;
    pain_ = std::lround(pain);
    samples_.push_back({t_s, breath.v});
    const auto shown = std::find_if(samples_.begin(), samples_.end(),
                                    [&](const Sample& s) { return s.t_s >= t_s - kWindow_s; });
    samples_.erase(samples_.begin(), shown);
    draw();
}

// Mean rate between the first and the last inhalation on the screen; 0 if there are too few.
double BreathMonitor::ratePerMinute() const {
    double first_s = 0.0, last_s = 0.0;
    int breaths = 0;
    for (std::size_t i = 1; i < samples_.size(); ++i) {
        if (samples_[i - 1].v >= kCrossing_v || samples_[i].v < kCrossing_v) continue;
        last_s = samples_[i].t_s;
        if (breaths++ == 0) first_s = last_s;
    }
    return breaths < 2 ? 0.0 : 60.0 * (breaths - 1) / (last_s - first_s);
}

void BreathMonitor::draw() {
    const double top = 34.0, bottom = kHeight - 22.0, left = 12.0, right = kWidth - 96.0;
    canvas_.rectangle(0, 0, kWidth, kHeight, kMonitorGlass);
    for (int i = 0; i <= 8; ++i) {
        const double x = left + (right - left) * i / 8.0;
        canvas_.line({x, top}, {x, bottom}, 1.0, kMonitorGrid);
    }
    for (int i = 0; i <= 4; ++i) {
        const double y = top + (bottom - top) * i / 4.0;
        canvas_.line({left, y}, {right, y}, 1.0, kMonitorGrid);
    }
    const double now_s = samples_.back().t_s;
    line_.clear();
    for (const Sample& s : samples_)
        line_.push_back({right - (right - left) * (now_s - s.t_s) / kWindow_s,
                         bottom - (bottom - top) * std::clamp(s.v / kDeepest_v, 0.0, 1.0)});
    const report::Colour colour = held_ ? kHeld : kTrace;
    canvas_.polyline(line_, 2.5, colour);
    canvas_.disc(line_.back(), 4.0, colour);
    canvas_.text({left, 23}, "RESP", {16, kTrace, report::Align::left, true});
    canvas_.text({right, 23}, "16 s", {13, kMonitorQuiet, report::Align::right});
    const double rate = ratePerMinute();
    canvas_.text({kWidth - 48.0, 110},
                 held_        ? "--"
                 : rate > 0.0 ? std::to_string(std::lround(rate))
                              : "--",
                 {46, colour, report::Align::centre, true});
    canvas_.text({kWidth - 48.0, 134}, "/min", {14, kMonitorQuiet, report::Align::centre});
    if (held_) canvas_.text({kWidth - 48.0, 190}, "HOLD", {20, kHeld, report::Align::centre, true});
    if (pain_ > 0) {
        canvas_.text({kWidth - 48.0, 220}, "PAIN", {16, kPain, report::Align::centre, true});
        canvas_.text({kWidth - 48.0, 248}, std::to_string(pain_) + "/10",
                     {26, kPain, report::Align::centre, true});
    }
    canvas_.pixels(rgba_);
    ++revision_;
}

}  // namespace stylet::trainer
