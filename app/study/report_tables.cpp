#include "app/study/report_tables.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/study/report_figures.h"

namespace stylet::study {

using patient::Tissue;
using report::fixed;
using report::Table;

namespace {

constexpr double kMm = 1e3;
constexpr std::size_t kMostCauses = 8, kMostPaths = 30;  // rows of a table

std::string eventText(haptics::NeedleEventKind kind) {
    using enum haptics::NeedleEventKind;
    switch (kind) {
        case border:
            return "held at its border";
        case puncture:
            return "its border is cut";
        case entry:
            return "entered without a hold";
        case sideways:
            return "met sideways";
        case withdrawn:
            return "left";
        case overflow:
            return "lost count";
    }
    return "?";
}

std::string spacingText(const PairFacts& f) {
    const patient::Vec3 mm = kMm * f.spacing_m;
    const auto one = [](double v) { return fixed(v, 2); };
    if (mm.x == mm.y && mm.y == mm.z) return one(mm.x) + " mm";
    return one(mm.x) + " x " + one(mm.y) + " x " + one(mm.z) + " mm";
}

bool isSynthetic(const PairFacts& f) {
    return std::any_of(f.reference.labels.begin(), f.reference.labels.end(),
                       [](const LabelFacts& l) { return l.provenance == "synthetic"; });
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& w : words)
        text += (text.empty() ? "" : ", ") + w;
    return text;
}

double share(std::size_t part, std::size_t whole) {
    return whole > 0 ? double(part) / double(whole) : kNone;
}

const TissueSummary* tissueOf(const Summary& s, Tissue t) {
    return std::size_t(t) < s.tissues.size() ? &s.tissues[std::size_t(t)] : nullptr;
}

std::string bordersText(const Summary& s, Spread TissueSummary::* number) {
    std::vector<std::string> words;
    for (const Tissue t : {Tissue::skin, Tissue::soft, Tissue::fascia, Tissue::liver, Tissue::duct})
        if (const TissueSummary* const tissue = tissueOf(s, t); tissue && (tissue->*number).count > 0)
            words.push_back(std::string(patient::tissueName(t)) + " " +
                            fixed(kMm * (tissue->*number).mean, 1));
    return words.empty() ? "–" : joined(words) + " mm";
}

std::string mediansText(const ReportedStudy& study) {
    double low = INFINITY, high = -INFINITY;
    for (const ReportedPair& p : study.pairs)
        if (p.summary.max_n.count > 0)
            low = std::min(low, p.summary.max_n.median), high = std::max(high, p.summary.max_n.median);
    return low <= high ? fixed(low, 2) + " to " + fixed(high, 2) + " N" : "–";
}

}  // namespace

std::string meanText(const Spread& s, double unit, int digits) {
    if (s.count == 0) return "–";
    return fixed(unit * s.mean, digits) + " ± " + fixed(unit * s.sigma, digits);
}

std::size_t syntheticCount(const ReportedStudy& study) {
    return std::size_t(std::count_if(study.pairs.begin(), study.pairs.end(),
                                     [](const ReportedPair& p) { return isSynthetic(p.facts); }));
}

// In which a path was found.
std::size_t steeredCount(const ReportedStudy& study) {
    return std::size_t(std::count_if(study.pairs.begin(), study.pairs.end(),
                                     [](const ReportedPair& p) { return p.summary.paths > 0; }));
}

