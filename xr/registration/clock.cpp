#include "xr/registration/clock.h"

#include <algorithm>
#include <limits>

namespace stylet::xr::registration {
namespace {

constexpr double kGap_s = 0.1;
constexpr double kGrid_s = 0.004;   // step of the search
constexpr double kWindow_s = 0.12;  // time over which the speed is measured, the same for both streams
constexpr double kMinOverlap_s = 2.0, kMinSpeed_m_per_s = 0.01, kMinCorrelation = 0.4;
constexpr double kJumpFactor = 1.3;
constexpr double kVelocity_s = 0.01;      // half the width of the velocity's central difference
constexpr double kPairInterval_s = 0.02;  // time between two pairs
constexpr double kConverged_s = 5e-5;
constexpr int kClockRounds = 6;

bool finite(PoseStream stream) {
    return std::all_of(stream.begin(), stream.end(),
                       [](const TimedPose& s) { return std::isfinite(s.t_s) && isFinite(s.pose); });
}

// Speeds on the grid starting at `begin_s`; -1 where unknown.
std::vector<double> speeds(PoseStream stream, double begin_s, std::size_t count) {
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
    if (n * kGrid_s < 0.5 * kMinOverlap_s) return -1.0;
    const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
    return va > 0.0 && vb > 0.0 ? (sab - sa * sb / n) / std::sqrt(va * vb) : -1.0;
}

// Marks speeds as unknown where the tracker jumped. A jump is faster than any motion of the device and would
// disturb the correlation.
void discardJumps(std::vector<double>& tracked, const std::vector<double>& device) {
    const double fastest = *std::max_element(device.begin(), device.end());
    for (double& v : tracked)
        if (v > kJumpFactor * fastest) v = -1.0;
}

double rootMeanSquare(const std::vector<double>& speeds_m_per_s) {
    double sum = 0.0, n = 0.0;
    for (const double v : speeds_m_per_s)
        if (v >= 0.0) sum += v * v, n += 1.0;
    return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

}  // namespace

std::optional<Pose> poseAt(PoseStream stream, double t_s) {
    const auto after = std::lower_bound(stream.begin(), stream.end(), t_s,
                                        [](const TimedPose& s, double t) { return s.t_s < t; });
    if (after == stream.end()) return std::nullopt;
    if (after->t_s == t_s) return after->pose;
    if (after == stream.begin()) return std::nullopt;
    const TimedPose &a = *(after - 1), &b = *after;
    if (b.t_s - a.t_s > kGap_s) return std::nullopt;
    const double share = (t_s - a.t_s) / (b.t_s - a.t_s);
    return Pose{glm::slerp(a.pose.rotation, b.pose.rotation, share),
                glm::mix(a.pose.position_m, b.pose.position_m, share)};
}

Result<TimeOffset> estimateClockOffset(PoseStream device, PoseStream tracked, double max_offset_s) {
    if (!finite(device) || !finite(tracked)) return failure<TimeOffset>("A pose is not a number.");
    if (device.empty() || tracked.empty()) return failure<TimeOffset>("There is no motion to compare.");
    const double begin_s = std::max(device.front().t_s, tracked.front().t_s),
                 end_s = std::min(device.back().t_s, tracked.back().t_s);
    constexpr double kMaxDuration_s = 600.0;
    if (!(end_s - begin_s >= kMinOverlap_s))
        return failure<TimeOffset>("Less than two seconds of motion were recorded.");
    const auto count = std::size_t(std::min(end_s - begin_s, kMaxDuration_s) / kGrid_s);
    const std::vector<double> a = speeds(device, begin_s, count);
    std::vector<double> b = speeds(tracked, begin_s, count);
    discardJumps(b, a);
    if (rootMeanSquare(a) < kMinSpeed_m_per_s || rootMeanSquare(b) < kMinSpeed_m_per_s)
        return failure<TimeOffset>("There is too little motion to compare the clocks: move more.");
    const int max_lag = int(max_offset_s / kGrid_s);
    int best = 0;
    double peak = -1.0;
    for (int lag = -max_lag; lag <= max_lag; ++lag) {
        const double c = correlation(a, b, lag);
        if (c > peak) peak = c, best = lag;
    }
    if (peak < kMinCorrelation)
        return failure<TimeOffset>("The controller does not move as the device does: hold both together.");
    if (std::abs(best) == max_lag)
        return failure<TimeOffset>("The controller and the device are too far apart in time.");
    const double left = correlation(a, b, best - 1), right = correlation(a, b, best + 1);
    const double bend = left - 2.0 * peak + right;
    const double part = bend < 0.0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
    return {TimeOffset{(best + part) * kGrid_s, peak}, ""};
}

std::vector<Pair> pairSamples(PoseStream device, PoseStream tracked, double delay_s, double step_s) {
    std::vector<Pair> pairs;
    double next_s = -std::numeric_limits<double>::infinity();
    for (const TimedPose& seen : tracked) {
        if (seen.t_s < next_s) continue;
        const double t_s = seen.t_s - delay_s;
        const auto now = poseAt(device, t_s), before = poseAt(device, t_s - kVelocity_s),
                   after = poseAt(device, t_s + kVelocity_s);
        if (!now || !before || !after) continue;
        pairs.push_back({*now, seen.pose, (after->position_m - before->position_m) / (2.0 * kVelocity_s)});
        next_s = seen.t_s + step_s;
    }
    return pairs;
}

Result<Fit> fitMotion(PoseStream device, PoseStream tracked, FitSettings settings) {
    std::vector<TimedPose> tips(tracked.begin(), tracked.end());
    for (TimedPose& seen : tips)
        seen.pose.position_m = seen.pose * settings.tip_guess_m;
    const Result<TimeOffset> offset = estimateClockOffset(device, tips);
    if (!offset) return failure<Fit>(offset.why_not);
    settings.latency = true;
    settings.in_order = true;
    double delay_s = offset->delay_s;
    Result<Fit> fit;
    for (int round = 0; round < kClockRounds; ++round) {
        const Fit earlier = fit ? *fit : Fit{};
        fit = fitPairs(pairSamples(device, tracked, delay_s, kPairInterval_s), settings,
                       round > 0 ? &earlier : nullptr);
        if (!fit) return fit;
        delay_s += fit->latency_s;
        if (std::fabs(fit->latency_s) < kConverged_s) break;
    }
    fit.value->latency_s = delay_s;
    return fit;
}

Result<MeanPose> meanPose(PoseStream stream) {
    if (stream.empty()) return failure<MeanPose>("Nothing was seen.");
    if (!finite(stream)) return failure<MeanPose>("A pose is not a number.");
    Vec3 sum(0.0);
    Quat turn(0.0, 0.0, 0.0, 0.0);
    for (const TimedPose& s : stream) {
        sum += s.pose.position_m;
        const Quat& q = s.pose.rotation;
        turn += glm::dot(q, stream.front().pose.rotation) < 0.0 ? -q : q;
    }
    MeanPose mean{{glm::normalize(turn), sum / double(stream.size())}, 0.0};
    for (const TimedPose& s : stream)
        mean.spread_m = std::max(mean.spread_m, glm::distance(s.pose.position_m, mean.pose.position_m));
    return {mean, ""};
}

}  // namespace stylet::xr::registration
