#include "app/study/commands.h"

#include <chrono>
#include <cstdio>

#include "app/study/tables.h"

namespace stylet::study {

namespace fs = std::filesystem;

namespace {

class Clock {
  public:
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    }

  private:
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

// A file's pairs, one after another: at 1 mm a pair is 100 MB.
template <typename Work>
void forEachPair(const StudyOptions& o, const Work& work) {
    const StudyFile study = readStudyFile(o.study);
    std::optional<patient::TissueTable> table;
    if (study.tissue) table = patient::loadTissueDefaults(*study.tissue).tissues;
    for (const PairFiles& files : study.pairs) {
        const Pair pair = loadPair(files, o.labels, table ? &*table : nullptr);
        fs::create_directories(o.out / pair.name);
        work(pair, o.out / pair.name);
    }
}

std::vector<patient::PlannedPath> planInto(const StudyOptions& o, const Pair& pair, const fs::path& folder) {
    const Clock clock;
    PairPlan plan = planPair(pair, o.plan);
    const patient::PlanResult& r = plan.result;
    patient::savePaths({pair.reference_digest, patient::kPlannerVersion, r.paths}, folder / "paths.json");
    writePlanTable(folder / "plan.csv", plan);
    writePlanSummary(folder / "plan.json", plan);
    std::printf("%s: %zu paths of %zu pairs of skin and duct (%zu not walked), %.1f s\n", pair.name.c_str(),
                r.paths.size(), r.candidates, r.skipped, clock.seconds());
    return std::move(plan.result.paths);
}

std::vector<patient::PlannedPath> pathsOf(const StudyOptions& o, const Pair& pair, const fs::path& folder) {
    if (fs::exists(folder / "paths.json")) {
        patient::StoredPaths stored = patient::loadPaths(folder / "paths.json");
        if (stored.patient_digest == pair.reference_digest &&
            stored.planner_version == patient::kPlannerVersion)
            return std::move(stored.paths);
        std::printf("%s: %s is of another patient or planner\n", pair.name.c_str(),
                    (folder / "paths.json").c_str());
    }
    return planInto(o, pair, folder);
}

void print(const Summary& s) {
    std::printf(
        "%s: %zu paths, RMSE %.3f +- %.3f N (median %.3f, %.2f %% outliers), maximum %.2f +- %.2f N (median "
        "%.2f, %.2f %%), %.1f %% identical, borders %.2f mm, Hausdorff %.2f mm\n",
        s.name.c_str(), s.paths, s.rmse_n.mean, s.rmse_n.sigma, s.rmse_n.median,
        100.0 * s.rmse_n.outlier_share, s.max_n.mean, s.max_n.sigma, s.max_n.median,
        100.0 * s.max_n.outlier_share, 100.0 * s.equal_share.mean, 1e3 * s.mean_distance_m.mean,
        1e3 * s.hausdorff_m.mean);
}

}  // namespace

void runPlan(const StudyOptions& o) {
    forEachPair(o, [&](const Pair& pair, const fs::path& folder) { planInto(o, pair, folder); });
}

void runStudy(const StudyOptions& o) {
    std::vector<PairFindings> findings;
    forEachPair(o, [&](const Pair& pair, const fs::path& folder) {
        PairFindings f{pair.name, pair.reference_share, pathsOf(o, pair, folder), {}, {}};
        if (o.most_paths > 0 && f.paths.size() > o.most_paths) f.paths.resize(o.most_paths);
        const PreparedPair prepared(pair);
        const Clock clock;
        f.results = runPaths(prepared, f.paths, o.run);
        const double seconds = clock.seconds();
        f.summary = summarise(f.name, f.results);
        writePathTable(folder / "paths.csv", f);
        if (const std::size_t sampled = std::min(o.sampled_paths, f.paths.size()))
            writeSampleTable(folder / "samples.csv", prepared, std::span(f.paths).first(sampled),
                             o.run.steering);
        print(f.summary);
        std::printf("%s: forces and errors in %.3f s\n", pair.name.c_str(), seconds);
        findings.push_back(std::move(f));
    });
    writeSummary(o.out / "summary.json", findings, o.run, o.labels);
    std::vector<PathResult> all;
    for (const PairFindings& f : findings)
        all.insert(all.end(), f.results.begin(), f.results.end());
    print(summarise("all", all));
}

}  // namespace stylet::study
