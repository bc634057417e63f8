#include "app/trainer/sound/clips.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace stylet::trainer {
namespace {

using Samples = std::vector<float>;
constexpr double kTau = 2.0 * std::numbers::pi;

std::size_t countOf(double seconds) {
    return std::size_t(seconds * kClipRate_hz);
}

Samples noise(double seconds, std::uint32_t seed) {
    std::mt19937 random(seed);
    Samples out(countOf(seconds));
    for (float& s : out)
        s = float(double(random()) / 2147483647.5 - 1.0);
    return out;
}

// One-pole low-pass filter.
Samples lowPassed(Samples in, double hz) {
    const double share = 1.0 - std::exp(-kTau * hz / kClipRate_hz);
    double state = 0.0;
    for (float& s : in)
        s = float(state += share * (double(s) - state));
    return in;
}

Samples highPassed(const Samples& in, double hz) {
    Samples low = lowPassed(in, hz);
    for (std::size_t i = 0; i < in.size(); ++i)
        low[i] = in[i] - low[i];
    return low;
}

// Crossfades the last `seconds` with the first ones at constant power, so that noise loops without a seam.
Samples looped(const Samples& in, double seconds) {
    const std::size_t over = countOf(seconds), rest = in.size() - over;
    Samples out(in.begin(), in.begin() + std::ptrdiff_t(rest));
    for (std::size_t i = 0; i < over; ++i) {
        const double share = 0.25 * kTau * double(i) / double(over);
        out[i] = float(std::sin(share) * double(in[i]) + std::cos(share) * double(in[rest + i]));
    }
    return out;
}

// Adds a tone that starts at `begin_s`, rises over `attack_s` and decays with the time constant `decay_s`.
void addTone(Samples& out, double begin_s, double hz, double level, double attack_s, double decay_s) {
    for (std::size_t i = countOf(begin_s); i < out.size(); ++i) {
        const double t_s = double(i) / kClipRate_hz - begin_s;
        const double envelope = std::min(1.0, t_s / attack_s) * std::exp(-t_s / decay_s);
        out[i] += float(level * envelope * std::sin(kTau * hz * t_s));
    }
}

// Adds a tone of constant level from `begin_s` to `end_s`, faded in and out.
void addBeep(Samples& out, double begin_s, double end_s, double hz) {
    constexpr double kEdge_s = 0.008;
    for (std::size_t i = countOf(begin_s); i < std::min(out.size(), countOf(end_s)); ++i) {
        const double t_s = double(i) / kClipRate_hz;
        const double edge = std::clamp(std::min(t_s - begin_s, end_s - t_s) / kEdge_s, 0.0, 1.0);
        const double phase = kTau * hz * (t_s - begin_s);
        out[i] += float(edge * (0.8 * std::sin(phase) + 0.2 * std::sin(2.0 * phase)));
    }
}

// Normalises to kClipPeak. Fades out the end of a clip that does not loop.
Samples finished(Samples out, bool loop) {
    const std::size_t edge = std::min(out.size() / 2, countOf(0.003));
    for (std::size_t i = 0; i < edge && !loop; ++i)
        out[out.size() - 1 - i] *= float(i) / float(edge);
    float most = 0.0f;
    for (const float s : out)
        most = std::max(most, std::fabs(s));
    for (float& s : out)
        s *= float(kClipPeak) / most;
    return out;
}

// Harmonics of a mains transformer. Contains whole periods only, so that the clip loops.
Samples buzz() {
    Samples out(countOf(1.0));
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double t_s = double(i) / kClipRate_hz;
        for (int harmonic = 1; harmonic <= 6; ++harmonic)
            out[i] += float(std::sin(kTau * 120.0 * harmonic * t_s) / (harmonic + 1.0));
    }
    return out;
}

Samples alarm() {
    Samples out(countOf(0.6));
    addBeep(out, 0.0, 0.16, 932.0);
    addBeep(out, 0.18, 0.34, 698.0);
    return out;
}

Samples beep() {
    Samples out(countOf(0.12));
    addBeep(out, 0.0, 0.11, 880.0);
    return out;
}

Samples click() {
    Samples out(countOf(0.05));
    addTone(out, 0.0, 2300.0, 0.7, 0.0004, 0.003);
    addTone(out, 0.014, 3400.0, 1.0, 0.0003, 0.004);
    addTone(out, 0.014, 900.0, 0.5, 0.0005, 0.008);
    return out;
}

Samples cut() {
    Samples out = highPassed(lowPassed(noise(0.28, 11), 5200.0), 1400.0);
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double share = double(i) / double(out.size());
        out[i] *= float(std::sin(0.5 * kTau * share) * (0.7 + 0.3 * std::sin(kTau * 9.0 * share)));
    }
    return out;
}

Samples tick() {
    Samples out(countOf(0.12));
    addTone(out, 0.0, 190.0, 1.0, 0.001, 0.018);
    addTone(out, 0.0, 1250.0, 0.5, 0.0005, 0.004);
    return out;
}

Samples chime() {
    Samples out(countOf(1.6));
    const std::array notes_hz{1046.5, 1318.5, 1568.0};
    for (std::size_t i = 0; i < notes_hz.size(); ++i)
        addTone(out, 0.13 * double(i), notes_hz[i], 1.0, 0.006, 0.35);
    return out;
}

// Indexed by Sound.
constexpr std::array<Samples (*)(), kSoundCount> kMakers{
    [] { return looped(lowPassed(lowPassed(noise(5.0, 3), 420.0), 260.0), 1.0); },
    [] { return looped(highPassed(lowPassed(noise(3.0, 7), 1100.0), 420.0), 0.5); },
    buzz,
    alarm,
    beep,
    click,
    cut,
    tick,
    chime};

}  // namespace

std::vector<float> makeClip(Sound sound) {
    return finished(kMakers[std::size_t(sound)](), loops(sound));
}

}  // namespace stylet::trainer