// Every figure of the paper's "Results" and what has become of it here.
Table paperTable(const ReportedStudy& study) {
    const Summary &all = study.all, &clear = study.without_bone;
    const std::size_t made_up = syntheticCount(study), idle = study.pairs.size() - steeredCount(study);
    const auto both = [&](const Spread& s, const Spread& without, int digits) {
        return meanText(s, 1.0, digits) + " N (median " + fixed(s.median, digits) + "); " +
               meanText(without, 1.0, digits) + " N without bone";
    };
    Table t{"The paper's figures, this study's, and why they differ",
            {"Figure", "Paper", "Here", "Why they differ"},
            {},
            {},
            false};
    t.rows = {
        {"Paths", "31,222 (about 3,000 a patient)", countText(all.paths),
         "From every skin voxel of the access area that has a path of quality 0.4 or better: their number "
         "follows the voxels' size and the ducts' reach."},
        {"Patients", "10, clinical CT",
         std::to_string(study.pairs.size()) +
             (made_up ? ", of them " + std::to_string(made_up) + " synthetic" : "") +
             (idle ? ", " + std::to_string(idle) + " without a path" : ""),
         made_up
             ? "A synthetic patient's truth is exact; the paper's was drawn by experts. See the last section."
             : "Other patients."},
        {"RMSE of the force", "0.12 ± 0.04 N", both(all.rmse_n, clear.rmse_n, 3),
         "The paper's partial segmentations were made with an operator's help and reviewed; here nobody "
         "corrected the built patients. Where one patient alone has bone on the path its needle stands still "
         "at the largest force, and a few such paths carry the mean: the median, and the paths without bone, "
         "say what most feel like."},
        {"Top outliers of the RMSE", "0.05 %", percentText(all.rmse_n.outlier_share, 2),
         "Paths above mean + 2.7 standard deviations: a share of a skewed distribution, which grows with its "
         "tail."},
        {"Maximum error (the paper's MAE)", "0.65 ± 0.18 N", both(all.max_n, clear.max_n, 2),
         "A maximum does not shrink with the error of a border: an event a sample too early or late is worth "
         "what the force jumps there, 1.5 N at the fascia. The paper puts its systematic 0.7 N down to the "
         "skin, which its threshold meets a little before the drawn one."},
        {"Top outliers of the maximum", "3.73 %", percentText(all.max_n.outlier_share, 2), "As above."},
        {"Medians of the maximum, by patient", "0.7 N or less", mediansText(study), "As above."},
        {"Largest RMSE, box plots", "below 0.25 N",
         fixed(all.rmse_n.upper_whisker, 3) + " N (whisker), " + fixed(clear.rmse_n.most, 2) +
             " N (largest without bone)",
         "As above; a missed structure puts the forces out of step to the path's end."},
        {"Largest maximum error", "1.4 to 1.6 N, rare",
         fixed(all.max_n.upper_whisker, 2) + " N (whisker), " + fixed(clear.max_n.most, 2) +
             " N (largest without bone)",
         "The paper puts its largest down to tissues just above the fascia, from which the force before the "
         "puncture begins at another level; here the table of causes counts them."},
        {"Identical forces", "88 %",
         percentText(all.equal_share.mean) + " (median " + percentText(all.equal_share.median) + ")",
         "To the last bit, as in the paper (Eq. 11). Both models take one code path, so that equal tissues "
         "give equal bits."},
        {"Mean distance of borders (MSD)", "below 2 mm on average, skin best",
         bordersText(all, &TissueSummary::mean_distance_m),
         "The paper shows it as Fig. 4, without numbers. A border that only one patient has is missed or "
         "invented (table by tissue), not a distance."},
        {"Hausdorff distance of borders (HSD)",
         "above 3 mm at the liver, above 2 mm in soft tissue, below 2 mm at the bile ducts",
         bordersText(all, &TissueSummary::hausdorff_m),
         "The largest distance along a path, one stray voxel is enough; soft tissue begins and ends at every "
         "other border."},
        {"Errors nobody notices", "RMSE below 0.145 N for the most part",
         percentText(1.0 - all.rmse_noticed_share) + " of the paths",
         "0.145 N is 18.1 % of 0.8 N, the least change of force that the hand and arm tell apart."},
    };
    return t;
}

Table tissueTable(const ReportedStudy& study) {
    Table t{"By tissue, all patients",
            {"Tissue", "Mean distance, mm", "Hausdorff distance, mm", "Way in, error of depth, mm",
             "Way in, offset, mm", "Missed, paths", "Invented, paths", "Share of all squared error",
             "the same without bone"},
            {},
            {false, true, true, true, true, true, true, true, true},
            true};
    for (std::size_t i = 0; i < study.all.tissues.size(); ++i) {
        const TissueSummary& s = study.all.tissues[i];
        if (s.mean_distance_m.count == 0 && s.error_share == 0.0 && s.missed + s.invented == 0) continue;
        const bool also = i < study.without_bone.tissues.size();
        t.rows.push_back({std::string(patient::tissueName(s.tissue)), meanText(s.mean_distance_m, kMm, 2),
                          meanText(s.hausdorff_m, kMm, 2), meanText(s.event_error_m, kMm, 2),
                          fixed(kMm * s.event_offset_m, 2), countText(s.missed), countText(s.invented),
                          percentText(s.error_share),
                          percentText(also ? study.without_bone.tissues[i].error_share : kNone)});
    }
    return t;
}

