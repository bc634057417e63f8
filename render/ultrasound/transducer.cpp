// Based on Szabo, Diagnostic Ultrasound Imaging: Inside Out, 2nd ed. 2014, ch. 10: beams of focused
// apertures.
#include "render/ultrasound/transducer.h"

#include <algorithm>
#include <cmath>

#include "base/fields.h"
#include "base/whole_file.h"

namespace stylet::render {
namespace {

constexpr std::size_t kMaxTransducerBytes = 1 << 16;
constexpr double kMm = 1e-3, kMhz = 1e6, kDeg = 0.017453292519943295;
// Full width at half amplitude of an unapodised aperture, in wavelengths times depth over aperture.
constexpr double kDiffraction = 1.2;
constexpr double kReceiveFNumber = 1.5;  // the receiving aperture grows with depth up to its full size

double square(double x) {
    return x * x;
}

}  // namespace

Transducer loadTransducer(const std::filesystem::path& file) {
    return parseTransducer(file, readWholeFile(file, kMaxTransducerBytes));
}

Transducer parseTransducer(const std::filesystem::path& file, std::string_view text) {
    Fields t = parseToml(file, text);
    Transducer probe;
    probe.name = t.nonEmptyText("name");
    const std::string shape = t.nonEmptyText("shape");
    if (shape == "convex") {
        probe.radius_m = kMm * t.number("radius_mm", 5.0, 200.0);
        probe.half_angle_rad = kDeg * t.number("half_angle_deg", 1.0, 60.0);
    } else if (shape == "linear") {
        probe.shape = TransducerShape::linear;
        probe.width_m = kMm * t.number("width_mm", 5.0, 200.0);
    } else {
        t.refuse("shape", "'" + shape + "' is neither convex nor linear");
    }
    probe.depth_m = kMm * t.number("depth_mm", 10.0, 300.0);
    probe.focus_m = kMm * t.number("focus_mm", 5.0, 300.0);
    probe.lowest_frequency_hz = kMhz * t.number("lowest_frequency_mhz", 0.5, 30.0);
    probe.highest_frequency_hz = kMhz * t.number("highest_frequency_mhz", 0.5, 30.0);
    if (probe.highest_frequency_hz < probe.lowest_frequency_hz)
        t.refuse("highest_frequency_mhz", "below lowest_frequency_mhz");
    probe.frequency_hz =
        kMhz * t.number("frequency_mhz", probe.lowest_frequency_hz / kMhz, probe.highest_frequency_hz / kMhz);
    probe.aperture_m = kMm * t.number("aperture_mm", 1.0, 200.0);
    probe.pulse_cycles = t.number("pulse_cycles", 0.5, 20.0);
    probe.thickness_m = kMm * t.number("thickness_mm", 0.2, 20.0);
    probe.thickness_focus_m = kMm * t.number("thickness_focus_mm", 1.0, 300.0);
    probe.thickness_range_m = kMm * t.number("thickness_range_mm", 1.0, 1000.0);
    return probe;
}

Transducer withFace(Transducer probe, double length_m, double curvature_m) {
    if (isFlatFace(length_m, curvature_m)) {
        probe.shape = TransducerShape::linear;
        probe.width_m = length_m;
    } else {
        probe.shape = TransducerShape::convex;
        probe.radius_m = curvature_m;
        probe.half_angle_rad = std::asin(std::min(0.5 * length_m / curvature_m, 1.0));
    }
    return probe;
}

ScanLine scanLine(const Transducer& probe, double share) {
    if (probe.shape == TransducerShape::linear) return {{0.5 * share * probe.width_m, 0, 0}, {0, 0, 1}};
    const double angle = share * probe.half_angle_rad, s = std::sin(angle), c = std::cos(angle);
    return {{probe.radius_m * s, 0.0, probe.radius_m * (c - 1.0)}, {s, 0.0, c}};
}

double linePitch_m(const Transducer& probe, int lines, double depth_m) {
    const double steps = std::max(lines - 1, 1);
    if (probe.shape == TransducerShape::linear) return probe.width_m / steps;
    return (probe.radius_m + depth_m) * 2.0 * probe.half_angle_rad / steps;
}

double pulseLength_m(const Transducer& probe, double frequency_hz) {
    return 0.5 * probe.pulse_cycles * kAssumedSpeed_m_per_s / frequency_hz;
}

double beamWidth_m(const Transducer& probe, double frequency_hz, double focus_m, double depth_m) {
    const double wave_m = kAssumedSpeed_m_per_s / frequency_hz, depth = std::max(depth_m, 0.002);
    const double listening = std::min(probe.aperture_m, depth / kReceiveFNumber);
    const double received = kDiffraction * wave_m * depth / listening;
    const double sent = std::hypot(kDiffraction * wave_m * depth / probe.aperture_m,
                                   0.5 * probe.aperture_m * (1.0 - depth / focus_m));
    return 1.0 / std::sqrt(1.0 / square(received) + 1.0 / square(sent));
}

double beamThickness_m(const Transducer& probe, double depth_m) {
    return probe.thickness_m * std::hypot(1.0, (depth_m - probe.thickness_focus_m) / probe.thickness_range_m);
}

}  // namespace stylet::render
