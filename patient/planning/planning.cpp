// Based on Mastmeyer et al. 2017, Eq. 9, and Baegert et al. 2007 (strict and soft criteria on a ray set).
#include "patient/planning/planning.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "base/parallel.h"
#include "patient/planning/planning_bound.h"

namespace stylet::patient {
namespace {

struct Targets {
    std::vector<Vec3> reference_m, deformed_m;
};

// Finds the best target for one skin voxel after another. Neighbouring voxels have similar paths, so the
// previous best target is tried first. Of equally good targets the first in the list wins, whatever the order
// of trying.
class EntryPlanner {
  public:
    EntryPlanner(const Plan& plan, const Targets& targets)
        : plan_(plan),
          targets_(targets),
          evaluator_(plan),
          quality_bound_(plan),
          skips_(plan.settings.skip && isReferenceBreath(plan.patient, plan.settings.breath)) {}

    std::optional<PlannedPath> plan(const Vec3& entry_m, PlanResult& counts) {
        best_.reset();
        path_ = {};
        path_.breath = plan_.settings.breath;
        path_.entry_m = entry_m;
        path_.entry_reference_m =
            referenceFromDeformed(plan_.patient.package().motion, path_.breath, entry_m);
        const std::size_t first = best_target_;
        tryTarget(first, counts);
        for (std::size_t t = 0; t < targets_.deformed_m.size(); ++t)
            if (t != first) tryTarget(t, counts);
        return best_;
    }

  private:
    // C2 with a margin for rounding.
    bool isFarTooLong(std::size_t target) const {
        const double max_m = plan_.settings.max_length_m;
        const Vec3 to_target_m = targets_.deformed_m[target] - path_.entry_m;
        return glm::dot(to_target_m, to_target_m) > 1.01 * max_m * max_m;
    }
    bool cannotWin(std::size_t target) const {
        const double needed = best_ ? best_->quality : plan_.settings.min_quality;
        const double bound = quality_bound_.bound(path_, needed);
        return bound < needed || (best_ && bound == needed && target > best_target_);
    }
    void tryTarget(std::size_t target, PlanResult& counts) {
        if (skips_ && isFarTooLong(target)) {
            ++counts.rejected_long;
            return;
        }
        path_.target_m = targets_.deformed_m[target];
        path_.target_reference_m = targets_.reference_m[target];
        if (skips_ && cannotWin(target)) {
            ++counts.skipped;
            return;
        }
        const Verdict verdict = evaluator_.evaluate(path_);
        counts.rejected_blocked += verdict == Verdict::blocked;
        counts.rejected_long += verdict == Verdict::tooLong;
        counts.rejected_quality += verdict == Verdict::poor;
        if (verdict != Verdict::accepted) return;
        if (best_ && path_.quality == best_->quality ? target > best_target_
                                                     : best_ && path_.quality < best_->quality)
            return;
        best_ = path_;
        best_target_ = target;
    }

    const Plan& plan_;
    const Targets& targets_;
    PathEvaluator evaluator_;
    QualityBound quality_bound_;
    bool skips_;
    PlannedPath path_;
    std::optional<PlannedPath> best_;
    std::size_t best_target_ = 0;
};

// Entries at one height, their paths and counters.
struct PlanRow {
    std::size_t begin = 0, end = 0;
    PlanResult result;
};

std::vector<PlanRow> splitIntoRows(const std::vector<Vec3>& entries_m) {
    std::vector<PlanRow> rows;
    for (std::size_t e = 0; e < entries_m.size(); ++e) {
        if (e == 0 || entries_m[e].z != entries_m[e - 1].z) rows.push_back({e, e, {}});
        rows.back().end = e + 1;
    }
    return rows;
}

// A total order, because no two paths share an entry.
bool betterPath(const PlannedPath& a, const PlannedPath& b) {
    return std::tie(b.quality, a.length_m, a.entry_m.z, a.entry_m.y) <
           std::tie(a.quality, b.length_m, b.entry_m.z, b.entry_m.y);
}

}  // namespace

PlanSettings studyPlanSettings(const Patient& patient) {
    PlanSettings settings;
    settings.breath = patient.package().motion.reference;
    settings.skin_spacing_m = settings.target_spacing_m = 0.0;
    return settings;
}

PlanResult planPaths(const Patient& patient, const PlanSettings& settings,
                     const std::function<void(double)>& progress) {
    const MotionModel& motion = patient.package().motion;
    Targets targets{ductCentreLine(patient, settings.target_spacing_m), {}};
    if (targets.reference_m.empty()) return {};
    if (progress) progress(0.1);
    for (const Vec3& t : targets.reference_m)
        targets.deformed_m.push_back(deformedFromReference(motion, settings.breath, t));
    const PlanRegion region = makePlanRegion(patient, settings);
    const TissueMap map(patient);
    if (progress) progress(0.3);

    const Plan plan{patient, settings, region, map};
    std::vector<PlanRow> rows = splitIntoRows(region.entries_m);
    const auto planRow = [&](std::size_t r) {
        EntryPlanner planner(plan, targets);
        for (std::size_t e = rows[r].begin; e < rows[r].end; ++e)
            if (const auto best = planner.plan(region.entries_m[e], rows[r].result))
                rows[r].result.paths.push_back(*best);
    };
    parallelFor(settings.threads, rows.size(), planRow, [&](std::size_t done) {
        if (progress) progress(0.3 + 0.7 * double(done) / double(rows.size()));
    });

    PlanResult result;
    result.candidates = region.entries_m.size() * targets.deformed_m.size();
    for (const auto& [begin, end, row] : rows) {
        result.paths.insert(result.paths.end(), row.paths.begin(), row.paths.end());
        result.skipped += row.skipped;
        result.rejected_blocked += row.rejected_blocked;
        result.rejected_long += row.rejected_long;
        result.rejected_quality += row.rejected_quality;
    }
    std::sort(result.paths.begin(), result.paths.end(), betterPath);
    if (progress) progress(1.0);
    return result;
}

bool ratePath(const Patient& patient, const PlanSettings& settings, PlannedPath& path) {
    PlanSettings there = settings;
    there.breath = path.breath;
    path.clearance_score = path.target_score = path.quality = 0.0;
    const PlanRegion region = makePlanRegion(patient, there);
    const TissueMap map(patient);
    const Plan plan{patient, there, region, map};
    return PathEvaluator(plan).evaluate(path) == Verdict::accepted;
}

std::vector<double> worstQualities(const Patient& patient, const PlanSettings& settings,
                                   const std::vector<PlannedPath>& paths,
                                   const std::vector<Surrogate>& breaths) {
    constexpr std::size_t kBlock = 64;
    const MotionModel& motion = patient.package().motion;
    const TissueMap map(patient);
    std::vector<double> worst(paths.size(), 1.0);
    for (const Surrogate& breath : breaths) {
        PlanSettings there = settings;
        there.breath = breath;
        const PlanRegion region = makePlanRegion(patient, there);
        const Plan plan{patient, there, region, map};
        parallelFor(settings.threads, (paths.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
            PathEvaluator evaluator(plan);
            for (std::size_t i = block * kBlock; i < std::min(paths.size(), (block + 1) * kBlock); ++i) {
                PlannedPath path = paths[i];
                path.entry_m = deformedFromReference(motion, breath, path.entry_reference_m);
                path.target_m = deformedFromReference(motion, breath, path.target_reference_m);
                const bool kept = evaluator.evaluate(path) == Verdict::accepted;
                worst[i] = std::min(worst[i], kept ? path.quality : 0.0);
            }
        });
    }
    return worst;
}

}  // namespace stylet::patient