Table causeTable(const std::string& caption, const std::vector<CauseCount>& causes) {
    Table t{caption,
            {"Tissue", "Event", "Whose", "Paths", "Share", "Median displacement, mm"},
            {},
            {false, false, false, true, true, true},
            false};
    std::size_t paths = 0;
    for (const CauseCount& c : causes)
        paths += c.paths;
    for (std::size_t i = 0; i < std::min(causes.size(), kMostCauses); ++i) {
        const CauseCount& c = causes[i];
        t.rows.push_back({std::string(patient::tissueName(c.cause.tissue)), eventText(c.cause.kind),
                          c.cause.model == Model::full ? "reference" : "built", countText(c.paths),
                          percentText(share(c.paths, paths)), fixed(kMm * c.cause.apart_m, 2)});
    }
    return t;
}

Table largestTable(const ReportedStudy& study) {
    Table t{
        "The largest errors of paths that meet no bone, and what caused each; \"path\" is its row in "
        "paths.csv",
        {"Patient", "Path", "Maximum error, N", "at depth, mm", "RMSE, N", "Tissue", "Event", "Whose",
         "Displacement, mm"},
        {},
        {false, true, true, true, true, false, false, false, true},
        true};
    struct Row {
        const ReportedPair* pair;
        std::size_t path;
        const PathResult* result;
    };
    std::vector<Row> rows;
    for (const ReportedPair& pair : study.pairs)
        for (std::size_t i = 0; i < pair.results.size(); ++i)
            if (const PathResult& r = pair.results[i]; !r.meets_bone && r.sampled.max_n > 0.0)
                rows.push_back({&pair, i, &r});
    const std::size_t count = std::min(rows.size(), kMostPaths);
    std::partial_sort(rows.begin(), rows.begin() + std::ptrdiff_t(count), rows.end(),
                      [](const Row& a, const Row& b) {
                          if (a.result->sampled.max_n != b.result->sampled.max_n)
                              return a.result->sampled.max_n > b.result->sampled.max_n;
                          return std::pair(a.pair, a.path) < std::pair(b.pair, b.path);
                      });
    rows.resize(count);
    for (const Row& row : rows) {
        const ForceError& e = row.result->sampled;
        const Cause& c = row.result->cause;
        const bool caused = c.model != Model::neither;
        t.rows.push_back({row.pair->name, std::to_string(row.path), fixed(e.max_n, 2),
                          fixed(kMm * e.max_at_m, 1), fixed(e.rmse_n, 3),
                          caused ? std::string(patient::tissueName(c.tissue)) : "–",
                          caused ? eventText(c.kind) : "–",
                          c.model == Model::full      ? "reference"
                          : c.model == Model::partial ? "built"
                                                      : "–",
                          fixed(kMm * c.apart_m, 2)});
    }
    return t;
}

Table patientTable(const ReportedStudy& study) {
    Table t{"By patient; \"no bone\": of the paths that meet none",
            {"Patient", "Paths", "Meet bone", "RMSE, N: median", "no bone", "Maximum, N: median", "no bone",
             "Identical", "Events in order", "RMSE below 0.145 N"},
            {},
            {false, true, true, true, true, true, true, true, true, true},
            true};
    forAll(study, [&](const std::string& name, const Summary& s, const Summary& clear) {
        const double some = s.paths > 0 ? 1.0 : kNone;
        t.rows.push_back({name, countText(s.paths), percentText(share(s.bone_paths, s.paths)),
                          fixed(s.rmse_n.median, 3), meanText(clear.rmse_n, 1.0, 3), fixed(s.max_n.median, 2),
                          meanText(clear.max_n, 1.0, 2), percentText(s.equal_share.mean),
                          percentText(some * s.same_order_share), percentText(some - s.rmse_noticed_share)});
    });
    return t;
}

