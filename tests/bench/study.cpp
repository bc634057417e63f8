// The paper's study on one reference patient, at 1 mm with 31,222 paths unless a row says otherwise. Measures
// planning, sampled forces and forces in closed form.
#include <cmath>
#include <fstream>

#include <fmt/core.h>

#include "app/study/commands.h"
#include "app/study/facts.h"
#include "app/study/result_blocks.h"
#include "base/parallel.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"
#include "tests/support/temp_folder.h"

namespace stylet::bench {
namespace {

using namespace study;

constexpr std::size_t kPaths = 31'222;  // as in the paper

// Pairs the reference patient with a copy whose labels are shifted by one voxel toward the feet. A real
// segmentation may well place its borders wrong by this much.
Pair makeShiftedPair(double spacing_m) {
    patient::Package truth = referencePatient(spacing_m), found = truth;
    const std::size_t slab = std::size_t(truth.ct.grid.dims.x) * std::size_t(truth.ct.grid.dims.y);
    std::copy(truth.labels.voxels.begin() + std::ptrdiff_t(slab), truth.labels.voxels.end(),
              found.labels.voxels.begin());
    for (patient::Label& label : found.label_table)
        label.provenance = "moved";
    found.name = "moved";
    return makePair({"made", "truth", "found"}, std::move(truth), std::move(found), FoundLabels::partial);
}

struct StudyInput {
    const Pair pair = makeShiftedPair(0.001);
    const PreparedPair prepared{pair};
    std::vector<patient::PlannedPath> paths;  // kPaths paths; planned paths are repeated to fill it

