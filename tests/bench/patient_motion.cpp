// Breathing motion at a point and as tables: its time, and its error against the converged field. Two
// errors are reported separately. The modelling error compares wider nodes with nodes of 2 mm. The
// numerical error compares steps, squarings and storage with the same model in 64 steps of double
// precision.
#include <cmath>
#include <random>

#include <fmt/core.h>

#include "patient/patient.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"
#ifdef STYLET_BENCH_TABLES
#include "render/volume/patient_volume.h"
#include "tests/bench/gpu.h"
#include "tests/render/pictures.h"
#include "tests/render/volume/deform_points.h"
#endif

namespace stylet::bench {
namespace {

using namespace patient;

constexpr double kFinest_m = 0.002;
constexpr double kBand_m = 0.010;
const Surrogate kNow{0.9, 0.6};
const Surrogate kDeepest{1.5, 0.0};  // every breath is clamped to this limit
constexpr int kPoints = 40000;

constexpr int kManySteps = 64;

// Reference for an inverse: the reference positions of points of the deformed patient, by one model.
struct Truth {
    const char* name;
    std::vector<Vec3> reference_m;
    std::vector<double> level_m;  // cavity level of the deformed point
};

struct Probe {
    Package package;
    MotionModel usual;  // as shipped
    std::vector<Vec3> points_m;
    // finest: nodes of 2 mm at kNow. own, deepest: the usual nodes at kNow and in the deepest breath.
    Truth finest, own, deepest;
};

MotionModel templateAt(const Package& p, double spacing_m) {
    MotionAmplitudes amplitudes;
    amplitudes.spacing_m = spacing_m;
    return motionTemplate(p.labels, p.label_table, amplitudes, {});
}

// Computes exp(unit_s * w) of one part with `steps` midpoint steps of the model's own field.
Vec3 flowBySteps(const MotionModel& m, MotionPart part, const Surrogate& now, Vec3 p, int steps,
                 double unit_s) {
    const double h = unit_s / steps;
    for (int i = 0; i < steps; ++i) {
        const Vec3 middle = p + 0.5 * h * motionField_m(m, part, now, p);
        p += h * motionField_m(m, part, now, middle);
    }
    return p;
}

Vec3 inverseBySteps(const MotionModel& m, const Surrogate& now, const Vec3& deformed_m, int steps) {
    const Vec3 p = flowBySteps(m, MotionPart::wall, now, deformed_m, steps, -1.0);
    return cavityLevel_m(m, p) < 0.0 ? flowBySteps(m, MotionPart::slide, now, p, steps, -1.0) : p;
}

Vec3 forwardBySteps(const MotionModel& m, const Surrogate& now, Side side, Vec3 p, int steps) {
    if (side == Side::inside) p = flowBySteps(m, MotionPart::slide, now, p, steps, 1.0);
    return flowBySteps(m, MotionPart::wall, now, p, steps, 1.0);
}

Truth computeTruth(const char* name, const MotionModel& m, const Surrogate& now,
                   const std::vector<Vec3>& points_m) {
    Truth truth{name, {}, {}};
    for (const Vec3& p : points_m) {
        truth.reference_m.push_back(inverseBySteps(m, now, p, kManySteps));
        truth.level_m.push_back(cavityLevel_m(m, now, p));
    }
    return truth;
}

Probe makeProbe() {
    Probe probe;
    probe.package = referencePatient(0.002);
    probe.usual = templateAt(probe.package, MotionAmplitudes{}.spacing_m);
    const Grid& grid = probe.package.labels.grid;
    std::mt19937 random(5);
    while (int(probe.points_m.size()) < kPoints) {
        const auto share = [&] { return double(random()) / 4294967296.0; };
        const Vec3 p = grid.origin_m + grid.spacing_m * Vec3(grid.dims - 1) * Vec3(share(), share(), share());
        if (probe.package.labels.nearestOr(p, 0) != 0) probe.points_m.push_back(p);  // in the body
    }
    const MotionModel fine = templateAt(probe.package, kFinest_m);
    probe.finest = computeTruth("nodes of 2 mm, 64 steps, double", fine, kNow, probe.points_m);
    probe.own = computeTruth("the same model, 64 steps, double", probe.usual, kNow, probe.points_m);
    probe.deepest =
        computeTruth("the same model, 64 steps, double, v = 1.5", probe.usual, kDeepest, probe.points_m);
    return probe;
}

const Probe& probe() {
    static const Probe made = makeProbe();
    return made;
}

std::string summary(const std::vector<double>& errors_mm) {
    return fmt::format("mean {:.4f} p99 {:.4f} max {:.3f}", mean(errors_mm), quantile(errors_mm, 0.99),
                       quantile(errors_mm, 1.0));
}

// The row's figure is the p99 error at points more than 10 mm from the cavity's surface. The note adds the
// errors within 10 mm of the surface and over all points.
void report(std::vector<Row>& rows, const std::string& name, const std::string& knob, double value,
            double time_ms, const std::string& time_of, const std::vector<Vec3>& found_m,
            const Truth& truth) {
    std::vector<double> away_mm, band_mm, whole_mm;
    for (std::size_t i = 0; i < found_m.size(); ++i) {
        const double error_mm = 1e3 * glm::length(found_m[i] - truth.reference_m[i]);
        (std::fabs(truth.level_m[i]) > kBand_m ? away_mm : band_mm).push_back(error_mm);
        whole_mm.push_back(error_mm);
    }
    rows.push_back({name, knob, value, time_ms, quantile(away_mm, 0.99), "mm p99", truth.name,
                    time_of + "; whole " + summary(whole_mm) + "; 10 mm band " + summary(band_mm) + " mm"});
}

template <typename Inverse>
void inverseRow(std::vector<Row>& rows, const std::string& knob, double value, const Truth& truth,
                const Inverse& inverse) {
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
    const std::string time_of = fmt::format("median {:.0f} ns a point", median(times_ns));
    report(rows, "patient.point_inverse", knob, value, 1e-6 * median(times_ns), time_of, found_m, truth);
}

// Rounds the coefficients to multiples of `step_m`, as storage in 16-bit integers would.
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
    const Probe& p = probe();
    for (const double spacing_mm : {3.0, 4.0, 5.0, 6.0, 8.0, 10.0}) {
        const MotionModel m = templateAt(p.package, 1e-3 * spacing_mm);
        inverseRow(rows, "nodes [mm]", spacing_mm, p.finest,
                   [&](const Vec3& x) { return referenceFromDeformed(m, kNow, x); });
    }
    for (const int steps : {1, 2, 3, 4, 8, 16})
        inverseRow(rows, "steps", steps, p.own,
                   [&](const Vec3& x) { return inverseBySteps(p.usual, kNow, x, steps); });
    for (const int steps : {2, 3, 4, 8})
        inverseRow(rows, "steps, deepest breath", steps, p.deepest,
                   [&](const Vec3& x) { return inverseBySteps(p.usual, kDeepest, x, steps); });
    // Use many steps, so that only the precision of storage differs.
    for (const double step_um : {1.0, 2.0, 10.0, 50.0}) {
        const MotionModel stored = coarsened(p.usual, 1e-6 * step_um);
        inverseRow(rows, "stored to [um]", step_um, p.own,
                   [&](const Vec3& x) { return inverseBySteps(stored, kNow, x, kManySteps); });
    }
}
const Registration inverse_registration("patient.point_inverse", runInverse);

// Measures the motion queries of a needle's channel in a tick: the current position of a point, and the
// point that lies 20 um further along. The paths of 10 mm start at points all over the body. Each point is
// followed from tick to tick.
void runFollow(std::vector<Row>& rows) {
    constexpr int kPaths = 400, kTicks = 500, kLook = 10;
    const Probe& p = probe();
    const BreathPlan plan{.rhythm = p.package.signal};
    BreathingState state;
    std::array<Surrogate, kTicks> breath;
    for (int i = 0; i < 1250; ++i)
        stepBreathing(state, plan, 0.001);
    for (Surrogate& now : breath) {  // the deeper half of the inhalation
        stepBreathing(state, plan, 0.001);
        now = surrogateAt(state, plan, 0.001);
    }
    for (const double reach_mm : {0.0, 0.05, 0.1, 0.2, 0.4, 0.8}) {
        const LocalReach reach{1e-3 * reach_mm, 3e-3 * reach_mm};
        std::vector<double> times_ns, errors_mm;
        double anew = 0.0;
        std::array<Vec3, kTicks> point_m;
        for (int path = 0; path < kPaths; ++path) {
            const std::size_t from = std::size_t(path) * (p.points_m.size() / kPaths);
            Vec3 point = p.points_m[from], target_m = point;
            const Side side = cavityLevel_m(p.usual, point) < 0.0 ? Side::inside : Side::outside;
            LocalMotion about;
            Vec3 at_m = follow(about, p.usual, breath[0], side, point, reach), known = point;
            const Vec3 step_m = 20e-6 * glm::normalize(p.points_m[from + 1] - point);
            target_m = at_m;
            const auto began = std::chrono::steady_clock::now();
            for (std::size_t tick = 0; tick < kTicks; ++tick) {
                at_m = follow(about, p.usual, breath[tick], side, point, reach);
                target_m += step_m;
                point += about.reference_from_deformed * (target_m - at_m);
                point_m[tick] = point;
                anew += about.reference_m != known;
                known = about.reference_m;
            }
            times_ns.push_back(1e6 * elapsed_ms(began) / kTicks);
            for (std::size_t tick = kLook - 1; tick < kTicks; tick += kLook) {
                const Vec3 there = forwardBySteps(p.usual, breath[tick], side, point_m[tick], kManySteps);
                const Vec3 start = p.points_m[from];
                target_m =
                    follow(about, p.usual, breath[0], side, start, {-1.0, -1.0}) + double(tick + 1) * step_m;
                errors_mm.push_back(1e3 * glm::length(there - target_m));
            }
        }
        const std::string note =
            fmt::format("median {:.0f} ns a tick; made anew in {:.0f} % of ticks; {} mm", median(times_ns),
                        100.0 * anew / (kPaths * kTicks), summary(errors_mm));
        rows.push_back({"patient.follow", "reach in the tissue [mm]", reach_mm, 1e-6 * median(times_ns),
                        quantile(errors_mm, 0.99), "mm p99", "64 steps, double, each tick", note});
    }
}
const Registration follow_registration("patient.follow", runFollow);

#ifdef STYLET_BENCH_TABLES
// Alternative method to compute a table: `squarings` squarings of one midpoint step, on the grid of the
// tables (Arsigny et al. 2006).
render::DeformTables squaredTables(const MotionModel& m, const Grid& grid, int squarings) {
    const auto forEachNode = [&](const auto& visit) {
        forEachVoxel(grid, [&](const Index3& i) { visit(grid.offset(i), grid.centre(i)); });
    };
    // w = -1 makes the lookup read the inside table, the only one filled here.
    const auto squared = [&](MotionPart part) {
        const double step = 1.0 / (1 << squarings);
        render::DeformTables table{grid, std::vector<glm::vec4>(grid.voxelCount(), {0, 0, 0, -1}), {}};
        forEachNode([&](std::size_t at, const Vec3& p) {
            const Vec3 here = motionField_m(m, part, kNow, p);
            if (here == Vec3(0.0)) return;
            const Vec3 middle = motionField_m(m, part, kNow, p - 0.5 * step * here);
            table.inside[at] = glm::vec4(glm::vec3(-step * middle), -1.0f);
        });
        for (int k = 0; k < squarings; ++k) {
            std::vector<glm::vec4> next = table.inside;
            forEachNode([&](std::size_t at, const Vec3& p) {
                const Vec3 own(table.inside[at]);
                if (own != Vec3(0.0))
                    next[at] = glm::vec4(glm::vec3(referenceFromTables(table, p + own) - p), -1.0f);
            });
            table.inside.swap(next);
        }
        return table;
    };
    const render::DeformTables wall = squared(MotionPart::wall), slide = squared(MotionPart::slide);
    render::DeformTables tables{grid, wall.inside, wall.inside};
    forEachNode([&](std::size_t at, const Vec3& p) {
        const Vec3 before = p + Vec3(wall.inside[at]);
        tables.inside[at] =
            glm::vec4(glm::vec3(referenceFromTables(slide, before) - p), float(cavityLevel_m(m, before)));
    });
    return tables;
}

// `make` computes and returns the tables. The median of five calls is reported, so that the first call's
// extra cost does not count.
template <typename Make>
void tableRow(std::vector<Row>& rows, const std::string& knob, double value, const std::string& of,
              const Truth& truth, const Make& make) {
    const Probe& p = probe();
    const render::DeformTables* tables = nullptr;
    const double time_ms = medianTime_ms(5, [&] { tables = &make(); });
    std::vector<Vec3> found_m;
    for (const Vec3& x : p.points_m)
        found_m.push_back(render::referenceFromTables(*tables, x));
    report(rows, "patient.breathing", knob, value, time_ms, of, found_m, truth);
}

void builderRow(std::vector<Row>& rows, const std::string& knob, double value,
                const render::DeformSettings& settings, int threads = 1, bool all = false,
                bool deepest = false) {
    Probe p = probe();
    p.package.motion = p.usual;
    const Patient patient(p.package);
    render::Workers workers(threads);
    render::DeformTableBuilder maker(p.package.motion, settings, all ? nullptr : &patient);
    const std::string of = std::to_string(maker.computedNodes()) + " of " +
                           std::to_string(maker.tables().inside.size()) + " nodes, " +
                           std::to_string(threads) + " threads";
    tableRow(rows, knob, value, of, deepest ? p.deepest : p.own, [&]() -> const render::DeformTables& {
        maker.compute(deepest ? kDeepest : kNow, workers);
        return maker.tables();
    });
}

// Computes the tables, uploads them as half floats and reads them with the device's filter.
void gpuRow(std::vector<Row>& rows) {
    if (!hasGpu("patient.breathing")) return;
    Probe p = probe();
    p.package.motion = p.usual;
    const Patient patient(p.package);
    const render::Gpu gpu({});
    render::DeformedPatient deformed(gpu, patient);
    render::PatientVolume volume(gpu, patient, deformed, render::PatientVolume::Reader::gpu);
    volume.show(render::loadLook(test::assetsFolder() / "looks" / "reveal.toml"),
                render::PatientVolume::Reader::gpu);
    std::vector<double> frame_ms, upload_ms;
    for (int i = 0; i < 9; ++i) {
        const Surrogate now{kNow.v - 0.05 * (8 - i), kNow.rate_per_s};
        auto began = std::chrono::steady_clock::now();
        deformed.breathe(now, false);
        deformed.press(nullptr);
        volume.updateBricks();
        frame_ms.push_back(elapsed_ms(began));
        began = std::chrono::steady_clock::now();
        render::submitAndWait(gpu, [&](const auto& commands) { deformed.recordUploads(commands); });
        upload_ms.push_back(elapsed_ms(began));
    }
    const std::string note =
        fmt::format("{}: tables, halves, bricks {:.1f} ms, copied {:.1f} ms a breath seen", gpu.name(),
                    median(frame_ms), median(upload_ms));
    report(rows, "patient.breathing", "on the GPU: table [mm]", 1e3 * render::DeformSettings{}.spacing_m,
           median(frame_ms) + median(upload_ms), note, test::referenceOnGpu(gpu, deformed, p.points_m),
           p.own);
}

void runTables(std::vector<Row>& rows) {
    for (const double spacing_mm : {2.0, 3.0, 4.0, 6.0})
        builderRow(rows, "table [mm]", spacing_mm, {.spacing_m = 1e-3 * spacing_mm});
    for (const double step_mm : {1.0, 2.5, 4.0, 9.0})
        builderRow(rows, "way of a step [mm]", step_mm, {.step_m = 1e-3 * step_mm});
    builderRow(rows, "AVX2 and FMA (1) or not", 1, {});
    builderRow(rows, "AVX2 and FMA (1) or not", 0, {.portable = true});
    builderRow(rows, "only the body (1) or all", 0, {}, 1, true);
    builderRow(rows, "threads", 2, {}, 2);
    builderRow(rows, "deepest breath, table [mm]", 3, {}, 1, false, true);
    const Grid grid = render::deformTables(probe().usual, kNow).grid;
    for (const int squarings : {1, 3}) {
        render::DeformTables tables;
        tableRow(rows, "squarings instead", squarings,
                 std::to_string(grid.voxelCount()) + " nodes, one thread", probe().own,
                 [&]() -> const render::DeformTables& {
                     return tables = squaredTables(probe().usual, grid, squarings);
                 });
    }
    gpuRow(rows);
}
const Registration tables_registration("patient.breathing", runTables);
#endif

}  // namespace
}  // namespace stylet::bench
