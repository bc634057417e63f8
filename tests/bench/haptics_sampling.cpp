// Compares the sampled needle force with the exact force along straight paths. Between samples, the sampled
// force stays constant, as on a device.
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <fmt/core.h>

#include "haptics/haptics.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"
#include "tests/support/phantom.h"

namespace stylet::bench {
namespace {

using namespace haptics;
using Random = std::mt19937_64;

// Largest distance between samples in the study of Mastmeyer et al. 2017. It equals one tick at 90 mm/s.
constexpr double kStudySpacing_mm = 0.09;
// Force error [N] from which a hand may feel the approximation.
constexpr double kPerceptible_n = 0.145;

struct Path {
    Vec3 entry_m{0.0}, axis{0.0};
    double length_m = 0.0;
    ExactForce exact;
};

double uniform(Random& random, double low, double high) {
    return low + (high - low) * (double(random() >> 11) * 0x1p-53);
}

Path makePath(ExactSolver& solver, const Vec3& entry_m, const Vec3& end_m) {
    Path path;
    const Vec3 way = end_m - entry_m;
    path.length_m = std::sqrt(glm::dot(way, way));
    path.entry_m = entry_m;
    path.axis = way / path.length_m;
    path.exact = solver.solve(entry_m, end_m);
    return path;
}

// Paths at up to 40 degrees from the layers' normal. They start 8 mm before the skin.
std::vector<Path> slabPaths(const patient::Patient& patient, int count) {
    const patient::TissueMap map(patient);
    ExactSolver solver(map, {});
    Random random(1);
    std::vector<Path> paths;
    while (int(paths.size()) < count) {
        const double phi = uniform(random, 0.0, 6.283185307179586), tilt = uniform(random, 0.0, 0.7);
        const Vec3 axis{std::cos(tilt), std::sin(tilt) * std::cos(phi), std::sin(tilt) * std::sin(phi)};
        const Vec3 skin{0.0, uniform(random, -0.01, 0.01), uniform(random, -0.01, 0.01)};
        const Vec3 entry = skin - axis * 0.008;
        const Vec3 end = entry + axis * 0.088;
        // Use only paths that end within the slabs' width. Others would leave through the side.
        if (std::fabs(end.y) < test::kSlabHalfWidth_m * 0.98 &&
            std::fabs(end.z) < test::kSlabHalfWidth_m * 0.98) {
            paths.push_back(makePath(solver, entry, end));
        }
    }
    return paths;
}

// Paths of 90 mm from the air beside the right flank to random points in the liver.
std::vector<Path> patientPaths(const patient::Patient& patient, int count) {
    const patient::Package& package = patient.package();
    const Grid& grid = package.ct.grid;
    const patient::TissueMap map(patient);
    ExactSolver solver(map, {});
    Random random(2);
    std::vector<Vec3> liver;
    for (std::size_t i = 0; i < package.labels.voxels.size(); ++i) {
        const patient::Label* label = patient.label(package.labels.voxels[i]);
        if (!label || label->tissue != Tissue::liver) continue;
        liver.push_back(grid.centre(grid.voxelAt(i)));
    }
    std::vector<Path> paths;
    for (int tries = 0; int(paths.size()) < count && tries < 20000 && !liver.empty(); ++tries) {
        const Vec3 target = liver[random() % liver.size()];
        const Vec3 out{1.0, uniform(random, -0.6, 0.6), uniform(random, -0.4, 0.4)};
        const Vec3 away = out / std::sqrt(glm::dot(out, out));
        const Vec3 entry = target + away * 0.090;
        if (patient.at(entry, {}).tissue != Tissue::air) continue;
        Path path = makePath(solver, entry, target);
        // Skip paths that meet bone, because the study's paths avoid it. Pressing on bone only measures its
        // spring.
        const bool bone = std::any_of(path.exact.events.begin(), path.exact.events.end(),
                                      [](const ExactEvent& e) { return e.tissue == Tissue::bone; });
        if (!bone) paths.push_back(std::move(path));
    }
    return paths;
}

struct Errors {
    double squares_n2 = 0.0, max_n = 0.0,
           max_outside_n = 0.0;  // outside: more than one step away from every event
    double event_sum_m = 0.0,
           event_max_m = 0.0;  // sampled minus exact event depth; the maximum is of its magnitude
    std::size_t samples = 0, events = 0;
};

struct SampledEvent {
    double depth_m = 0.0;  // at the tick that reported the event
    NeedleEvent event;
};

struct Sampled {
    double step_m = 0.0, time_ms = 0.0;
    std::vector<double> forces_n;  // one per tick
    std::vector<SampledEvent> events;
    double end_m() const { return step_m * double(forces_n.size() - 1); }
};

// Moves the needle along the path in steps of step_m.
Sampled sampleForce(const patient::Patient& patient, const Path& path, double step_m) {
    const int steps = int(std::floor(path.length_m / step_m));
    Sampled sampled;
    sampled.step_m = step_m;
    sampled.forces_n.assign(std::size_t(steps) + 1, 0.0);
    sampled.events.reserve(2 * path.exact.events.size());
    NeedleState state;
    NeedleEvents events;
    const auto began = std::chrono::steady_clock::now();
    for (int i = 0; i <= steps; ++i) {
        const double depth_m = step_m * i;
        stepNeedle(state, {}, {patient, {}}, {path.entry_m + path.axis * depth_m, path.axis}, events);
        sampled.forces_n[std::size_t(i)] = state.force_n;
        if (events.dropped > 0) throw std::runtime_error("a step dropped events");
        for (int e = 0; e < events.count; ++e)
            sampled.events.push_back({depth_m, events.list[std::size_t(e)]});
    }
    sampled.time_ms = elapsed_ms(began);
    return sampled;
}

// Throws unless both solvers report the same events in the same order, up to the last tick.
void compareEvents(const Path& path, const Sampled& sampled, Errors& errors) {
    constexpr double kSameDepth_m = 1e-9;
    const std::vector<ExactEvent>& exact = path.exact.events;
    const auto fail = [&](std::size_t i, const char* what) {
        throw std::runtime_error("event " + std::to_string(i) + " at steps of " +
                                 std::to_string(1e3 * sampled.step_m) + " mm: " + what);
    };
    for (std::size_t i = 0; i < sampled.events.size(); ++i) {
        const auto& [depth_m, event] = sampled.events[i];
        if (i >= exact.size()) fail(i, "the exact solver has none");
        if (event.kind != exact[i].kind) fail(i, "the exact solver has another kind");
        if (event.border.to != exact[i].tissue) fail(i, "the exact solver enters another tissue");
        const double late_m = depth_m - exact[i].depth_m;
        errors.event_sum_m += late_m;
        errors.event_max_m = std::max(errors.event_max_m, std::fabs(late_m));
        ++errors.events;
    }
    const std::size_t next = sampled.events.size();
    if (next < exact.size() && exact[next].depth_m < sampled.end_m() - kSameDepth_m)
        fail(next, "the sampled solver has none");
}

void compareForces(const Path& path, const Sampled& sampled, Errors& errors) {
    constexpr double kResolution_m = 2e-6;
    const double step_m = sampled.step_m;
    const std::vector<ExactEvent>& events = path.exact.events;
    std::size_t event = 0;
    for (double x = 0.5 * kResolution_m; x < sampled.end_m(); x += kResolution_m) {
        while (event < events.size() && events[event].depth_m < x - step_m)
            ++event;
        const double e = std::fabs(sampled.forces_n[std::size_t(x / step_m)] - path.exact.at(x));
        const bool near = event < events.size() && events[event].depth_m <= x + step_m;
        errors.squares_n2 += e * e;
        errors.max_n = std::max(errors.max_n, e);
        if (!near) errors.max_outside_n = std::max(errors.max_outside_n, e);
        ++errors.samples;
    }
}

struct Measured {
    double step_mm = 0.0, time_ms = 0.0;
    Errors errors;
};

Measured measureStep(const patient::Patient& patient, const std::vector<Path>& paths, double step_mm) {
    Measured m{step_mm, 0.0, {}};
    std::vector<double> times_ms;
    for (const Path& path : paths) {
        const Sampled sampled = sampleForce(patient, path, 1e-3 * step_mm);
        times_ms.push_back(sampled.time_ms);
        compareEvents(path, sampled, m.errors);
        compareForces(path, sampled, m.errors);
    }
    m.time_ms = median(times_ms);
    return m;
}

void measure(const patient::Patient& patient, const std::vector<Path>& paths, const std::string& what,
             std::vector<Row>& rows) {
    std::vector<Measured> all;
    double largest_mm = 0.0;  // largest step whose error outside events is below kPerceptible_n
    for (const double step_mm : {0.005, 0.01, 0.02, 0.05, kStudySpacing_mm, 0.2, 0.5}) {
        all.push_back(measureStep(patient, paths, step_mm));
        if (all.back().errors.max_outside_n < kPerceptible_n) largest_mm = std::max(largest_mm, step_mm);
    }
    const std::string reference = "exact solver, " + std::to_string(paths.size()) + " paths, " + what;
    for (const auto& [step_mm, time_ms, e] : all) {
        std::string note = step_mm == kStudySpacing_mm ? "the study's spacing; " : "";
        if (step_mm == largest_mm)
            note += fmt::format("the largest of these below {:.3g} N away from events; ", kPerceptible_n);
        note += fmt::format("at an event at most {:.3g} N; time is per path", e.max_n);
        const auto add = [&](const char* metric, double error, const char* unit) {
            rows.push_back({std::string("haptics.sampling_step") + metric, "step [mm]", step_mm, time_ms,
                            error, unit, reference, metric[0] == '\0' ? note : ""});
        };
        add("", std::sqrt(e.squares_n2 / double(e.samples)), "N RMS");
        add(".max_outside_events", e.max_outside_n, "N");
        add(".event_depth_mean", 1e3 * e.event_sum_m / double(e.events), "mm");
        add(".event_depth_max", 1e3 * e.event_max_m, "mm");
    }
}

void run(std::vector<Row>& rows) {
    using enum Tissue;
    const patient::Package slabs = test::makeSlabs({{skin, 0.002},
                                                    {soft, 0.018},
                                                    {fascia, 0.001},
                                                    {liver, 0.020},
                                                    {duct, 0.004},
                                                    {liver, 0.010},
                                                    {vessel, 0.003},
                                                    {liver, 0.040}},
                                                   0.0005);
    const patient::Patient slab_patient(slabs);
    measure(slab_patient, slabPaths(slab_patient, 100), "slab stack", rows);

    const patient::Package package = referencePatient(0.002);
    const patient::Patient patient(package);
    measure(patient, patientPaths(patient, 100), "reference patient at 2 mm, between the ribs", rows);
}

const Registration registration("haptics.sampling_step", run);

}  // namespace
}  // namespace stylet::bench
