// Based on Lujan et al. 1999. Hashed: double precision, no libm transcendentals.
#include "patient/motion/signal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/smoothstep.h"
#include "base/transcendental.h"

namespace stylet::patient {
namespace {

constexpr double kSqrt3 = 1.7320508075688772;
constexpr double kMinBreath_s = 0.5;  // minimum duration of a breath with jitter
constexpr double kSighDepth = 1.8, kSighLength = 1.4;
// A cough is a gasp followed by bursts. Each burst lowers v by an equal share of the level after the gasp.
constexpr std::uint32_t kBursts = 3;
constexpr double kGasp_s = 1.2, kBurst_s = 0.4, kGaspDepth = 0.9, kAfterGasp = 0.45, kBurstRise = 0.2;
constexpr double kEase_s = 1.5;           // fade-out of the creep after a hold
constexpr double kMaxEndExhale_v = 0.35;  // a minimum of a recording counts as end-exhale if v is below this

enum class Draw : std::uint64_t { kind, period, depth, missed, level, limit, cough, coughTime };

// A random number in [0, 1) for each breath and purpose, independent of earlier draws (a hash of seed,
// breath and purpose).
double draw(const BreathPlan& plan, std::uint64_t breath, Draw purpose) noexcept {
    StateHash hash;
    hash.add(plan.seed);
    hash.add(breath);
    hash.add(std::uint64_t(purpose));
    return double(hash.value() >> 11) * 0x1.0p-53;
}

// Uniform, with mean 1 and the given standard deviation.
double jittered(double jitter, double uniform) noexcept {
    return 1.0 + kSqrt3 * jitter * (2.0 * uniform - 1.0);
}

std::uint64_t toTicks(double seconds, double dt_s) noexcept {
    const double ticks = std::floor(seconds / dt_s + 0.5);
    return ticks >= 2.0 && ticks < 1e15 ? std::uint64_t(ticks) : 2;
}

bool recorded(const BreathPlan& plan) noexcept {
    return !plan.recording_v.empty();
}

OneBreath makeCough(const BreathPlan& plan, std::uint32_t bursts_left, double start_v, double dt_s) noexcept {
    const double a = plan.rhythm.amplitude;
    const auto after = [&](std::uint32_t left) { return kAfterGasp * a * double(left) / kBursts; };
    if (bursts_left == kBursts)
        return {toTicks(kGasp_s, dt_s), start_v, std::max(start_v, kGaspDepth * a), after(kBursts)};
    return {toTicks(kBurst_s, dt_s), start_v, start_v + kBurstRise * a, after(bursts_left)};
}

OneBreath makeSigh(const BreathPlan& plan, double start_v, double dt_s) noexcept {
    return {toTicks(kSighLength * plan.rhythm.period_s, dt_s), start_v,
            std::max(start_v, kSighDepth * plan.rhythm.amplitude), 0.0};
}

OneBreath regularBreath(const BreathPlan& plan, std::uint64_t breath, double start_v, double dt_s) noexcept {
    double period_s = plan.rhythm.period_s, peak_v = plan.rhythm.amplitude;
    if (plan.period_jitter > 0.0)
        period_s =
            std::max(kMinBreath_s, period_s * jittered(plan.period_jitter, draw(plan, breath, Draw::period)));
    if (plan.depth_jitter > 0.0)
        peak_v = std::max(0.0, peak_v * jittered(plan.depth_jitter, draw(plan, breath, Draw::depth)));
    return {toTicks(period_s, dt_s), start_v, std::max(start_v, peak_v), 0.0};
}

void beginBreath(BreathingState& s, const BreathPlan& plan, double dt_s) noexcept {
    const double start_v = s.now.end_v;
    s.phase_ticks = 0;
    ++s.breath;
    if (s.bursts_left > 0) {
        --s.bursts_left;
        s.now = makeCough(plan, s.bursts_left, start_v, dt_s);
        return;
    }
    const double kind = draw(plan, s.breath, Draw::kind);
    if (s.ends_in_cough || kind < plan.coughs) {
        s.ends_in_cough = false;
        s.bursts_left = kBursts;
        s.now = makeCough(plan, kBursts, start_v, dt_s);
    } else if (kind < plan.coughs + plan.sighs) {
        s.now = makeSigh(plan, start_v, dt_s);
    } else {
        s.now = regularBreath(plan, s.breath, start_v, dt_s);
    }
}

std::uint64_t loopTicks(const BreathPlan& plan, double dt_s) noexcept {
    return toTicks(double(plan.recording_v.size()) * plan.recording_dt_s, dt_s);
}

// Catmull-Rom interpolation of the samples of the loop.
Surrogate recordingAt(const BreathPlan& plan, std::uint64_t ticks, double dt_s) noexcept {
    const std::size_t n = plan.recording_v.size();
    const double at = double(ticks) * dt_s / plan.recording_dt_s;
    const double whole = std::floor(at), f = at - whole;
    const auto i = std::size_t(whole) % n;
    const auto sample = [&](std::size_t k) { return plan.rhythm.amplitude * plan.recording_v[k % n]; };
    const double p0 = sample(i + n - 1), p1 = sample(i), p2 = sample(i + 1), p3 = sample(i + 2);
    const double b = 0.5 * (p2 - p0), c = p0 - 2.5 * p1 + 2.0 * p2 - 0.5 * p3,
                 d = 0.5 * (p3 - p0) + 1.5 * (p1 - p2);
    return {p1 + f * (b + f * (c + f * d)), (b + f * (2.0 * c + f * 3.0 * d)) / plan.recording_dt_s};
}

Surrogate breathAt(const OneBreath& b, std::uint64_t phase_ticks, double dt_s) noexcept {
    if (b.ticks == 0) return {};
    const double angle = std::numbers::pi * double(phase_ticks) / double(b.ticks);
    const double s = detSin(angle), c = detCos(angle);
    const double low_v = 2 * phase_ticks < b.ticks ? b.start_v : b.end_v, rise_v = b.peak_v - low_v;
    return {low_v + rise_v * (s * s * s * s),
            4.0 * std::numbers::pi / (double(b.ticks) * dt_s) * rise_v * (s * s * s * c)};
}

// Advances by one tick while the breath is not held.
void advance(BreathingState& s, const BreathPlan& plan, double dt_s) noexcept {
    if (recorded(plan)) {
        const double before = recordingAt(plan, s.phase_ticks, dt_s).rate_per_s;
        if (++s.phase_ticks >= loopTicks(plan, dt_s)) s.phase_ticks = 0;
        const Surrogate now = recordingAt(plan, s.phase_ticks, dt_s);
        s.at_end_exhale =
            before < 0.0 && now.rate_per_s >= 0.0 && now.v < kMaxEndExhale_v * plan.rhythm.amplitude;
        if (s.at_end_exhale) ++s.breath;
        return;
    }
    if (s.now.ticks == 0) beginBreath(s, plan, dt_s);
    ++s.phase_ticks;
    // A patient who is about to hold stops above end-exhale.
    if (s.hold_wanted && !s.hold_aborted && plan.hold.level_v > 0.0 && s.phase_ticks == s.now.ticks / 2 &&
        s.bursts_left == 0)
        s.now.end_v = std::min(s.now.peak_v, plan.hold.level_v * draw(plan, s.breath, Draw::level));
    s.at_end_exhale = s.phase_ticks >= s.now.ticks;
    if (!s.at_end_exhale) return;
    const bool coughing = s.bursts_left > 0;
    beginBreath(s, plan, dt_s);
    s.at_end_exhale = !coughing;
}

bool startsHold(const BreathingState& s, const BreathPlan& plan) noexcept {
    return s.at_end_exhale && s.hold_wanted && !s.hold_aborted &&
           !(plan.hold.missed > 0.0 && draw(plan, s.breath, Draw::missed) < plan.hold.missed);
}

double creepAt(const BreathingState& s, const BreathPlan& plan, double dt_s) noexcept {
    if (s.held) {
        if (plan.hold.creep_v == 0.0) return 0.0;
        const double begun = s.residual_creep_v / plan.hold.creep_v;
        return plan.hold.creep_v * std::min(1.0, begun + double(s.held_ticks) * dt_s / plan.hold.creep_s);
    }
    if (s.residual_creep_v == 0.0) return 0.0;
    const double t = std::min(1.0, double(s.residual_creep_ticks) * dt_s / kEase_s);
    return s.residual_creep_v * (1.0 - smoothStep(t));
}

void beginHold(BreathingState& s, const BreathPlan& plan, double dt_s) noexcept {
    s.residual_creep_v = creepAt(s, plan, dt_s);  // continue from the creep that remains of the last hold
    s.residual_creep_ticks = 0;
    s.held = true;
    s.held_ticks = s.limit_ticks = 0;
    if (plan.hold.limit_s > 0.0)
        s.limit_ticks = toTicks(plan.hold.limit_s * (0.8 + 0.4 * draw(plan, s.breath, Draw::limit)), dt_s);
    if (recorded(plan) || !(draw(plan, s.breath, Draw::cough) < plan.coughs)) return;
    const std::uint64_t until =
        toTicks(plan.rhythm.period_s * (0.5 + draw(plan, s.breath, Draw::coughTime)), dt_s);
    s.ends_in_cough = s.limit_ticks == 0 || until < s.limit_ticks;
    if (s.ends_in_cough) s.limit_ticks = until;
}

void endHold(BreathingState& s, const BreathPlan& plan, double dt_s) noexcept {
    s.residual_creep_v = creepAt(s, plan, dt_s);
    s.residual_creep_ticks = 0;
    s.held = false;
    // The next breath was drawn before the hold; replace it.
    if (s.ends_in_cough && !recorded(plan)) {
        s.now.end_v = s.now.start_v;
        beginBreath(s, plan, dt_s);
    } else if (s.hold_aborted && !recorded(plan)) {
        s.now = makeSigh(plan, s.now.start_v, dt_s);
    }
}

}  // namespace

bool isValidPlan(const BreathPlan& p) noexcept {
    // False for NaN.
    const auto within = [](double v, double low, double high) { return v >= low && v <= high; };
    for (const double share : {p.period_jitter, p.depth_jitter, p.sighs, p.coughs, p.hold.missed})
        if (!within(share, 0.0, 1.0)) return false;
    for (const double v : p.recording_v)
        if (!within(v, -1e6, 1e6)) return false;
    return within(p.rhythm.period_s, 0.1, 1e3) && within(p.rhythm.amplitude, 0.0, 10.0) &&
           within(p.hold.creep_v, -100.0, 100.0) && within(p.hold.creep_s, 1e-3, 1e6) &&
           within(p.hold.level_v, 0.0, 10.0) && within(p.hold.limit_s, 0.0, 1e6) &&
           within(p.recording_dt_s, 1e-3, 10.0);
}

void commandHold(BreathingState& s, bool wanted) noexcept {
    s.hold_wanted = wanted;
    s.hold_aborted = false;
}

void stepBreathing(BreathingState& s, const BreathPlan& plan, double dt_s) noexcept {
    if (s.held) {
        ++s.held_ticks;
        const bool spent = s.limit_ticks > 0 && s.held_ticks >= s.limit_ticks;
        if (s.hold_wanted && !spent) return;
        s.hold_aborted = s.hold_wanted;
        s.ends_in_cough = s.ends_in_cough && spent;
        endHold(s, plan, dt_s);
    } else if (startsHold(s, plan)) {
        beginHold(s, plan, dt_s);
        return;
    }
    if (s.residual_creep_v != 0.0 && double(++s.residual_creep_ticks) * dt_s >= kEase_s)
        s.residual_creep_v = 0.0;
    advance(s, plan, dt_s);
    if (startsHold(s, plan)) beginHold(s, plan, dt_s);
}

Surrogate surrogateAt(const BreathingState& s, const BreathPlan& plan, double dt_s) noexcept {
    Surrogate at =
        recorded(plan) ? recordingAt(plan, s.phase_ticks, dt_s) : breathAt(s.now, s.phase_ticks, dt_s);
    if (s.held) at.rate_per_s = 0.0;
    at.creep_v = creepAt(s, plan, dt_s);
    return at;
}

double longestBreath_s(const BreathPlan& plan, double dt_s) {
    if (!recorded(plan)) {
        const double usual_s = plan.rhythm.period_s * jittered(plan.period_jitter, 1.0);
        const double sigh_s = plan.sighs > 0.0 ? kSighLength * plan.rhythm.period_s : 0.0;
        const double cough_s = plan.coughs > 0.0 ? kGasp_s + kBursts * kBurst_s : 0.0;
        return std::max({kMinBreath_s, usual_s, sigh_s}) + cough_s;
    }
    // Goes twice around the loop, to include the breath across its seam.
    BreathingState state;
    std::uint64_t longest = 0, since = 0;
    for (std::uint64_t i = 0; i < 2 * loopTicks(plan, dt_s); ++i) {
        stepBreathing(state, plan, dt_s);
        since = state.at_end_exhale ? 0 : since + 1;
        longest = std::max(longest, since);
    }
    return double(longest + 1) * dt_s;
}

void hashSurrogate(StateHash& hash, const Surrogate& s) noexcept {
    hash.add(s.v), hash.add(s.rate_per_s), hash.add(s.creep_v);
}

void hashBreathing(StateHash& hash, const BreathingState& s) noexcept {
    for (const std::uint64_t v :
         {s.phase_ticks, s.breath, s.now.ticks, s.held_ticks, s.limit_ticks, s.residual_creep_ticks})
        hash.add(v);
    for (const double v : {s.now.start_v, s.now.peak_v, s.now.end_v, s.residual_creep_v})
        hash.add(v);
    hash.add(std::uint64_t(s.hold_wanted) | std::uint64_t(s.held) << 1 | std::uint64_t(s.at_end_exhale) << 2 |
             std::uint64_t(s.hold_aborted) << 3 | std::uint64_t(s.ends_in_cough) << 4 |
             std::uint64_t(s.bursts_left) << 32);
}

void hashPlan(StateHash& hash, const BreathPlan& p) noexcept {
    for (const double v :
         {p.rhythm.period_s, p.rhythm.amplitude, p.period_jitter, p.depth_jitter, p.sighs, p.coughs,
          p.hold.creep_v, p.hold.creep_s, p.hold.missed, p.hold.level_v, p.hold.limit_s, p.recording_dt_s})
        hash.add(v);
    hash.add(p.seed);
    hash.add(std::uint64_t(p.recording_v.size()));
    for (const double v : p.recording_v)
        hash.add(v);
}

}  // namespace stylet::patient
