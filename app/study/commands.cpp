#include "app/study/commands.h"

#include <fmt/core.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <mutex>

#include "app/study/facts.h"
#include "app/study/paths_picture.h"
#include "app/study/report.h"
#include "app/study/report_tables.h"
#include "app/study/result_blocks.h"
#include "app/study/tables.h"
#include "base/folder_linux.h"
#include "base/parallel.h"
#include "base/whole_file.h"

namespace stylet::study {

using patient::PlannedPath;

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

// A study file and its force table.
struct Study {
    explicit Study(const StudyOptions& options) : o(options), file(readStudyFile(o.study)) {
        if (file.tissue) table = patient::loadTissueDefaults(*file.tissue).tissues;
        // Fail early: before hours of planning, and before an earlier run's results are deleted.
        for (const PairFiles& pair : file.pairs)
            for (const fs::path& package : {pair.reference, pair.found})
                if (!fs::exists(package / "patient.toml"))
                    throw DataError(package / "patient.toml", "file", "cannot be read");
        requireFolder(o.out, "--out");
    }
    Pair load(std::size_t pair) const {
        Pair p = loadPair(file.pairs[pair], o.labels, table ? &*table : nullptr, o.accept_implausible);
        requireFolder(folder(pair), "--out");
        return p;
    }
    fs::path folder(std::size_t pair) const { return o.out / file.pairs[pair].name; }
    std::string ownTable() const { return file.tissue ? file.tissue->filename().string() : ""; }