Table borderTable(const ReportedStudy& study) {
    Table t{"Borders of all tissues, by patient",
            {"Patient", "Mean surface distance, mm", "below 2 mm", "Hausdorff distance, mm", "below 3 mm"},
            {},
            {false, true, true, true, true},
            true};
    forAll(study, [&](const std::string& name, const Summary& s, const Summary&) {
        const double some = s.paths > 0 ? 1.0 : kNone;
        t.rows.push_back({name, meanText(s.mean_distance_m, kMm, 2),
                          percentText(some - s.distance_noticed_share), meanText(s.hausdorff_m, kMm, 2),
                          percentText(some - s.hausdorff_noticed_share)});
    });
    return t;
}

Table planTable(const ReportedStudy& study) {
    Table t{"What the planner looked at, in pairs of a skin voxel and a voxel of a duct's centre line",
            {"Patient", "Pairs", "Not walked: could not win", "Blocked (C1)", "Beyond 90 mm (C2)",
             "Quality below 0.4", "Kept: best of a skin voxel"},
            {},
            {false, true, true, true, true, true, true},
            false};
    for (const ReportedPair& p : study.pairs)
        t.rows.push_back({p.name, countText(p.plan.candidates), countText(p.plan.skipped),
                          countText(p.plan.blocked), countText(p.plan.too_long), countText(p.plan.poor),
                          countText(p.plan.kept)});
    return t;
}

Table labelTable(const ReportedStudy& study) {
    Table t{"What each patient is made of",
            {"Patient", "Voxels of", "Body labelled in the reference", "Labels of the reference", "made by",
             "Labels of the built patient that count", "made by"},
            {},
            {false, false, true, false, false, false, false},
            false};
    const auto names = [](const PackageFacts& p) {
        std::vector<std::string> words;
        for (const LabelFacts& l : p.labels)
            if (l.counts) words.push_back(l.name);
        return words.empty() ? std::string("none") : joined(words);
    };
    const auto makers = [](const PackageFacts& p) {
        std::vector<std::string> words;
        for (const LabelFacts& l : p.labels)
            if (l.counts && std::find(words.begin(), words.end(), l.provenance) == words.end())
                words.push_back(l.provenance);
        return joined(words);
    };
    for (const ReportedPair& p : study.pairs)
        t.rows.push_back({p.name, spacingText(p.facts), percentText(p.facts.reference.labelled_share),
                          names(p.facts.reference), makers(p.facts.reference), names(p.facts.found),
                          makers(p.facts.found)});
    return t;
}

Table thresholdTable(const ReportedStudy& study) {
    Table t{"Thresholds in HU, reference / built",
            {"Patient", "Skin (t0)", "Fat and soft tissue (t1)", "Bone before the fascia (t2-)",
             "Bone behind it (t2+)"},
            {},
            {false, true, true, true, true},
            false};
    for (const ReportedPair& p : study.pairs) {
        const patient::Thresholds &a = p.facts.reference.thresholds, &b = p.facts.found.thresholds;
        const auto both = [](double x, double y) { return fixed(x, 0) + " / " + fixed(y, 0); };
        t.rows.push_back({p.name, both(a.t0_hu, b.t0_hu), both(a.t1_hu, b.t1_hu),
                          both(a.t2_sensitive_hu, b.t2_sensitive_hu),
                          both(a.t2_specific_hu, b.t2_specific_hu)});
    }
    return t;
}

Table forceTable(const PairFacts& f, const std::string& caption) {
    Table t{caption,
            {"Tissue", "Cut at T, N", "Friction R, N", "Stiffness k, N/mm"},
            {},
            {false, true, true, true},
            false};
    for (std::size_t i = 0; i < f.tissues.size(); ++i) {
        const patient::TissueRow& row = f.tissues[i];
        t.rows.push_back({std::string(patient::tissueName(Tissue(i))), fixed(row.cut_force_n, 2),
                          fixed(row.friction_n, 2), fixed(1e-3 * row.stiffness_n_per_m, 2)});
    }
    return t;
}

}  // namespace stylet::study
