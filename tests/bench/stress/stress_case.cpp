#include "tests/bench/stress/stress_case.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "haptics/devices/profiles.h"
#include "tests/haptics/column.h"
#include "tests/support/motion.h"

namespace stylet::stress {

using namespace haptics;
using namespace test;

namespace {

using Random = std::mt19937_64;

double uniform(Random& random) {
    return double(random() >> 11) * 0x1p-53;
}

// One column of a Latin hypercube. [0, 1) is split into `count` equal parts with one value in each.
class Column {
  public:
    Column(int count, Random& random) : random_(random), order_(std::size_t(count)) {
        std::iota(order_.begin(), order_.end(), 0);
        for (std::size_t i = order_.size(); i > 1; --i)
            std::swap(order_[i - 1], order_[random() % i]);
    }
    double share(std::size_t i) { return (order_[i] + uniform(random_)) / double(order_.size()); }
    double in(std::size_t i, double low, double high) { return low + (high - low) * share(i); }
    double logIn(std::size_t i, double low, double high) { return low * std::pow(high / low, share(i)); }
    std::size_t of(std::size_t i, std::size_t levels) {
        return std::min(levels - 1, std::size_t(share(i) * double(levels)));
    }

  private:
    Random& random_;
    std::vector<int> order_;
};

struct Sequence {
    const char* name;
    test::Layers layers;
};

const std::vector<Sequence>& sequences() {
    using enum Tissue;
    static const std::vector<Sequence> list = [] {
        std::vector<Sequence> made{
            {"approach",
             {{skin, 0.002},
              {soft, 0.016},
              {fascia, 0.001},
              {liver, 0.012},
              {duct, 0.004},
              {liver, 0.010},
              {vessel, 0.003},
              {liver, 0.080}}},
            {"thin borders",
             {{skin, 0.0005},
              {soft, 0.008},
              {fascia, 0.0005},
              {liver, 0.0005},
              {duct, 0.0005},
              {liver, 0.004},
              {vessel, 0.0005},
              {duct, 0.0005},
              {liver, 0.090}}},
            {"fascia twice",
             {{skin, 0.002}, {soft, 0.010}, {fascia, 0.003}, {soft, 0.004}, {fascia, 0.003}, {liver, 0.090}}},
            {"rib", {{skin, 0.002}, {soft, 0.012}, {bone, 0.010}, {soft, 0.090}}},
            {"soft", {{skin, 0.002}, {soft, 0.110}}},
            {"liver", {{liver, 0.110}}},
            {"air inside", {{skin, 0.002}, {soft, 0.010}, {air, 0.006}, {soft, 0.004}, {liver, 0.090}}},
            {"hundred layers", {{skin, 0.001}}}};
        for (int i = 0; i < 100; ++i)
            made.back().layers.push_back({i % 3 == 0 ? liver : i % 3 == 1 ? duct : vessel, 0.0005});
        made.back().layers.push_back({soft, 0.060});
        return made;
    }();
    return list;
}

// Minimum-jerk step from 0 to 1 (Flash and Hogan 1985).
double step01(double t) {
    const double s = std::clamp(t, 0.0, 1.0);
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

// The hand's target depth at t_s, in metres along the axis from the skin. Negative before the skin.
double wantedDepth(const StressCase& c, double t_s) {
    constexpr double kBefore_m = 0.004;
    const double travel_m = c.depth_m + kBefore_m;
    // The peak speed of a minimum-jerk step is 1.875 times its average speed.
    const double duration_s = std::min(1.875 * travel_m / c.speed_m_s, kRest_s - c.begin_s);
    const double share = (std::min(t_s, kRest_s) - c.begin_s) / duration_s;
    const double t = std::clamp(share, 0.0, 1.0);
    double depth_m = travel_m * step01(share);
    switch (c.pattern) {
        case Pattern::push:
            break;
        case Pattern::pullBack:  // retreats by a third of the travel on the way in
            depth_m -= travel_m / 3.0 * step01(4.0 * t - 1.5) * step01(4.0 - 4.0 * t);
            break;
        case Pattern::inSteps:
            depth_m = travel_m / 4.0 *
                      (std::floor(4.0 * t) + (t < 1.0 ? step01(4.0 * t - std::floor(4.0 * t)) : 0.0));
            break;
        case Pattern::trembling:  // 9 Hz tremor of 1 mm, fading in and out
            depth_m += 0.001 * step01(5.0 * t) * step01(5.0 - 5.0 * t) *
                       std::sin(2.0 * 3.14159265358979 * 9.0 * t_s);
            break;
    }
    return depth_m - kBefore_m;
}

Trace wantedTrace(const StressCase& c, const Vec3& axis) {
    // The needle's +z axis points toward the hub, opposite to `axis`. A rotation about y aligns them.
    const double angle = std::atan2(-axis.x, -axis.z);
    const Quat turn(std::cos(0.5 * angle), 0.0, std::sin(0.5 * angle), 0.0);
    Trace trace;
    constexpr std::int64_t kSpacing_ns = 2'000'000;
    for (std::int64_t t_ns = 0; double(t_ns) * 1e-9 <= kRest_s; t_ns += kSpacing_ns)
        trace.samples.push_back({t_ns, {turn, axis * wantedDepth(c, double(t_ns) * 1e-9)}, 0});
    return trace;
}

}  // namespace

std::vector<StressCase> latinHypercube(int count, std::uint64_t seed) {
    Random random(seed);
    Column device(count, random), tissues(count, random), hand(count, random), rate(count, random),
        delay(count, random), jitter(count, random), resolution(count, random), mass(count, random),
        damping(count, random), friction(count, random), breath(count, random), period(count, random),
        pattern(count, random), begin(count, random), depth(count, random), speed(count, random),
        tilt(count, random), weight(count, random);
    std::vector<StressCase> cases(std::size_t(std::max(0, count)));
    for (std::size_t i = 0; i < cases.size(); ++i) {
        StressCase& c = cases[i];
        const auto profiles = deviceProfiles();
        c.device = &profiles[device.of(i, profiles.size())];
        c.tissues = tissues.of(i, Tissues::count());
        c.hand = HandKind(hand.of(i, 3));
        c.rate_hz = kRates_hz[rate.of(i, kRates_hz.size())];
        c.delay_s = delay.in(i, 0.0, 0.002);
        c.jitter_s = jitter.in(i, 0.0, 0.4) / c.rate_hz;
        c.resolution_m = valueOrDefault(c.device->resolution_m, 30e-6) * resolution.logIn(i, 0.25, 2.0);
        c.mass_kg = valueOrDefault(c.device->mass_kg, mass.logIn(i, 0.045, 0.2));
        c.damping_n_s_per_m = damping.logIn(i, 0.005, 0.1);
        c.friction_n = valueOrDefault(c.device->friction_n, 0.05) * std::max(0.0, friction.in(i, -0.5, 1.0));
        c.breath_amplitude = std::max(0.0, breath.in(i, -0.4, 1.3));
        c.breath_period_s = period.in(i, 3.0, 6.5);
        c.pattern = Pattern(pattern.of(i, 4));
        c.begin_s = begin.in(i, 0.3, 1.6);
        c.depth_m = depth.in(i, 0.002, 0.050);
        c.speed_m_s = speed.logIn(i, 0.005, 0.080);
        c.tilt_rad = tilt.in(i, -0.7, 0.7);
        c.weight_share = weight.in(i, 0.0, 0.8);
        c.seed = seed + i;
    }
    return cases;
}

Tissues::Tissues() {
    for (const Sequence& s : sequences()) {
        patient::Package& package = packages_.emplace_back(test::makeColumn(s.layers, 0.0005));
        // Make the column wide enough for every tilt and breath.
        for (Grid* grid : {&package.ct.grid, &package.labels.grid})
            grid->spacing_m.y = grid->spacing_m.z = 0.4;
        package.motion = test::makeShift(kTravel_m);
        patients_.emplace_back(package);
    }
    // Use the needle's tangent alone. The gain is then higher than in a session, where the pads' tangents
    // lower it by a sixth.
    output_.model_tangent_n_per_m = maxTangent(packages_.front().tissues, NeedleSettings{});
}

std::size_t Tissues::count() {
    return sequences().size();
}

const char* Tissues::name(std::size_t i) {
    return sequences()[i].name;
}

CaseInput prepareCase(const StressCase& c, const Tissues& tissues, bool controller) {
    CaseInput s;
    s.axis = {std::cos(c.tilt_rad), 0.0, std::sin(c.tilt_rad)};
    s.wanted = wantedTrace(c, s.axis);
    s.profile = *c.device;
    // These values come from the case. The workspace radius is unknown, because the soft walls have their
    // own tests.
    s.profile.mass_kg = c.mass_kg;
    s.profile.damping_n_s_per_m = c.damping_n_s_per_m;
    s.profile.friction_n = c.friction_n;
    s.profile.resolution_m = c.resolution_m;
    s.profile.workspace_radius_m = kUnknown;
    s.profile.delay_s = c.delay_s;

    s.settings.dt_s = 1.0 / c.rate_hz;
    s.settings.profile = s.profile;
    s.settings.output = tissues.output();
    s.settings.breath = patient::BreathPlan{.rhythm = {c.breath_period_s, c.breath_amplitude}};
    s.settings.output.controller_share = controller ? 1.0 : 0.0;

    s.body = makeSimulatedBody(s.profile, c.hand == HandKind::firm ? kFirmHand : kLightHand);
    s.body.delay_s = c.delay_s;
    s.body.jitter_s = c.jitter_s;
    s.body.seed = c.seed;
    if (c.hand == HandKind::none) {
        s.body.release_s = kRest_s;
        const double friction_n =
            tissues.at(c.tissues).package().tissues[std::size_t(Tissue::liver)].friction_n;
        s.body.weight_n = s.axis * (c.weight_share * friction_n * outputGain(s.profile, s.settings.output));
    }
    return s;
}

}  // namespace stylet::stress
