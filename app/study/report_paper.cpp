#include "app/study/report_paper.h"

#include <algorithm>
#include <cmath>

#include "app/study/report_figures.h"
#include "app/study/report_tables.h"

namespace stylet::study {

using patient::Tissue;
using report::fixed;
using report::Table;

namespace {

constexpr double kClose = 0.1;              // C3 of a path that almost touches a risk structure
constexpr double kNegligibleShare = 0.005;  // smaller shares would round to 0 %, or their complement to 100 %
constexpr double kNearTop = 0.8;  // errors of at least this share of the fascia's force jump are counted
constexpr double kSmallest_mm = 0.775, kLargest_mm = 1.0;  // the paper's voxel sizes

struct Range {
    double low = INFINITY, high = -INFINITY;
    void add(double v) { low = std::min(low, v), high = std::max(high, v); }
    bool any() const { return low <= high; }
    // "146 to 152"
    std::string text(int digits) const {
        const std::string a = fixed(low, digits), b = fixed(high, digits);
        return a == b ? a : a + " to " + b;
    }
};

// Calls use(pair, path index) for each path.
template <typename Use>
void forEachPath(const ReportedStudy& study, const Use& use) {
    for (const ReportedPair& p : study.pairs)
        for (std::size_t i = 0; i < p.results.size(); ++i)
            use(p, i);
}

bool anyBone(const ReportedStudy& study) {
    return study.all.bone_paths > 0;
}

// Text about the paths that meet no bone. Empty if no path meets bone.
std::string withoutBone(const ReportedStudy& study, const std::string& text) {
    return anyBone(study) ? "; " + text + " without bone" : "";
}

const TissueSummary* tissueOf(const Summary& s, Tissue t) {
    return std::size_t(t) < s.tissues.size() ? &s.tissues[std::size_t(t)] : nullptr;
}

constexpr Tissue kBorders[] = {Tissue::skin, Tissue::soft, Tissue::fascia, Tissue::liver, Tissue::duct};

// "skin 0.7 (missed on 64 %), soft 1.4 mm"
std::string bordersText(const Summary& s, Spread TissueSummary::* number, bool missed) {
    std::vector<std::string> words;
    for (const Tissue t : kBorders) {
        const TissueSummary* const tissue = tissueOf(s, t);
        if (!tissue || (tissue->*number).count == 0) continue;
        words.push_back(std::string(patient::tissueName(t)) + " " + fixed(kMm * (tissue->*number).mean, 1));
        if (const double lost = share(tissue->missed, s.paths); missed && lost > kNegligibleShare)
            words.back() += " (missed on " + percentText(lost, 0) + ")";
    }
    return words.empty() ? "–" : joined(words) + " mm";
}

std::string causeText(const Cause& c) {
    return std::string(patient::tissueName(c.tissue)) + " " + eventText(c.kind);
}

// ---- why

std::string explainPaths(const ReportedStudy& study) {
    return "From " + voxelsText(study, &PlanFacts::skin_spacing_m, "skin voxel") +
           " in the access area: of each the best path, if its quality is " +
           numberText(patient::PlanSettings().min_quality) +
           " or better. Their number follows the voxels and the ducts' reach.";
}

std::string explainPatients(const ReportedStudy& study) {
    Range voxel_mm;
    for (const ReportedPair& p : study.pairs)
        for (const double edge_m : {p.facts.spacing_m.x, p.facts.spacing_m.y, p.facts.spacing_m.z})
            voxel_mm.add(kMm * edge_m);
    return std::string(syntheticCount(study) > 0 ? "A synthetic patient's truth is exact; the paper's was "
                                                   "drawn by experts. See the last section."
                                                 : "Other patients.") +
           " Voxels of " + voxel_mm.text(2) + " mm; the paper's " + fixed(kSmallest_mm, 3) + " to " +
           numberText(kLargest_mm) + " mm.";
}

// The bone thresholds of the patients with paths that meet bone, and of the other patients.
std::string boneThresholds(const ReportedStudy& study) {
    Range built, reference, others, others_reference;
    bool lower = true;
    for (const ReportedPair& p : study.pairs) {
        if (p.summary.paths == 0) continue;
        const double found_hu = p.facts.found.thresholds.t2_sensitive_hu;
        const double true_hu = p.facts.reference.thresholds.t2_sensitive_hu;
        if (p.summary.bone_paths > 0)
            built.add(found_hu), reference.add(true_hu), lower = lower && found_hu < true_hu;
        else
            others.add(found_hu), others_reference.add(true_hu), lower = lower && found_hu >= true_hu;
    }
    std::string text =
        " In these patients the built t2- is " + built.text(0) + " HU (reference " + reference.text(0) + ")";
    if (others.any())
        text += ", where no path meets bone " + others.text(0) + " HU (reference " +
                others_reference.text(0) + ")";
    return text + (lower ? ": probably the threshold is too low." : ".");
}

std::string explainBone(const ReportedStudy& study) {
    if (!anyBone(study)) return "As in the paper.";
    std::size_t close = 0, close_bone = 0;
    forEachPath(study, [&](const ReportedPair& p, std::size_t i) {
        if (i >= p.clearance.size() || !(p.clearance[i] < kClose)) return;
        ++close, close_bone += p.results[i].meets_bone;
    });
    const std::string least = numberText(patient::PlanSettings().min_quality);
    std::string text =
        "Bone, where one patient alone has it, stops the needle, and the error lasts to the path's end.";
    if (study.run.labels == FoundLabels::partial) text += boneThresholds(study);
    if (close > 0)
        text += " " + percentText(share(close_bone, study.all.bone_paths), 0) +
                " of the paths that meet bone have C3 below " + numberText(kClose) + ", and " +
                percentText(share(close_bone, close), 0) + " of all paths with C3 below " +
                numberText(kClose) + " meet bone. The paper says that Q below " + least +
                " removes them; a duct that is wide (C4) keeps them.";
    return text;
}

// The share of the mean RMSE that comes from the paths that meet bone.
std::string boneShareText(const ReportedStudy& study) {
    if (!anyBone(study)) return "";
    double all_n = 0.0, bone_n = 0.0;
    forEachPath(study, [&](const ReportedPair& p, std::size_t i) {
        const PathResult& r = p.results[i];
        all_n += r.sampled.rmse_n, bone_n += r.meets_bone ? r.sampled.rmse_n : 0.0;
    });
    return " Paths that meet bone make up " + percentText(bone_n / all_n, 0) + " of the mean.";
}

std::string explainOutliers(const ReportedStudy& study, Spread Summary::* number,
                            double ForceError::* value) {
    const double limit = (study.all.*number).outlier_limit;
    std::size_t outliers = 0, bone = 0;
    forEachPath(study, [&](const ReportedPair& p, std::size_t i) {
        if (!(p.results[i].sampled.*value > limit)) return;
        ++outliers, bone += p.results[i].meets_bone;
    });
    return bone > 0 ? percentText(share(bone, outliers), 0) + " of those above 2.7 σ meet bone." : "";
}

std::string outlierText(const ReportedStudy& study, Spread Summary::* number) {
    const auto both = [&](double Spread::* part, const char* without) {
        return percentText((study.all.*number).*part, 2) +
               (anyBone(study) ? without + percentText((study.without_bone.*number).*part, 2) + ")" : "");
    };
    return both(&Spread::outlier_share, " (without bone ") + "; above the whiskers " +
           both(&Spread::above_whisker_share, " (");
}

// The force jump when one needle is about to puncture the fascia and the other is still before it. Returns
// none if the patients' tables differ.
double fasciaJump(const ReportedStudy& study) {
    const patient::TissueTable& table = study.pairs.front().facts.tissues;
    for (const ReportedPair& p : study.pairs)
        if (p.facts.tissues != table) return kNone;
    return table[std::size_t(Tissue::fascia)].cut_force_n - table[std::size_t(Tissue::soft)].friction_n;
}

std::string explainMaximum(const ReportedStudy& study) {
    const Summary& clear = study.without_bone;
    if (clear.causes.empty()) return "";
    Cause top = clear.causes.front().cause;
    const auto of = [&](const auto& is) {
        std::size_t paths = 0;
        for (const CauseCount& c : clear.causes)
            if (is(c.cause)) paths += c.paths;
        return percentText(share(paths, clear.paths), 0);
    };
    std::string text = "Most often the cause is: " + causeText(top) + " (" +
                       of([&](const Cause& c) { return c.tissue == top.tissue && c.kind == top.kind; }) +
                       " of the paths" + (anyBone(study) ? " without bone" : "") + ").";
    const double jump_n = fasciaJump(study);
    const TissueSummary* const fascia = tissueOf(clear, Tissue::fascia);
    if (top.tissue == Tissue::fascia && fascia && fascia->event_error_m.count > 0) {
        text += " The fascia's depth is " + fixed(kMm * fascia->event_error_m.mean, 2) + " mm off on average";
        if (jump_n > 0.0) {
            std::size_t near = 0;
            forEachPath(study, [&](const ReportedPair& p, std::size_t i) {
                const PathResult& r = p.results[i];
                near += !r.meets_bone && r.sampled.max_n >= kNearTop * jump_n;
            });
            const patient::TissueTable& table = study.pairs.front().facts.tissues;
            text += ": one needle is about to cut it at " +
                    numberText(table[std::size_t(Tissue::fascia)].cut_force_n) +
                    " N while the other is still at the " +
                    numberText(table[std::size_t(Tissue::soft)].friction_n) + " N of soft tissue. " +
                    percentText(share(near, clear.paths), 0) + " of these paths come to " +
                    percentText(kNearTop, 0) + " or more of these " + numberText(jump_n) + " N";
        }
        text += ".";
    }
    return text + " The paper puts its systematic 0.7 N down to the skin.";
}

std::string largestIsBoneText(const ReportedStudy& study, Spread Summary::* number) {
    return (study.all.*number).max > (study.without_bone.*number).max ? " The largest of all is bone's." : "";
}

std::string explainLargest(const ReportedStudy& study) {
    const ReportedPair* pair = nullptr;
    std::size_t path = 0;
    double most_n = 0.0;
    forEachPath(study, [&](const ReportedPair& p, std::size_t i) {
        const PathResult& r = p.results[i];
        if (!r.meets_bone && r.sampled.max_n > most_n) most_n = r.sampled.max_n, pair = &p, path = i;
    });
    std::string text =
        "The paper puts its largest down to tissues just above the fascia, from which the force before the "
        "puncture begins at another level.";
    if (pair && pair->results[path].cause.model != Model::neither)
        text += " Here the cause of the largest" + std::string(anyBone(study) ? " without bone" : "") +
                " is: " + causeText(pair->results[path].cause) + ".";
    return text + largestIsBoneText(study, &Summary::max_n);
}

std::string explainSkin(const ReportedStudy& study) {
    const TissueSummary* best = nullptr;
    for (const Tissue t : kBorders)
        if (const TissueSummary* const tissue = tissueOf(study.all, t);
            tissue && tissue->mean_distance_m.count > 0 &&
            (!best || tissue->mean_distance_m.mean < best->mean_distance_m.mean))
            best = tissue;
    std::string text = "The paper shows it as Fig. 4, without numbers.";
    if (best && best->tissue != Tissue::skin)
        text += " Best here: " + std::string(patient::tissueName(best->tissue)) + ".";
    text += " A border that only one patient has is missed or invented, not a distance.";
    const TissueSummary* const skin = tissueOf(study.all, Tissue::skin);
    if (study.run.labels == FoundLabels::partial && skin &&
        share(skin->missed, study.all.paths) > kNegligibleShare)
        text +=
            " The built patient's skin is what the thresholds t0 to t1 take for it: little more than the rim "
            "of partial volume at the air.";
    return text;
}

std::string orderText(const ReportedStudy& study) {
    Range percent;
    for (const ReportedPair& p : study.pairs)
        if (p.summary.paths > 0) percent.add(100.0 * p.summary.same_order_share);
    return percentText(study.all.same_order_share) + " of the paths (by patient " + percent.text(1) +
           " %); " + percentText(study.all.same_order_inside_share) + " without skin, " +
           percentText(study.all.same_order_noticeable_share) +
           " but for layers of soft tissue, liver or duct under 2 mm";
}

std::string explainOrder(const ReportedStudy& study) {
    constexpr double kAlmostAll = 0.98, kMost = 0.9;
    const double differ = 1.0 - study.all.same_order_share,
                 noticed = 1.0 - study.all.same_order_noticeable_share;
    std::string text = "The paper calls its largest errors irrelevant as long as the order is the same.";
    if (study.all.same_order_noticeable_share < kAlmostAll)
        text += " Here it is not, so that argument does not apply.";
    else if (differ > kNegligibleShare && differ - noticed > kMost * differ)
        text += " Here almost all differences are layers too thin to notice.";
    if (study.all.same_order_inside_share > study.all.same_order_share + kNegligibleShare)
        text += " Without skin: as if neither patient had one, because a missed skin changes the order too.";
    return text;
}

std::string explainNoticeable(const ReportedStudy& study) {
    const double above = study.all.rmse_noticed_share;
    return "0.145 N is 18.1 % of 0.8 N, the least change of force that the hand and arm tell apart." +
           (above > 0.5 ? " Here " + percentText(above) + " of the paths are above it" +
                              withoutBone(study, percentText(study.without_bone.rmse_noticed_share)) +
                              ": this contradicts the paper."
                        : "");
}

std::string meansText(const ReportedStudy& study) {
    std::vector<Summary> all, clear;
    for (const ReportedPair& p : study.pairs)
        all.push_back(p.summary), clear.push_back(p.without_bone);
    const Cohort of_all = computeCohort(all), of_clear = computeCohort(clear);
    return "RMSE " + meanText(of_all.rmse_n, 1.0, 3) + " N" +
           withoutBone(study, meanText(of_clear.rmse_n, 1.0, 3) + " N") + ". Maximum " +
           meanText(of_all.max_n, 1.0, 2) + " N" +
           withoutBone(study, meanText(of_clear.max_n, 1.0, 2) + " N");
}

std::string mediansText(const ReportedStudy& study) {
    Range medians;
    for (const ReportedPair& p : study.pairs)
        if (p.summary.max_n.count > 0) medians.add(p.summary.max_n.median);
    return medians.any() ? medians.text(2) + " N" : "–";
}

}  // namespace

Table paperTable(const ReportedStudy& study) {
    const Summary &all = study.all, &clear = study.without_bone;
    const std::size_t synthetic = syntheticCount(study), idle = study.pairs.size() - steeredCount(study);
    const auto both = [&](Spread Summary::* number, int digits) {
        return meanText(all.*number, 1.0, digits) + " N (median " + fixed((all.*number).median, digits) +
               ")" + withoutBone(study, meanText(clear.*number, 1.0, digits) + " N");
    };
    const auto largest = [&](Spread Summary::* number, int digits) {
        const std::string whisker = fixed((all.*number).upper_whisker, digits) + " N (whisker), ";
        return whisker +
               (anyBone(study) ? fixed((clear.*number).max, digits) + " N (largest without bone), " : "") +
               fixed((all.*number).max, digits) + " N (largest)";
    };
    Table t{resultCaption("The paper's figures, this study's, and why they differ", study),
            {"Figure", "Paper", "Here", "Why they differ"},
            {},
            {},
            false};
    t.rows = {
        {"Paths", "31,222 (about 3,000 a patient)", countText(all.paths), explainPaths(study)},
        {"Patients", "10, clinical CT",
         std::to_string(study.pairs.size()) +
             (synthetic ? ", of them " + std::to_string(synthetic) + " synthetic" : "") +
             (idle ? ", " + std::to_string(idle) + " without a path" : ""),
         explainPatients(study)},
        {"Paths that meet bone", "none",
         countText(all.bone_paths) + " (" + percentText(share(all.bone_paths, all.paths)) + ")",
         explainBone(study)},
        {"RMSE of the force", "0.12 ± 0.04 N", both(&Summary::rmse_n, 3),
         "The paper's partial segmentations were made with an operator's help and reviewed; here nobody "
         "corrected the built patients' borders." +
             boneShareText(study)},
        {"Maximum error (the paper's MAE)", "0.65 ± 0.18 N", both(&Summary::max_n, 2), explainMaximum(study)},
        {"Means of the patients ± between them", "not given", meansText(study),
         "Every patient with the same weight; ± elsewhere is the spread over paths."},
        {"Top outliers of the RMSE", "0.05 %", outlierText(study, &Summary::rmse_n),
         "Shares above mean + 2.7 standard deviations. The paper may mean the whiskers of its box plots: 1.5 "
         "boxes are about 2.7 σ where values are normal. " +
             explainOutliers(study, &Summary::rmse_n, &ForceError::rmse_n)},
        {"Top outliers of the maximum", "3.73 %", outlierText(study, &Summary::max_n),
         "As above. " + explainOutliers(study, &Summary::max_n, &ForceError::max_n)},
        {"Medians of the maximum, by patient", "0.7 N or less", mediansText(study),
         "As for the maximum error."},
        {"Largest RMSE, box plots", "below 0.25 N", largest(&Summary::rmse_n, 3),
         "As for the RMSE." + largestIsBoneText(study, &Summary::rmse_n)},
        {"Largest maximum error", "1.4 to 1.6 N, rare", largest(&Summary::max_n, 2), explainLargest(study)},
        {"Events in the same order", "guaranteed, it says", orderText(study), explainOrder(study)},
        {"Identical forces", "88 %",
         percentText(all.equal_share.mean) + " (median " + percentText(all.equal_share.median) + ")",
         "To the last bit, as in the paper (Eq. 11). Both models take one code path, so that equal tissues "
         "give equal bits."},
        {"Mean distance of borders (MSD)", "below 2 mm on average, skin best",
         bordersText(all, &TissueSummary::mean_distance_m, true), explainSkin(study)},
        {"Hausdorff distance of borders (HSD)",
         "above 3 mm at the liver, above 2 mm in soft tissue, below 2 mm at the bile ducts",
         bordersText(all, &TissueSummary::hausdorff_m, false),
         "The largest distance along a path, one stray voxel is enough; soft tissue begins and ends at every "
         "other border. Missed borders as above."},
        {"Errors below the noticeable difference", "RMSE below 0.145 N for the most part",
         percentText(1.0 - all.rmse_noticed_share) + " of the paths", explainNoticeable(study)},
    };
    return t;
}

}  // namespace stylet::study