    const StudyOptions& o;
    StudyFile file;
    std::optional<patient::TissueTable> table;
};

void savePicture(const fs::path& file, const Pair& pair, const std::vector<PlannedPath>& paths, int threads) {
    const patient::Patient reference(pair.reference);
    const std::vector<std::uint8_t> png =
        pathsPicture(patient::TissueMap(reference), paths, pair.name, threads);
    if (png.empty())
        fs::remove(file);
    else
        writeWholeFile(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

// Writes paths.json last, so that its existence shows that the other files exist. Deletes the summary, which
// belongs to the old paths.
void planAndWrite(const StudyOptions& o, const Pair& pair, const fs::path& folder) {
    const Clock::time_point begin = Clock::now();
    const PairPlan plan = planPair(pair, o.plan);
    const patient::PlanResult& r = plan.result;
    const double seconds = secondsSince(begin);
    if (r.paths.size() > patient::kMaxStoredPaths)
        throw DataError(
            folder / "paths.json", "paths",
            fmt::format("{} paths were found, but a file holds at most {}: plan with --skin-spacing-mm",
                        r.paths.size(), patient::kMaxStoredPaths));
    fs::remove(folder / "paths.json");
    fs::remove(o.out / "summary.json");
    writePlanTable(folder / "plan.csv", plan);
    writePlanSummary(folder / "plan.json", plan, o.plan, pair.implausible);
    savePicture(folder / "paths.png", pair, r.paths, o.plan.threads);
    patient::savePaths({pair.reference_digest, patient::kPlannerVersion, r.paths}, folder / "paths.json");
    std::printf("%s: %zu paths of %zu pairs of skin and duct (%zu not walked), %.1f s\n", pair.name.c_str(),
                r.paths.size(), r.candidates, r.skipped, seconds);
}

bool matchesRequest(const PlanRequest& request, const PlanFacts& plan) {
    constexpr double kSame_m = 1e-9;
    return std::fabs(plan.skin_spacing_m - request.skin_spacing_m) < kSame_m &&
           std::fabs(plan.target_spacing_m - request.target_spacing_m) < kSame_m &&
           plan.breaths == request.breaths;
}

bool isPlanned(const StudyOptions& o, const Pair& pair, const fs::path& folder) {
    const fs::path file = folder / "paths.json";
    if (!fs::exists(file) || !fs::exists(folder / "plan.json")) return false;
    const patient::StoredPaths stored = patient::loadPaths(file);
    const PlanFacts plan = readPlanFacts(folder / "plan.json");
    const char* other = nullptr;
    if (stored.patient_digest != pair.reference_digest || stored.planner_version != patient::kPlannerVersion)
        other = "patient or planner";
    else if (o.plan_is_explicit && !matchesRequest(o.plan, plan))
        other = "spacing or number of breaths";
    if (other)
        std::printf("%s: %s is of another %s\n", pair.name.c_str(), file.c_str(), other);
    else
        std::printf("%s: %zu paths, planned before with --skin-spacing-mm %g --target-spacing-mm %g\n",
                    pair.name.c_str(), stored.paths.size(), 1e3 * plan.skin_spacing_m,
                    1e3 * plan.target_spacing_m);
    return !other;
}

std::vector<PlannedPath> loadPlannedPaths(const StudyOptions& o, const fs::path& folder) {
    std::vector<PlannedPath> paths = patient::loadPaths(folder / "paths.json").paths;
    if (o.max_paths > 0 && paths.size() > o.max_paths) paths.resize(o.max_paths);
    return paths;
}

// Runs the blocks of this share that are not on disk yet and stores each one as soon as it is finished.
void runShare(const PreparedPair& pair, const std::vector<PlannedPath>& paths, const ResultBlocks& kept,
              const Share& share, const RunSettings& settings) {
    const Clock::time_point begin = Clock::now();
    std::vector<std::size_t> blocks;
    std::size_t own = 0;
    for (std::size_t block = share.part; block < kept.count(); block += share.parts, ++own)
        if (!kept.has(block)) blocks.push_back(block);
    std::mutex mutex;
    std::exception_ptr error;
    const auto failed = [&] {
        const std::lock_guard lock(mutex);
        return error != nullptr;
    };
    parallelFor(settings.threads, blocks.size(), [&](std::size_t i) {
        if (failed()) return;
        try {
            const std::size_t block = blocks[i];
            kept.write(block, runBlock(pair, std::span(paths).subspan(kept.begin(block), kept.size(block)),
                                       settings));
        } catch (...) {
            const std::lock_guard lock(mutex);
            error = std::current_exception();
        }
    });
    if (error) std::rethrow_exception(error);
    std::printf("%s: forces and errors in %.3f s", pair.pair.name.c_str(), secondsSince(begin));
    if (blocks.size() < own) std::printf(", %zu of %zu blocks were there", own - blocks.size(), own);
    std::printf("\n");
}

// The leader plans the paths and writes the pair's facts; the other ranks wait for it.
void runPair(const Study& study, const Share& share, const Ranks& ranks) {
    const StudyOptions& o = study.o;
    const Pair pair = study.load(share.pair);
    const fs::path folder = study.folder(share.pair);
    const bool leads = share.part == 0;
    if (leads && !isPlanned(o, pair, folder)) planAndWrite(o, pair, folder);
    const bool shared = std::size_t(ranks.size()) > study.file.pairs.size();
    if (shared) ranks.barrier();
    const std::vector<PlannedPath> paths = loadPlannedPaths(o, folder);
    const std::uint64_t digest = runDigest(pair, paths, o.run);
    if (leads) {
        fs::remove(folder / "samples.csv");
        PairFacts facts = makePairFacts(pair, study.ownTable());
        facts.run = digest;
        facts.paths = paths.size();
        writeFacts(folder / "pair.json", facts);
    }
    const PreparedPair prepared(pair);
    runShare(prepared, paths, ResultBlocks(folder / "blocks", digest, paths.size()), share, o.run);
    if (const std::size_t sampled = std::min(o.sampled_paths, paths.size()); leads && sampled > 0)
        writeSampleTable(folder / "samples.csv", prepared, std::span(paths).first(sampled), o.run.steering);
}

void print(const Summary& s) {
    if (s.paths == 0) {
        std::printf("%s: no path, nothing to compare\n", s.name.c_str());
        return;
    }
    const auto mean = [](const Spread& force_n, int digits) {
        const std::string text = fmt::format("{:.{}f}", force_n.mean, digits);
        return force_n.count > 1 ? text + fmt::format(" +- {:.{}f}", force_n.sigma, digits) : text;
    };
    std::printf(
        "%s: %zu paths, RMSE %s N (median %.3f, %.2f %% outliers), maximum %s N (median %.2f, %.2f %%), "
        "%.1f %% identical, borders %.2f mm, Hausdorff %.2f mm\n",
        s.name.c_str(), s.paths, mean(s.rmse_n, 3).c_str(), s.rmse_n.median, 100.0 * s.rmse_n.outlier_share,
        mean(s.max_n, 2).c_str(), s.max_n.median, 100.0 * s.max_n.outlier_share, 100.0 * s.equal_share.mean,
        1e3 * s.mean_distance_m.mean, 1e3 * s.hausdorff_m.mean);
}

// Writes the tables from the blocks of all ranks.
void writeStudyTables(const Study& study) {
    const StudyOptions& o = study.o;
    std::vector<PairFindings> findings;
    std::vector<PathResult> all;
    for (std::size_t pair = 0; pair < study.file.pairs.size(); ++pair) {
        const fs::path folder = study.folder(pair);
        const PairFacts facts = readFacts(folder / "pair.json");
        PairFindings f{study.file.pairs[pair].name,
                       facts.reference.labelled_share,
                       loadPlannedPaths(o, folder),
                       ResultBlocks(folder / "blocks", facts.run, facts.paths).all(),
                       {}};
        f.summary = summarise(f.name, f.results);
        writePathTable(folder / "paths.csv", f);
        print(f.summary);
        all.insert(all.end(), f.results.begin(), f.results.end());
        findings.push_back(std::move(f));
    }
    writeSummary(o.out / "summary.json", findings, o.run, o.labels);
    std::printf("compared: %s\n", comparedLabels(o.labels).c_str());
    print(summarise("all", all));
}

}  // namespace

void runPlan(const StudyOptions& o, const Ranks& ranks) {
    const Study study(o);
    for (const Share& share : assignShares(ranks.rank(), ranks.size(), study.file.pairs.size()))
        if (share.part == 0) planAndWrite(o, study.load(share.pair), study.folder(share.pair));
    ranks.barrier();
}

void runStudy(const StudyOptions& o, const Ranks& ranks) {
    const Study study(o);
    // A study with a summary is complete: start it from scratch.
    if (ranks.first() && fs::remove(o.out / "summary.json"))
        for (std::size_t pair = 0; pair < study.file.pairs.size(); ++pair)
            fs::remove_all(study.folder(pair) / "blocks");
    ranks.barrier();
    for (const Share& share : assignShares(ranks.rank(), ranks.size(), study.file.pairs.size()))
        runPair(study, share, ranks);
    ranks.barrier();
    if (ranks.first()) writeStudyTables(study);
}

fs::path writeReport(const fs::path& out) {
    const fs::path page = out / "report.html";
    writeWholeFile(page, studyPage(readStudy(out)));
    return page;
}

}  // namespace stylet::study
