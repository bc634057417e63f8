#include "render/ultrasound/scan.h"

#include <algorithm>
#include <cmath>

namespace stylet::render {
namespace {

constexpr double kPulseReach = 2.5;  // sigma
// Smallest sigma. With a shorter pulse, a mirror's echo would depend on its position between bins.
constexpr double kMinPulse_bins = 0.75;

double cubicSpline(double x) {
    x = std::fabs(x);
    if (x >= 2.0) return 0.0;
    if (x >= 1.0) return (2.0 - x) * (2.0 - x) * (2.0 - x) / 6.0;
    return 2.0 / 3.0 - x * x + 0.5 * x * x * x;
}

// Variance of noise averaged with Gaussian weights of `sigma`. `correlation(lag)`: correlation of noise
// that many taps apart.
template <typename Correlation>
double computeVariance(double sigma, double reach_sigma, const Correlation& correlation) {
    const int taps = int(std::ceil(reach_sigma * sigma));
    double sum = 0.0, variance = 0.0;
    for (int d = -taps; d <= taps; ++d)
        sum += std::exp(-0.5 * d * d / (sigma * sigma));
    for (int lag = 0; lag <= 2 * taps; ++lag) {
        const double alike = correlation(lag);
        if (alike == 0.0) break;
        for (int d = -taps; d + lag <= taps; ++d)
            variance += (lag ? 2.0 : 1.0) * alike *
                        std::exp(-0.5 * (d * d + (d + lag) * (d + lag)) / (sigma * sigma));
    }
    return variance / (sum * sum);
}

// Correlation of the noise of bins, averaged over their positions between two samples (noiseBetween() in
// sample.glsl).
double binCorrelation(int lag, double step_m) {
    const auto rho = [&](int steps) { return scattererCorrelation(std::abs(steps) * step_m); };
    constexpr int kPhases = 8;
    double sum = 0.0;
    for (int i = 0; i < kPhases; ++i) {
        const double f = (i + 0.5) / kPhases, g = 1.0 - f;
        sum += ((f * f + g * g) * rho(lag) + f * g * (rho(lag - 1) + rho(lag + 1))) /
               (f * f + g * g + 2.0 * f * g * rho(1));
    }
    return sum / kPhases;
}

std::vector<ScanPlan::Plane> makePlanes(int count) {
    std::vector<ScanPlan::Plane> planes(std::size_t(count), {0.0, 0.0});
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
        auto& p = planes[std::size_t(i)];
        p.sigmas = (i - 0.5 * (count - 1)) * 5.0 / (count + 1);
        p.weight = std::exp(-0.5 * p.sigmas * p.sigmas);
        sum += p.weight;
    }
    for (auto& p : planes)
        p.weight /= sum;
    return planes;
}

double planesVariance(const std::vector<ScanPlan::Plane>& planes, double sigma_m) {
    double variance = 0.0;
    for (const auto& a : planes)
        for (const auto& b : planes)
            variance += a.weight * b.weight * scattererCorrelation((a.sigmas - b.sigmas) * sigma_m);
    return variance;
}

void makePulse(ScanPlan& plan, double sigma_bins) {
    double sum = 0.0;
    for (std::size_t i = 0; i < plan.pulse.size(); ++i) {
        plan.pulse[i] = double(i) <= std::ceil(kPulseReach * sigma_bins)
                            ? std::exp(-0.5 * double(i * i) / (sigma_bins * sigma_bins))
                            : 0.0;
        sum += i ? 2.0 * plan.pulse[i] : plan.pulse[i];
    }
    for (double& w : plan.pulse)
        w /= sum;
    // A jump is spread over three bins (line.comp); the outer two get half.
    plan.mirror_scale = 1.0 / (plan.pulse[0] + plan.pulse[1]);
}

bool finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool sound(const Pose& pose) {
    const Quat& q = pose.rotation;
    const double size = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    return finite(pose.position_m) && glm::length(pose.position_m) < 100.0 && std::fabs(size - 1.0) < 1e-3;
}

bool within(double value, double low, double high) {
    return value >= low && value <= high;  // false for NaN
}

}  // namespace

int ScanPlan::taps() const {
    int last = 1;
    for (std::size_t i = 1; i < pulse.size(); ++i)
        if (pulse[i] > 0.0) last = int(i);
    return last;
}

// The noise is linear between the nodes of its lattice, so its correlation is a cubic B-spline.
double scattererCorrelation(double apart_m) {
    return 1.5 * cubicSpline(apart_m / kScatterers_m);
}

