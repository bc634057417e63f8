// The breath at a point and as tables: grid, steps, squarings and storage against time, and the error against
// the converged field.
#include <cmath>
#include <cstdio>
#include <random>

#include "patient/patient.h"
#include "patient/synth/synth.h"
#include "tests/bench/bench.h"
#include "tests/support/phantom.h"
#ifdef STYLET_BENCH_TABLES
#include "render/deform.h"
#endif

namespace stylet::bench {
namespace {

using namespace patient;

constexpr double kFinest_m = 0.002;
constexpr double kBand_m = 0.010;
const Surrogate kNow{0.9, 0.6};
constexpr int kPoints = 40000;

struct Probe {
    Package package;
    MotionModel fine;  // the converged field
    std::vector<Vec3> points_m;
    std::vector<Vec3> truth_m;    // where they came from
    std::vector<double> level_m;  // of the deformed point, in `fine`
};

MotionModel templateAt(const Package& p, double spacing_m) {
    MotionAmplitudes amplitudes;
    amplitudes.spacing_m = spacing_m;
    return motionTemplate(p.labels, p.label_table, amplitudes, {});
}

// exp(-w) by `steps` midpoint steps of the model's own fields.
Vec3 inverseBySteps(const MotionModel& m, const Vec3& deformed_m, int steps) {
    const auto back = [&](MotionPart part, Vec3 p) {
        const double h = 1.0 / steps;
        for (int i = 0; i < steps; ++i) {
            const Vec3 middle = p - 0.5 * h * motionField_m(m, part, kNow, p);
            p -= h * motionField_m(m, part, kNow, middle);
        }
        return p;
    };
    const Vec3 p = back(MotionPart::wall, deformed_m);
    return cavityLevel_m(m, p) < 0.0 ? back(MotionPart::slide, p) : p;
}

Probe makeProbe() {
    Probe probe;
    synth::SynthSettings settings;
    settings.spacing_m = 0.002;
    settings.defaults = test::tissueDefaults();
    probe.package = synth::makeReferencePatient(settings);
    probe.fine = templateAt(probe.package, kFinest_m);
    const Grid& grid = probe.package.labels.grid;
    std::mt19937 random(5);
    while (int(probe.points_m.size()) < kPoints) {
        const auto share = [&] { return double(random()) / 4294967296.0; };
        const Vec3 p = grid.origin_m + grid.spacing_m * Vec3(grid.dims - 1) * Vec3(share(), share(), share());
        if (probe.package.labels.nearestOr(p, 0) == 0) continue;  // in the body
        probe.points_m.push_back(p);
        probe.truth_m.push_back(inverseBySteps(probe.fine, p, 64));
        probe.level_m.push_back(cavityLevel_m(probe.fine, kNow, p));
    }
    return probe;
}

const Probe& probe() {
    static const Probe made = makeProbe();
    return made;
}

// The error away from the surface decides; what it is within 10 mm of it, and over all, is noted.
void report(std::vector<Row>& rows, const std::string& name, const std::string& knob, double value,
            double time_ms, const std::string& time_of, const std::vector<Vec3>& found_m) {
    std::vector<double> away_mm, band_mm, whole_mm;
    double sum_mm = 0.0;
    const Probe& p = probe();
    for (std::size_t i = 0; i < found_m.size(); ++i) {
        const double error_mm = 1e3 * glm::length(found_m[i] - p.truth_m[i]);
        (std::fabs(p.level_m[i]) > kBand_m ? away_mm : band_mm).push_back(error_mm);
        whole_mm.push_back(error_mm);
        sum_mm += error_mm;
    }
    char note[200];
    std::snprintf(note, sizeof note, "%s; whole mean %.4f p99 %.3f max %.2f; 10 mm band p50 %.4f p99 %.3f mm",
                  time_of.c_str(), sum_mm / double(whole_mm.size()), quantile(whole_mm, 0.99),
                  quantile(whole_mm, 1.0), median(band_mm), quantile(band_mm, 0.99));
    rows.push_back({name, knob, value, time_ms, quantile(away_mm, 0.99), "mm p99",
                    "2 mm nodes, 64 steps, double", note});
}

template <typename Inverse>
void inverseRow(std::vector<Row>& rows, const std::string& knob, double value, const Inverse& inverse) {
    const Probe& p = probe();
    std::vector<Vec3> found_m;
    std::vector<double> times_ns;
    for (std::size_t i = 0; i < p.points_m.size();) {
        const auto began = std::chrono::steady_clock::now();
        const std::size_t end = std::min(i + 100, p.points_m.size());
        const std::size_t count = end - i;
        for (; i < end; ++i)
            found_m.push_back(inverse(p.points_m[i]));
        times_ns.push_back(1e6 * elapsed_ms(began) / double(count));
    }
    char time_of[80];
    std::snprintf(time_of, sizeof time_of, "median %.0f ns a point", median(times_ns));
    report(rows, "patient.point_inverse", knob, value, 1e-6 * median(times_ns), time_of, found_m);
}

// Coefficients in steps of `step_m`, as 16-bit integers would hold them.
MotionModel coarsened(MotionModel m, double step_m) {
    const auto round = [&](float& x) { x = float(std::floor(double(x) / step_m + 0.5) * step_m); };
    for (std::vector<MotionCoefficients>* field : {&m.wall, &m.slide})
        for (MotionCoefficients& c : *field)
            for (std::size_t i = 0; i < 3; ++i)
                round(c.a1_m[i]), round(c.a2_m_s[i]);
    for (float& level : m.level_m)
        round(level);
    return m;
}

void runInverse(std::vector<Row>& rows) {
    for (const double spacing_mm : {3.0, 4.0, 5.0, 6.0, 8.0, 10.0}) {
        const MotionModel m = templateAt(probe().package, 1e-3 * spacing_mm);
        inverseRow(rows, "nodes [mm]", spacing_mm,
                   [&](const Vec3& p) { return referenceFromDeformed(m, kNow, p); });
    }
    const MotionModel m = templateAt(probe().package, MotionAmplitudes{}.spacing_m);
    for (const int steps : {1, 2, 4, 8})
        inverseRow(rows, "steps at 6 mm", steps, [&](const Vec3& p) { return inverseBySteps(m, p, steps); });
    for (const double step_um : {1.0, 2.0, 10.0, 50.0}) {
        const MotionModel stored = coarsened(m, 1e-6 * step_um);
        inverseRow(rows, "stored to [um]", step_um,
                   [&](const Vec3& p) { return referenceFromDeformed(stored, kNow, p); });
    }
}
const Registration inverse_registration("patient.point_inverse", runInverse);

#ifdef STYLET_BENCH_TABLES
void tableRow(std::vector<Row>& rows, const std::string& knob, double value,
              const render::DeformSettings& settings) {
    const MotionModel m = templateAt(probe().package, MotionAmplitudes{}.spacing_m);
    std::vector<double> times_ms;
    render::DeformTables tables;
    for (int i = 0; i < 3; ++i) {
        const auto began = std::chrono::steady_clock::now();
        tables = render::deformTables(m, kNow, settings);
        times_ms.push_back(elapsed_ms(began));
    }
    std::vector<Vec3> found_m;
    for (const Vec3& p : probe().points_m)
        found_m.push_back(render::referenceFromTables(tables, p));
    char time_of[80];
    std::snprintf(time_of, sizeof time_of, "%zu nodes", tables.inside.size());
    report(rows, "patient.breathing", knob, value, median(times_ms), time_of, found_m);
}

void runTables(std::vector<Row>& rows) {
    for (const double spacing_mm : {3.0, 4.0, 5.0, 6.0, 8.0})
        tableRow(rows, "table [mm]", spacing_mm, {.spacing_m = 1e-3 * spacing_mm});
    for (const int squarings : {0, 1, 2, 3, 5})
        tableRow(rows, "squarings", squarings, {.squarings = squarings});
}
const Registration tables_registration("patient.breathing", runTables);
#endif

}  // namespace
}  // namespace stylet::bench
