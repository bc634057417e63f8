#include "app/study/report_tables.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/study/report_figures.h"
#include "base/text.h"

namespace stylet::study {

using patient::Tissue;
using report::fixed;
using report::Table;

namespace {

constexpr std::size_t kMaxCauses = 8, kMaxListedPaths = 30;  // maximum rows of a table

// In the order of the enumerators.
constexpr std::array<std::string_view, 6> kEventTexts{"tenting at its border",
                                                      "its border is cut",
                                                      "entered without tenting",
                                                      "met sideways",
                                                      "left",
                                                      "lost count"};
constexpr std::array<std::string_view, 3> kModelTexts{"reference", "built", "–"};

std::string spacingText(const PairFacts& f) {
    const Vec3 mm = kMm * f.spacing_m;
    if (mm.x == mm.y && mm.y == mm.z) return fixed(mm.x, 2) + " mm";
    return fmt::format("{} x {} x {} mm", fixed(mm.x, 2), fixed(mm.y, 2), fixed(mm.z, 2));
}

}  // namespace

std::string eventText(haptics::NeedleEventKind kind) {
    return std::string(enumName(kEventTexts, kind));
}

std::string comparedLabels(FoundLabels labels) {
    return labels == FoundLabels::all ? "all labels, as in training"
                                      : "fascia, liver, vessels and ducts, as in the paper's Algorithm 1";
}

std::string resultCaption(const std::string& text, const ReportedStudy& study) {
    return text + "; compared: " + comparedLabels(study.run.labels);
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

std::string numberText(double value, int max_digits) {
    std::string text = fixed(value, max_digits);
    text.erase(text.find_last_not_of('0') + 1);
    if (!text.empty() && text.back() == '.') text.pop_back();
    return text;
}

std::string voxelsText(const ReportedStudy& study, double PlanFacts::* spacing_m, const std::string& kind) {
    const double first_m = study.pairs.empty() ? 0.0 : study.pairs.front().plan.*spacing_m;
    if (std::any_of(study.pairs.begin(), study.pairs.end(),
                    [&](const ReportedPair& p) { return p.plan.*spacing_m != first_m; }))
        return kind + "s (of some patients every one, of some thinned)";
    return first_m > 0.0 ? kind + "s " + numberText(kMm * first_m) + " mm apart" : "every " + kind;
}

std::string meanText(const Spread& s, double unit, int digits) {
    if (s.count == 0) return "–";
    const std::string mean = fixed(unit * s.mean, digits);
    return s.count > 1 ? mean + " ± " + fixed(unit * s.sigma, digits) : mean;
}

std::size_t syntheticCount(const ReportedStudy& study) {
    return std::size_t(std::count_if(study.pairs.begin(), study.pairs.end(),
                                     [](const ReportedPair& p) { return isSynthetic(p.facts); }));
}

std::size_t steeredCount(const ReportedStudy& study) {
    return std::size_t(std::count_if(study.pairs.begin(), study.pairs.end(),
                                     [](const ReportedPair& p) { return p.summary.paths > 0; }));
}

Table tissueTable(const ReportedStudy& study) {
    Table t{resultCaption("By tissue, all patients", study),
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
    for (std::size_t i = 0; i < std::min(causes.size(), kMaxCauses); ++i) {
        const CauseCount& c = causes[i];
        t.rows.push_back({std::string(patient::tissueName(c.cause.tissue)), eventText(c.cause.kind),
                          std::string(enumName(kModelTexts, c.cause.model)), countText(c.paths),
                          percentText(share(c.paths, paths)), fixed(kMm * c.cause.offset_m, 2)});
    }
    return t;
}

Table largestTable(const ReportedStudy& study) {
    Table t{
        resultCaption("The largest errors of paths that meet no bone, and what caused each; \"path\" is its "
                      "row in paths.csv",
                      study),
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
    const std::size_t count = std::min(rows.size(), kMaxListedPaths);
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
                          caused ? eventText(c.kind) : "–", std::string(enumName(kModelTexts, c.model)),
                          fixed(kMm * c.offset_m, 2)});
    }
    return t;
}

Table patientTable(const ReportedStudy& study) {
    Table t{resultCaption("By patient; \"no bone\": of the paths that meet none", study),
            {"Patient", "Paths", "Meet bone", "RMSE, N: median", "no bone", "Maximum, N: median", "no bone",
             "Identical", "Events in order", "but for thin layers", "RMSE below 0.145 N"},
            {},
            {false, true, true, true, true, true, true, true, true, true, true},
            true};
    forEachSummary(study, [&](const std::string& name, const Summary& s, const Summary& clear) {
        const double some = s.paths > 0 ? 1.0 : kNone;
        t.rows.push_back(
            {name, countText(s.paths), percentText(share(s.bone_paths, s.paths)), fixed(s.rmse_n.median, 3),
             meanText(clear.rmse_n, 1.0, 3), fixed(s.max_n.median, 2), meanText(clear.max_n, 1.0, 2),
             percentText(s.equal_share.mean), percentText(some * s.same_order_share),
             percentText(some * s.same_order_noticeable_share), percentText(some - s.rmse_noticed_share)});
    });
    return t;
}

Table borderTable(const ReportedStudy& study) {
    Table t{resultCaption("Borders of all tissues, by patient", study),
            {"Patient", "Mean surface distance, mm", "below 2 mm", "Hausdorff distance, mm", "below 3 mm",
             "Paths that miss a border", "that have one too many"},
            {},
            {false, true, true, true, true, true, true},
            true};
    forEachSummary(study, [&](const std::string& name, const Summary& s, const Summary&) {
        // Share among the paths that have a distance.
        const auto below = [&](double above_share, const Spread& distance_m) {
            return percentText(1.0 - above_share * double(s.paths) / double(distance_m.count));
        };
        t.rows.push_back(
            {name, meanText(s.mean_distance_m, kMm, 2), below(s.distance_noticed_share, s.mean_distance_m),
             meanText(s.hausdorff_m, kMm, 2), below(s.hausdorff_noticed_share, s.hausdorff_m),
             percentText(share(s.missed_paths, s.paths)), percentText(share(s.invented_paths, s.paths))});
    });
    return t;
}

Table planTable(const ReportedStudy& study) {
    Table t{
        "What the planner looked at, in pairs of a skin voxel and a voxel of a duct's centre line",
        {"Patient", "Skin voxels", "Duct voxels", "Phases of a breath", "Pairs", "Not walked: could not win",
         "Blocked (C1)", "Too long (C2)", "Quality too low", "Kept: best of a skin voxel"},
        {},
        {false, false, false, true, true, true, true, true, true, true},
        false};
    const auto apart = [](double spacing_m) {
        return spacing_m > 0.0 ? numberText(kMm * spacing_m) + " mm apart" : "every one";
    };
    for (const ReportedPair& p : study.pairs)
        t.rows.push_back({p.name, apart(p.plan.skin_spacing_m), apart(p.plan.target_spacing_m),
                          p.plan.breaths > 0 ? std::to_string(p.plan.breaths) : "not rated",
                          countText(p.plan.candidates), countText(p.plan.skipped), countText(p.plan.blocked),
                          countText(p.plan.too_long), countText(p.plan.poor), countText(p.plan.kept)});
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