ScanPlan makeScanPlan(const Transducer& probe, const UltrasoundSettings& settings) {
    ScanPlan plan;
    plan.depth_m = settings.depth_m > 0.0 ? settings.depth_m : probe.depth_m;
    plan.focus_m = settings.focus_m > 0.0 ? settings.focus_m : probe.focus_m;
    plan.frequency_hz = std::clamp(settings.frequency_hz > 0.0 ? settings.frequency_hz : probe.frequency_hz,
                                   probe.lowest_frequency_hz, probe.highest_frequency_hz);
    plan.step_m = kMarchedShare * plan.depth_m / settings.samples;
    plan.bin_m = plan.depth_m / settings.samples;
    plan.amplified_np_per_m =
        2.0 * kNeperPerDb * 100.0 * settings.compensation_db_per_cm_mhz * plan.frequency_hz * 1e-6;
    plan.planes = makePlanes(settings.planes);
    const double pulse_bins =
        std::max(pulseLength_m(probe, plan.frequency_hz) / kWidthsPerSigma / plan.bin_m, kMinPulse_bins);
    makePulse(plan, pulse_bins);
    const double along =
        computeVariance(pulse_bins, kPulseReach, [&](int lag) { return binCorrelation(lag, plan.step_m); });
    plan.depths.resize(std::size_t(settings.samples));
    for (std::size_t i = 0; i < plan.depths.size(); ++i) {
        ScanPlan::Depth& d = plan.depths[i];
        const double depth = double(i) * plan.bin_m, pitch = linePitch_m(probe, settings.lines, depth);
        const double width = beamWidth_m(probe, plan.frequency_hz, plan.focus_m, depth);
        d.thickness_sigma_m = beamThickness_m(probe, depth) / kWidthsPerSigma;
        d.width_sigma_lines = std::max(width / kWidthsPerSigma / pitch, 0.3);
        const double aside = computeVariance(d.width_sigma_lines, settings.reach_sigma,
                                             [&](int lag) { return scattererCorrelation(lag * pitch); });
        d.speckle = 1.0 / std::sqrt(along * aside * planesVariance(plan.planes, d.thickness_sigma_m));
    }
    setGains(plan, settings);
    return plan;
}

void setGains(ScanPlan& plan, const UltrasoundSettings& settings) {
    for (std::size_t i = 0; i < plan.depths.size(); ++i) {
        const double at = double(i) / double(plan.depths.size()) * (kTgcSliders - 1);
        const std::size_t slider = std::min(std::size_t(at), std::size_t(kTgcSliders - 2));
        const double share = at - double(slider);
        const double tgc = settings.tgc_db[slider] * (1.0 - share) + settings.tgc_db[slider + 1] * share;
        plan.depths[i].gain = std::exp(kNeperPerDb * (settings.gain_db + tgc - kWhite_db));
    }
}

std::string_view noScanReason(const UltrasoundInput& input, const UltrasoundSettings& s,
                              const Transducer& probe) {
    if (!input.patient_from_probe) return "there is no probe";
    if (!sound(*input.patient_from_probe)) return "the probe's pose is not a pose";
    if (input.patient_from_needle && !sound(*input.patient_from_needle))
        return "the needle's pose is not a pose";
    if (input.guide_m && !(finite((*input.guide_m)[0]) && finite((*input.guide_m)[1])))
        return "the guide is not a line";
    const double depth = s.depth_m != 0.0 ? s.depth_m : probe.depth_m;
    if (!within(depth, 0.005, 0.5)) return "the depth is not within 5 to 500 mm";
    if (!within(s.frequency_hz, 0.0, 1e9) || !within(s.focus_m, 0.0, 1.0))
        return "frequency or focus is out of range";
    if (!within(s.dynamic_range_db, 1.0, 200.0)) return "the dynamic range is out of range";
    bool gains = within(s.gain_db, -200.0, 200.0) && within(s.compensation_db_per_cm_mhz, 0.0, 5.0);
    for (const double slider : s.tgc_db)
        gains = gains && within(slider, -200.0, 200.0);
    if (!gains) return "a gain is out of range";
    if (s.lines < 2 || s.lines > kMaxLines || s.samples < 16 || s.samples > kMaxSamples || s.planes < 1 ||
        s.planes > kMaxScannedPlanes || s.place_samples < 1 || !within(s.reach_sigma, 0.1, 10.0))
        return "lines, samples or planes are out of range";
    if (!within(s.gel_m, 0.0, 0.05) || !within(s.noise_db, -1000.0, 0.0))
        return "gel or noise is out of range";
    if (!std::isfinite(input.time_s)) return "the time is no time";
    if (s.width < 16 || s.height < 16 || s.width > 4096 || s.height > 4096)
        return "the picture's size is out of range";
    return {};
}

}  // namespace stylet::render
