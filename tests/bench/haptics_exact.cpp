// Exact solver: number of 90 mm paths per second, solved from border to border, on one and on two threads.
// The reference patient has 1 mm voxels.
#include <cmath>
#include <ctime>
#include <random>
#include <thread>

#include <fmt/core.h>

#include "base/traversal.h"
#include "haptics/haptics.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"

namespace stylet::bench {
namespace {

using namespace haptics;

constexpr double kLength_m = 0.090;
constexpr int kPaths = 200'000;

struct StudyPath {
    Vec3 entry_m, end_m;
};

// Returns the paths in the order of a study: for each entry on the right flank, all targets in sequence.
std::vector<StudyPath> makeStudyPaths(const patient::Patient& patient) {
    std::mt19937_64 random(3);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * (double(random() >> 11) * 0x1p-53);
    };
    const Grid& grid = patient.grid();
    const Vec3 middle = grid.centre(grid.dims / 2);
    std::vector<StudyPath> paths;
    while (int(paths.size()) < kPaths) {
        // Start beside the right flank and move inward to the skin.
        Vec3 entry =
            middle + Vec3(0.5 * grid.spacing_m.x * grid.dims.x, uniform(-0.06, 0.06), uniform(-0.06, 0.06));
        while (patient.at(entry, {}).tissue == Tissue::air && entry.x > middle.x)
            entry.x -= 0.0005;
        entry.x += 0.005;
        for (int target = 0; target < 100; ++target) {
            const Vec3 in{-1.0, uniform(-0.6, 0.6), uniform(-0.5, 0.5)};
            paths.push_back({entry, entry + in * (kLength_m / std::sqrt(glm::dot(in, in)))});
        }
    }
    return paths;
}

struct SolveResult {
    double time_ms = 0.0;
    double sum_n = 0.0;  // sum of the forces at the path ends, so that the compiler cannot remove the work
    std::size_t segments = 0, events = 0;
};

SolveResult solveAll(const patient::TissueMap& map, const std::vector<StudyPath>& paths, int threads) {
    std::vector<SolveResult> parts(static_cast<std::size_t>(threads));
    const auto began = std::chrono::steady_clock::now();
    std::vector<std::thread> workers;
    for (int t = 0; t < threads; ++t) {
        workers.emplace_back([&, t] {
            ExactSolver solver(map, {});
            SolveResult part;
            const std::size_t from = paths.size() * std::size_t(t) / std::size_t(threads);
            const std::size_t to = paths.size() * (std::size_t(t) + 1) / std::size_t(threads);
            for (std::size_t i = from; i < to; ++i) {
                const ExactForce& force = solver.solve(paths[i].entry_m, paths[i].end_m);
                part.sum_n += force.at(kLength_m);
                part.events += force.events.size();
            }
            parts[std::size_t(t)] = part;
        });
    }
    for (std::thread& worker : workers)
        worker.join();
    SolveResult all;
    all.time_ms = elapsed_ms(began);
    for (const SolveResult& part : parts) {
        all.sum_n += part.sum_n;
        all.events += part.events;
    }
    return all;
}

// Returns the largest force difference [N] between the solver and the rules evaluated voxel by voxel.
// Samples the path every 0.1 mm.
double differenceFromAlgorithm1(const patient::Patient& patient, const patient::TissueMap& map,
                                const std::vector<StudyPath>& paths) {
    ExactSolver solver(map, {});
    double worst_n = 0.0;
    for (std::size_t i = 0; i < paths.size(); i += 200) {
        std::vector<Segment> segments;
        patient::TrackFlags flags;
        const Vec3 line = paths[i].end_m - paths[i].entry_m;
        const double length_m = std::sqrt(glm::dot(line, line));
        for (VoxelWalk walk(patient.grid(), paths[i].entry_m, paths[i].end_m); !walk.done(); walk.next()) {
            const patient::TissueSample x = patient.at(walk.voxel(), flags);
            flags = patient.flagsAfterEntering(x, flags);
            segments.push_back({walk.begin() * length_m, x.tissue, x.label});
        }
        const ExactForce reference = solveExact(patient.package().tissues, segments, length_m, {});
        const ExactForce& force = solver.solve(paths[i].entry_m, paths[i].end_m);
        for (double x_m = 0.0; x_m <= length_m; x_m += 0.0001)
            worst_n = std::max(worst_n, std::fabs(force.at(x_m) - reference.at(x_m)));
    }
    return worst_n;
}

void run(std::vector<Row>& rows) {
    const patient::Package package = referencePatient(0.001);
    const patient::Patient patient(package);
    const auto began = std::chrono::steady_clock::now();
    const patient::TissueMap map(patient);
    const double map_ms = elapsed_ms(began);
    const std::vector<StudyPath> paths = makeStudyPaths(patient);
    const double error_n = differenceFromAlgorithm1(patient, map, paths);

    VoxelPath path;
    std::vector<Segment> segments;
    const auto walk_began = std::chrono::steady_clock::now();
    std::size_t met = 0;
    for (const StudyPath& line : paths) {
        segmentsAlong(map, line.entry_m, line.end_m, path, segments);
        met += segments.size();
    }
    const double walk_ms = elapsed_ms(walk_began);

    for (const int threads : {1, 2}) {
        std::vector<double> times_ms;
        std::vector<double> busy_us;  // CPU time per path; other load on the machine does not count
        SolveResult solved;
        for (int run = 0; run < 5; ++run) {
            const std::clock_t from = std::clock();
            solved = solveAll(map, paths, threads);
            times_ms.push_back(solved.time_ms);
            busy_us.push_back(1e6 * double(std::clock() - from) / CLOCKS_PER_SEC / kPaths);
        }
        const double median_ms = median(times_ms);
        const std::string note = fmt::format(
            "{:.2f} million paths/s; {:.2f} us of a core a path; {:.1f} tissues and {:.1f} events a path; "
            "the walk alone {:.2f} us of one thread; map made in {:.0f} ms",
            kPaths / median_ms * 1e-3, median(busy_us), double(met) / kPaths, double(solved.events) / kPaths,
            1e3 * walk_ms / kPaths, map_ms);
        rows.push_back({"haptics.exact_solver", "threads", double(threads), median_ms / kPaths, error_n,
                        "N max", "the rules voxel by voxel; 90 mm paths, reference patient at 1 mm", note});
    }
}

const Registration registration("haptics.exact_solver", run);

}  // namespace
}  // namespace stylet::bench