    StudyInput() {
        const std::vector<patient::PlannedPath> planned = planPair(pair).result.paths;
        while (paths.size() < kPaths)
            paths.push_back(planned[paths.size() % planned.size()]);
    }
};

const StudyInput& studyInput() {
    static const StudyInput all;
    return all;
}

// Returns the path quality lost by planning from a coarser set of skin voxels or targets. It is averaged
// over the skin voxels that the coarser set contains.
double lostQuality(const std::vector<patient::PlannedPath>& all,
                   const std::vector<patient::PlannedPath>& coarse) {
    double lost = 0.0;
    std::size_t count = 0;
    for (const patient::PlannedPath& c : coarse)
        for (const patient::PlannedPath& a : all)
            if (a.entry_m == c.entry_m) lost += a.quality - c.quality, ++count;
    return count > 0 ? lost / double(count) : 0.0;
}

void runPlanning(std::vector<Row>& rows) {
    const Pair& pair = studyInput().pair;
    const std::vector<patient::PlannedPath> all = planPair(pair).result.paths;
    for (const bool skip : {true, false})
        for (const double spacing_mm : {0.0, 2.0, 4.0, 8.0}) {
            if (!skip && spacing_mm > 0.0) continue;
            PlanRequest request;
            request.skip = skip;
            request.skin_spacing_m = request.target_spacing_m = 1e-3 * spacing_mm;
            const auto began = std::chrono::steady_clock::now();
            const patient::PlanResult r = planPair(pair, request).result;
            const double time_ms = elapsed_ms(began);
            const std::string note =
                fmt::format("{} paths of {:.1f} million pairs, {:.1f} million not walked", r.paths.size(),
                            1e-6 * double(r.candidates), 1e-6 * double(r.skipped));
            rows.push_back({skip ? "study.planning" : "study.planning.no_skips",
                            "spacing of skin and targets [mm]", spacing_mm, time_ms,
                            lostQuality(all, r.paths), "quality lost", "every voxel against every voxel",
                            note});
        }
}

void runBreaths(std::vector<Row>& rows) {
    const Pair pair = makeShiftedPair(0.002);
    PlanRequest request;
    request.skin_spacing_m = 0.008;
    std::vector<double> finest;
    for (const int breaths : {20, 10, 5}) {
        request.breaths = breaths;
        const auto began = std::chrono::steady_clock::now();
        const PairPlan plan = planPair(pair, request);
        const double time_ms = elapsed_ms(began);
        if (finest.empty()) finest = plan.worst_quality;
        double worst = 0.0;
        for (std::size_t i = 0; i < finest.size(); ++i)
            worst += plan.worst_quality[i] - finest[i];
        rows.push_back({"study.planning.breaths", "phases of a breath", double(breaths), time_ms,
                        worst / double(finest.size()), "quality too good", "20 phases",
                        "reference patient at 2 mm"});
    }
}

// Steers all paths through both models. Returns a sum of the forces so that the compiler cannot remove the
// work.
double steerAll(const SteeringSettings& settings) {
    const std::size_t blocks = (kPaths + kBlock - 1) / kBlock;
    std::vector<double> sums(blocks);
    parallelFor(2, blocks, [&](std::size_t block) {
        Steering steering(studyInput().prepared, settings);
        for (std::size_t i = block * kBlock; i < std::min(kPaths, (block + 1) * kBlock); ++i)
            if (const SteeringResult* s = steering.steer(studyInput().paths[i]))
                sums[block] += s->full.samples_n.back() - s->partial.samples_n.back();
    });
    double sum = 0.0;
    for (const double s : sums)
        sum += s;
    return sum;
}

double steeringTime_ms(const SteeringSettings& settings) {
    return medianTime_ms(3, [&] {
        if (std::isnan(steerAll(settings))) throw std::runtime_error("a force is no number");
    });
}

// Returns how many times longer 1 kHz steering would take, at one second per path and model.
double speedupOverSteering(double time_ms) {
    return 2.0 * double(kPaths) / (1e-3 * time_ms);
}

void steerRow(const SteeringSettings& settings, std::vector<Row>& rows) {
    const double time_ms = steeringTime_ms(settings);
    RunSettings measured;
    measured.steering = settings;
    double rmse_off_n = 0.0, max_off_n = 0.0;
    const std::vector<PathResult> results =
        runPaths(studyInput().prepared, std::span(studyInput().paths).first(kPaths / 10), measured);
    for (const PathResult& r : results) {
        rmse_off_n += std::fabs(r.sampled.rmse_n - r.exact.rmse_n) / double(results.size());
        max_off_n += std::fabs(r.sampled.max_n - r.exact.max_n) / double(results.size());
    }
    const std::string note = fmt::format(
        "31,222 paths, both models, two threads; {:.0f} times 1 kHz steering; maximum {:.3f} N off",
        speedupOverSteering(time_ms), max_off_n);
    rows.push_back({"study.forces", "samples a path", double(settings.samples), time_ms, rmse_off_n,
                    "N of RMSE", "closed form", note});
}

void runForces(std::vector<Row>& rows) {
    for (const int samples : {250, 500, 1000, 2000, 8000}) {
        SteeringSettings settings;
        settings.samples = samples;
        settings.max_spacing_m = 1.0;
        steerRow(settings, rows);
    }
}

// Compares the closed form with stepNeedle at steps of 1 um. For each of about 25 paths it finds the
// largest force difference [N], ignoring depths near events. Returns the median over the paths: a few paths
// run through corners of voxels, where the two methods may meet different voxels.
double differenceFromSteps_n() {
    constexpr double kStep_m = 1e-6, kBeside_m = 5e-6;
    const SteeringSettings settings;
    Steering steering(studyInput().prepared, settings);
    std::vector<double> largest_n;
    for (std::size_t p = 0; p < studyInput().paths.size(); p += studyInput().paths.size() / 25) {
        const patient::PlannedPath& path = studyInput().paths[p];
        const SteeringResult* s = steering.steer(path);
        if (!s) continue;
        const Vec3 axis = glm::normalize(path.target_m - path.entry_m);
        haptics::NeedleState needle;
        haptics::NeedleEvents events;
        double worst_n = 0.0;
        for (std::size_t i = 0; double(i) * kStep_m < s->end_m; ++i) {
            const double depth_m = double(i) * kStep_m;
            haptics::stepNeedle(needle, settings.needle, {studyInput().prepared.full, path.breath},
                                {path.entry_m + (depth_m - s->entry_m) * axis, axis}, events);
            const auto& met = s->full.force->events;
            if (std::none_of(met.begin(), met.end(), [&](const haptics::ExactEvent& e) {
                    return std::fabs(e.depth_m - depth_m) < kBeside_m;
                }))
                worst_n = std::max(worst_n, std::fabs(needle.force_n - s->full.force->at(depth_m)));
        }
        largest_n.push_back(worst_n);
    }
    return median(largest_n);
}

void runExact(std::vector<Row>& rows) {
    SteeringSettings settings;
    settings.samples = 1;
    settings.max_spacing_m = 1.0;
    const double time_ms = steeringTime_ms(settings);
    const std::string note = fmt::format(
        "31,222 paths, both models, two threads; {:.0f} times 1 kHz steering", speedupOverSteering(time_ms));
    rows.push_back({"study.exact", "samples a path", 0.0, time_ms, differenceFromSteps_n(), "N",
                    "stepNeedle by 1 um", note});
}

// sampleForce in single precision, to measure its cost. It evaluates every sample and lacks the shortcut for
// pieces of constant force, so its time is not a fair comparison.
void sampleSingle(const haptics::ExactForce& force, float first_m, float step_m, std::span<float> force_n) {
    std::size_t i = 0;
    for (const haptics::ForcePiece& p : force.pieces) {
        const bool is_last = &p == &force.pieces.back();
        const auto begin_m = float(p.begin_m), end_m = float(p.end_m);
        const auto c0 = float(p.c0_n), c1 = float(p.c1_n_per_m), c2 = float(p.c2_n_per_m2);
        for (; i < force_n.size(); ++i) {
            const float depth_m = first_m + float(i) * step_m;
            if (!is_last && !(depth_m < end_m)) break;
            const float x = std::clamp(depth_m, begin_m, end_m) - begin_m;
            force_n[i] = (c2 * x + c1) * x + c0;
        }
    }
    std::fill(force_n.begin() + std::ptrdiff_t(i), force_n.end(), 0.0F);
}

// The two forces of a path in closed form, and the depths of their samples.
struct Sampled {
    haptics::ExactForce full, partial;
    double first_m = 0.0, step_m = 0.0;
    std::size_t count = 0;
};

template <typename Real, typename Sample>
double sampledRmse(const Sampled& s, std::vector<Real>& full_n, std::vector<Real>& partial_n,
                   const Sample& sample) {
    full_n.resize(s.count);
    partial_n.resize(s.count);
    sample(s.full, Real(s.first_m), Real(s.step_m), std::span(full_n));
    sample(s.partial, Real(s.first_m), Real(s.step_m), std::span(partial_n));
    Real sum_n2 = 0;
    for (std::size_t i = 0; i < s.count; ++i)
        sum_n2 += (full_n[i] - partial_n[i]) * (full_n[i] - partial_n[i]);
    return std::sqrt(double(sum_n2) / double(s.count));
}

void runPrecision(std::vector<Row>& rows) {
    constexpr std::size_t kSome = kPaths / 10;
    std::vector<Sampled> paths;
    Steering steering(studyInput().prepared, {});
    for (std::size_t i = 0; i < kSome; ++i)
        if (const SteeringResult* s = steering.steer(studyInput().paths[i]))
            paths.push_back(
                {*s->full.force, *s->partial.force, s->first_m, s->step_m, s->full.samples_n.size()});
    std::vector<double> exact;
    const auto row = [&]<typename Real>(Real, const auto& sample) {
        std::vector<Real> full_n, partial_n;
        std::vector<double> found(paths.size());
        const double time_ms = medianTime_ms(5, [&] {
            for (std::size_t i = 0; i < paths.size(); ++i)
                found[i] = sampledRmse<Real>(paths[i], full_n, partial_n, sample);
        });
        if (exact.empty()) exact = found;
        double worst_n = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i)
            worst_n = std::max(worst_n, std::fabs(found[i] - exact[i]));
        const std::string note =
            fmt::format("sampling and RMSE alone, {} paths, both models, one thread{}", paths.size(),
                        sizeof(Real) < sizeof(double) ? "; no shortcut over level pieces" : "");
        rows.push_back({"study.forces.precision", "bits of a number", 8.0 * sizeof(Real), time_ms, worst_n,
                        "N of RMSE, the worst path", "double", note});
    };
    row(double(), haptics::sampleForce);
    row(float(), sampleSingle);
}

// Runs the whole study on ten patients, from loading the packages to writing the report. Plans from every
// skin voxel and from fewer.
void runAll(std::vector<Row>& rows) {
    const test::TempFolder folder;
    patient::savePackage(studyInput().pair.reference, folder / "truth");
    patient::savePackage(studyInput().pair.found, folder / "built");
    std::ofstream file(folder / "study.toml");
    for (int patient = 1; patient <= 10; ++patient)
        file << "[[pair]]\nname = 'patient " << patient << "'\nreference = 'truth'\nfound = 'built'\n";
    file.close();
    double all_n = kNone;
    for (const double skin_mm : {0.0, 2.0, 4.0}) {
        StudyOptions o;
        o.study = folder / "study.toml";
        o.out = folder / std::to_string(int(skin_mm));
        o.plan.skin_spacing_m = 1e-3 * skin_mm;
        const auto began = std::chrono::steady_clock::now();
        runStudy(o);
        writeReport(o.out);
        const double time_ms = elapsed_ms(began);
        std::size_t paths = 0;
        double rmse_n = 0.0;
        for (int patient = 1; patient <= 10; ++patient) {
            const std::filesystem::path pair = o.out / ("patient " + std::to_string(patient));
            const PairFacts facts = readFacts(pair / "pair.json");
            for (const PathResult& r : ResultBlocks(pair / "blocks", facts.run, facts.paths).all())
                rmse_n += r.sampled.rmse_n;
            paths += facts.paths;
        }
        rmse_n /= double(paths);
        if (std::isnan(all_n)) all_n = rmse_n;
        rows.push_back({"study.all", "spacing of skin voxels [mm]", skin_mm, time_ms,
                        std::fabs(rmse_n - all_n), "N of RMSE", "every skin voxel",
                        "ten patients at 1 mm, from packages to the page, " + std::to_string(paths) +
                            " paths, two threads"});
    }
}

const Registration planning("study.planning", runPlanning);
const Registration breaths("study.planning.breaths", runBreaths);
const Registration forces("study.forces", runForces);
const Registration exact("study.exact", runExact);
const Registration precision("study.forces.precision", runPrecision);
const Registration all("study.all", runAll);

}  // namespace
}  // namespace stylet::bench
