#include "xr/registration/clock.h"

#include <algorithm>
#include <limits>

namespace stylet::xr::registration {
namespace {

constexpr double kGap_s = 0.1;
constexpr double kGrid_s = 0.004;   // step of the search
constexpr double kWindow_s = 0.12;  // window over which the speed is measured, the same for both streams
constexpr double kLeast_s = 2.0, kLeastSpeed_m_per_s = 0.01, kLeastCorrelation = 0.4;
constexpr double kJump = 1.3;
constexpr double kVelocity_s = 0.01;  // half the width of the velocity's central difference
constexpr double kPairs_s = 0.02;     // one pair per
constexpr double kSettled_s = 5e-5;
constexpr int kClockRounds = 6;

bool finite(Stream stream) {
    return std::all_of(stream.begin(), stream.end(),
                       [](const Timed& s) { return std::isfinite(s.t_s) && isFinite(s.pose); });
}

// Speeds on the grid starting at `begin_s`; -1 where unknown.
std::vector<double> speeds(Stream stream, double begin_s, std::size_t count) {
    std::vector<double> result(count, -1.0);
    for (std::size_t i = 0; i < count; ++i) {
        const double t_s = begin_s + kGrid_s * double(i);
        const auto before = poseAt(stream, t_s - 0.5 * kWindow_s),
                   after = poseAt(stream, t_s + 0.5 * kWindow_s);
        if (before && after) result[i] = glm::distance(before->position_m, after->position_m) / kWindow_s;
    }
    return result;
}

// Pearson correlation of a[i] with b[i + lag]; -1 if the overlap is too short.
double correlation(const std::vector<double>& a, const std::vector<double>& b, int lag) {
    double n = 0.0, sa = 0.0, sb = 0.0, saa = 0.0, sbb = 0.0, sab = 0.0;
    for (int i = std::max(0, -lag); i < int(a.size()) && i + lag < int(b.size()); ++i) {
        const double x = a[std::size_t(i)], y = b[std::size_t(i + lag)];
        if (x < 0.0 || y < 0.0) continue;
        n += 1.0, sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
    }
    if (n * kGrid_s < 0.5 * kLeast_s) return -1.0;
    const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
    return va > 0.0 && vb > 0.0 ? (sab - sa * sb / n) / std::sqrt(va * vb) : -1.0;
}

// Marks speeds as unknown where the tracker jumped. A jump is faster than any motion of the device, so it
// tells nothing about the clocks.
void forgetJumps(std::vector<double>& tracked, const std::vector<double>& device) {
    const double fastest = *std::max_element(device.begin(), device.end());
    for (double& v : tracked)
        if (v > kJump * fastest) v = -1.0;
}

double rootMeanSquare(const std::vector<double>& speeds_m_per_s) {
    double sum = 0.0, n = 0.0;
    for (const double v : speeds_m_per_s)
        if (v >= 0.0) sum += v * v, n += 1.0;
    return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

}  // namespace

std::optional<Rigid> poseAt(Stream stream, double t_s) {
    const auto after = std::lower_bound(stream.begin(), stream.end(), t_s,
                                        [](const Timed& s, double t) { return s.t_s < t; });
    if (after == stream.end()) return std::nullopt;
    if (after->t_s == t_s) return after->pose;
    if (after == stream.begin()) return std::nullopt;
    const Timed &a = *(after - 1), &b = *after;
    if (b.t_s - a.t_s > kGap_s) return std::nullopt;
    const double share = (t_s - a.t_s) / (b.t_s - a.t_s);
    return Rigid{glm::slerp(a.pose.rotation, b.pose.rotation, share),
                 glm::mix(a.pose.position_m, b.pose.position_m, share)};
}

Answer<Offset> clockOffset(Stream device, Stream tracked, double most_s) {
    if (!finite(device) || !finite(tracked)) return refused<Offset>("A pose is not a number.");
    if (device.empty() || tracked.empty()) return refused<Offset>("There is no motion to compare.");
    const double begin_s = std::max(device.front().t_s, tracked.front().t_s),
                 end_s = std::min(device.back().t_s, tracked.back().t_s);
    constexpr double kLongest_s = 600.0;
    if (!(end_s - begin_s >= kLeast_s))
        return refused<Offset>("Less than two seconds of motion are there to compare.");
    const auto count = std::size_t(std::min(end_s - begin_s, kLongest_s) / kGrid_s);
    const std::vector<double> a = speeds(device, begin_s, count);
    std::vector<double> b = speeds(tracked, begin_s, count);
    forgetJumps(b, a);
    if (rootMeanSquare(a) < kLeastSpeed_m_per_s || rootMeanSquare(b) < kLeastSpeed_m_per_s)
        return refused<Offset>("There is too little motion to compare the clocks by.");
    const int most = int(most_s / kGrid_s);
    int best = 0;
    double peak = -1.0;
    for (int lag = -most; lag <= most; ++lag) {
        const double c = correlation(a, b, lag);
        if (c > peak) peak = c, best = lag;
    }
    if (peak < kLeastCorrelation)
        return refused<Offset>("The controller does not move as the device does: hold both together.");
    if (std::abs(best) == most)
        return refused<Offset>("The controller and the device are too far apart in time.");
    const double left = correlation(a, b, best - 1), right = correlation(a, b, best + 1);
    const double bend = left - 2.0 * peak + right;
    const double part = bend < 0.0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
    return {Offset{(best + part) * kGrid_s, peak}, ""};
}

std::vector<Pair> pairUp(Stream device, Stream tracked, double late_s, double step_s) {
    std::vector<Pair> pairs;
    double next_s = -std::numeric_limits<double>::infinity();
    for (const Timed& seen : tracked) {
        if (seen.t_s < next_s) continue;
        const double t_s = seen.t_s - late_s;
        const auto now = poseAt(device, t_s), before = poseAt(device, t_s - kVelocity_s),
                   after = poseAt(device, t_s + kVelocity_s);
        if (!now || !before || !after) continue;
        pairs.push_back({*now, seen.pose, (after->position_m - before->position_m) / (2.0 * kVelocity_s)});
        next_s = seen.t_s + step_s;
    }
    return pairs;
}

Answer<Fit> fitMotion(Stream device, Stream tracked, FitSettings settings) {
    std::vector<Timed> tips(tracked.begin(), tracked.end());
    for (Timed& seen : tips)
        seen.pose.position_m = seen.pose * settings.tip_guess_m;
    const Answer<Offset> offset = clockOffset(device, tips);
    if (!offset) return refused<Fit>(offset.why_not);
    settings.latency = true;
    settings.in_order = true;
    double late_s = offset->late_s;
    Answer<Fit> fit;
    for (int round = 0; round < kClockRounds; ++round) {
        const Fit earlier = fit ? *fit : Fit{};
        fit = fitPairs(pairUp(device, tracked, late_s, kPairs_s), settings, round > 0 ? &earlier : nullptr);
        if (!fit) return fit;
        late_s += fit->latency_s;
        if (std::fabs(fit->latency_s) < kSettled_s) break;
    }
    fit.value->latency_s = late_s;
    return fit;
}

Answer<Held> meanPose(Stream stream) {
    if (stream.empty()) return refused<Held>("Nothing was seen.");
    if (!finite(stream)) return refused<Held>("A pose is not a number.");
    Vec3 sum(0.0);
    Quat turn(0.0, 0.0, 0.0, 0.0);
    for (const Timed& s : stream) {
        sum += s.pose.position_m;
        const Quat& q = s.pose.rotation;
        turn += glm::dot(q, stream.front().pose.rotation) < 0.0 ? -q : q;
    }
    Held held{{glm::normalize(turn), sum / double(stream.size())}, 0.0};
    for (const Timed& s : stream)
        held.spread_m = std::max(held.spread_m, glm::distance(s.pose.position_m, held.pose.position_m));
    return {held, ""};
}

}  // namespace stylet::xr::registration
