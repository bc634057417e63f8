#include "app/study/report.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "app/study/kept.h"
#include "app/study/paths_picture.h"
#include "app/study/report_figures.h"

namespace stylet::study {

using patient::Tissue;
using report::fixed;
using report::Page;
using report::Table;

namespace fs = std::filesystem;

namespace {

constexpr double kMm = 1e3;
constexpr std::size_t kMostCauses = 8;  // rows of a table

// ---- from disk

Summary summariseWithoutBone(const std::string& name, std::vector<PathResult> results) {
    std::erase_if(results, [](const PathResult& r) { return r.meets_bone; });
    return summarise(name, results);
}

std::vector<std::uint8_t> bytesOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// ---- words

std::string meanText(const Spread& s, double unit, int digits) {
    if (s.count == 0) return "–";
    return fixed(unit * s.mean, digits) + " ± " + fixed(unit * s.sigma, digits);
}

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

std::size_t syntheticCount(const ReportedStudy& study) {
    return std::size_t(std::count_if(study.pairs.begin(), study.pairs.end(),
                                     [](const ReportedPair& p) { return isSynthetic(p.facts); }));
}

// In which a path was found.
std::size_t steeredCount(const ReportedStudy& study) {
    return std::size_t(std::count_if(study.pairs.begin(), study.pairs.end(),
                                     [](const ReportedPair& p) { return p.summary.paths > 0; }));
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

// ---- the paper

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

// ---- tables

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

Table patientTable(const ReportedStudy& study) {
    Table t{
        "By patient; \"no bone\": of the paths that meet none; MSD, HSD: mean surface and Hausdorff distance "
        "of the borders",
        {"Patient", "Paths", "Meet bone", "RMSE, N: median", "no bone", "Maximum, N: median", "no bone",
         "Identical", "Events in order", "RMSE below 0.145 N", "MSD below 2 mm", "HSD below 3 mm"},
        {},
        {false, true, true, true, true, true, true, true, true, true, true, true},
        true};
    const auto add = [&](const std::string& name, const Summary& s, const Summary& clear) {
        const double some = s.paths > 0 ? 1.0 : kNone;
        t.rows.push_back({name, countText(s.paths), percentText(share(s.bone_paths, s.paths)),
                          fixed(s.rmse_n.median, 3), meanText(clear.rmse_n, 1.0, 3), fixed(s.max_n.median, 2),
                          meanText(clear.max_n, 1.0, 2), percentText(s.equal_share.mean),
                          percentText(some * s.same_order_share), percentText(some - s.rmse_noticed_share),
                          percentText(some - s.distance_noticed_share),
                          percentText(some - s.hausdorff_noticed_share)});
    };
    add("all", study.all, study.without_bone);
    for (const ReportedPair& p : study.pairs)
        add(p.name, p.summary, p.without_bone);
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

// ---- sections

void addHeadlines(Page& page, const ReportedStudy& study) {
    const Summary& s = study.all;
    page.headlines(
        {{countText(s.paths), "paths in " + std::to_string(steeredCount(study)) + " patients"},
         {fixed(s.rmse_n.median, 3) + " N", "RMSE of the median path"},
         {meanText(study.without_bone.rmse_n, 1.0, 3) + " N", "RMSE of the paths that meet no bone"},
         {fixed(s.max_n.median, 2) + " N", "maximum error of the median path"},
         {percentText(s.equal_share.mean), "of the forces are identical"},
         {fixed(kMm * s.mean_distance_m.mean, 2) + " mm", "mean distance of the borders"}});
}

std::string beyondText(const Plot& plot) {
    return plot.beyond == 0
               ? ""
               : " " + countText(plot.beyond) + " values lie above the axis; the table has the largest.";
}

void addBoxes(Page& page, const ReportedStudy& study) {
    page.section("Force errors");
    page.paragraph(
        "Each box holds the middle half of a patient's paths, with a bar at the median and whiskers to the "
        "last values within one and a half boxes; dots are paths beyond. Dashed: what a hand just notices.");
    const std::string boxes = "Box plots, one a patient and one of all.";
    Plot plot = boxPlot(study, {"RMSE of a path, N",
                                3,
                                1.0,
                                [](const Summary& s) -> const Spread& { return s.rmse_n; },
                                [](const PathResult& r) { return r.sampled.rmse_n; },
                                {kNoticedForce_n}});
    page.figure(plot.figure, boxes + " Root mean squared force error of the paths.",
                "RMSE per path, as Fig. 6 of the paper." + beyondText(plot), plot.numbers);
    plot = boxPlot(study, {"maximum error of a path, N",
                           2,
                           1.0,
                           [](const Summary& s) -> const Spread& { return s.max_n; },
                           [](const PathResult& r) { return r.sampled.max_n; },
                           {kNoticedForce_n}});
    page.figure(plot.figure, boxes + " Maximum absolute force error of the paths.",
                "Maximum absolute error per path, as Fig. 7 of the paper (its \"MAE\")." + beyondText(plot),
                plot.numbers);
    plot = boxPlot(study, {"identical forces of a path, %", 1, 100.0,
                           [](const Summary& s) -> const Spread& { return s.equal_share; },
                           [](const PathResult& r) { return r.sampled.equal_share; }});
    plot.figure.y.max = 100.0;
    page.figure(plot.figure, boxes + " Share of bit-equal forces of the paths.",
                "Share of samples whose forces are equal to the last bit, as Fig. 8 of the paper.",
                plot.numbers);
    page.table(patientTable(study));
}

void addBorders(Page& page, const ReportedStudy& study) {
    page.section("Borders");
    page.paragraph(
        "Along each path, the surfaces of a tissue in the reference against those in the built patient: each "
        "against the other's nearest. The mean of these is the path's mean surface distance, the largest its "
        "Hausdorff distance.");
    Plot plot = borderPlot(study, "mean surface distance of a path, mm",
                           [](const TissueSummary& t) -> const Spread& { return t.mean_distance_m; },
                           {kMm * kNoticedDistance_m});
    page.figure(plot.figure, "Mean and standard deviation of the mean surface distances, by tissue.",
                "Mean surface distance per path: mean and standard deviation, as Fig. 4 of the paper.",
                plot.numbers);
    plot = borderPlot(study, "Hausdorff distance of a path, mm",
                      [](const TissueSummary& t) -> const Spread& { return t.hausdorff_m; },
                      {kMm * kNoticedDistance_m, kMm * kNoticedOutlier_m});
    page.figure(plot.figure, "Mean and standard deviation of the Hausdorff distances, by tissue.",
                "Hausdorff distance per path: mean and standard deviation, as Fig. 5 of the paper.",
                plot.numbers);
    page.table(tissueTable(study));
    page.paragraph(
        "Offset: below zero, the built patient's needle comes into the tissue too early. Missed: the "
        "reference has the tissue on the path, the built patient nowhere near; invented: the other way "
        "round. The last two columns: in which tissue of the reference the tip was when the forces "
        "differed.");
}

void addCauseTable(Page& page, const std::string& caption, const std::vector<CauseCount>& causes) {
    if (causes.empty())
        page.paragraph(caption + ": none.");
    else
        page.table(causeTable(caption, causes));
}

void addCauses(Page& page, const ReportedStudy& study) {
    page.section("Where errors sit, and what caused them");
    const Plot plot = positionPlot(study);
    page.figure(plot.figure, "Root mean squared force error along the way from the skin to the target.",
                "RMSE in each twentieth of the way, of the paths that meet no bone.", plot.numbers);
    page.paragraph(
        "The cause of a path's largest error is the event that only one of the two patients has at that "
        "depth and after which the error rose the most. Displacement: the built patient's event less the "
        "reference's nearest of its kind, below zero where it comes too early; none where the other patient "
        "has none.");
    addCauseTable(page, "Outliers: paths whose maximum error lies above mean + 2.7 standard deviations",
                  study.all.outlier_causes);
    addCauseTable(page, "All paths that meet no bone and have an error", study.without_bone.causes);
    page.foldedTable(causeTable("All paths with an error", study.all.causes));
    for (const ReportedPair& p : study.pairs)
        if (!p.summary.outlier_causes.empty())
            page.foldedTable(causeTable("Outliers of " + p.name, p.summary.outlier_causes));
}

void addPlanning(Page& page, const ReportedStudy& study) {
    page.section("Planned paths");
    page.paragraph(
        "Straight from every skin voxel of the access area to every voxel of the ducts' centre lines in the "
        "reference. C1: no risk structure on the way. C2: 90 mm at most. C3: clearance from risk structures, "
        "full at 10 mm, half as much under a rib. C4: way in the duct along the needle, full at 10 mm. Q is "
        "the mean of C3 and C4; the best path of each skin voxel is kept if its Q is 0.4 or better.");
    const Plot plot = scorePlot(study);
    page.figure(plot.figure, "Histograms of the scores C3, C4 and Q of the kept paths.",
                "Histograms of the kept paths' scores.", plot.numbers);
    page.table(planTable(study));
    for (const ReportedPair& p : study.pairs) {
        if (p.picture.empty()) continue;
        page.picture(
            {p.picture, "image/png", kPathsPictureWidth, kPathsPictureHeight,
             "The planned paths of " + p.name +
                 " over its bones, liver, vessels and ducts, seen from the right and from the front.",
             p.name +
                 ": planned paths from the skin to the ducts, green where their quality is high; bone, "
                 "liver, vessels (blue) and ducts (green) of the reference behind. As Fig. 3 of the paper."});
    }
    for (const ReportedPair& p : study.pairs)
        if (p.plan.kept == 0)
            page.paragraph(p.name + ": no path was found" +
                           (p.plan.candidates == 0
                                ? ": the reference has no bile duct, or no skin in the access area, so that "
                                  "nothing here is about this patient."
                                : "."));
}

void addPatients(Page& page, const ReportedStudy& study) {
    page.section("Patients");
    page.table(labelTable(study));
    for (const ReportedPair& p : study.pairs)
        if (p.facts.reference.labelled_share < patient::kFullShare)
            page.paragraph(p.name + ": its reference has labels in " +
                           percentText(p.facts.reference.labelled_share, 0) +
                           " of the body. In the rest thresholds decide on both sides, so that skin, fat, "
                           "muscle and unlabelled bone are no independent truth there: errors of the body "
                           "wall are understated, and what is compared is the labelled structures.");
    page.table(thresholdTable(study));
    std::vector<const PairFacts*> shown;
    for (const ReportedPair& p : study.pairs) {
        if (std::any_of(shown.begin(), shown.end(), [&](const PairFacts* f) {
                return f->tissues == p.facts.tissues && f->own_table == p.facts.own_table;
            }))
            continue;
        shown.push_back(&p.facts);
        const bool own = !p.facts.own_table.empty();
        page.table(forceTable(p.facts, own ? "Force table of the user's own: " + p.facts.own_table
                                           : "Force table of the reference of " + p.name));
    }
    std::vector<report::Fact> facts;
    for (const ReportedPair& p : study.pairs) {
        facts.push_back({p.name + ", reference", p.facts.reference.name + "; " +
                                                     p.facts.reference.provenance + "; " +
                                                     p.facts.reference.licence});
        facts.push_back({p.name + ", built", p.facts.found.provenance});
    }
    page.facts(facts);
}

void addSettings(Page& page, const ReportedStudy& study) {
    const SteeringSettings& s = study.run.settings.steering;
    page.section("How it was measured");
    page.facts({
        {"Samples a path", "at least " + countText(std::size_t(s.samples)) + ", at most " +
                               fixed(kMm * s.max_spacing_m, 3) + " mm apart"},
        {"Samples in all", countText(study.all.samples) + " in each of the two models"},
        {"Labels that count", study.run.labels == FoundLabels::all
                                  ? "all of the built patient's"
                                  : "the built patient's fascia, liver, vessels and ducts, as in the paper; "
                                    "elsewhere thresholds over the CT"},
        {"Breathing",
         s.breathing ? "on, the needle at " + fixed(kMm * s.speed_m_s, 0) + " mm/s" : "off, as in the paper"},
        {"Force against bone", fixed(s.needle.max_force_n, 1) + " N at once"},
        {"Incline before a puncture", "a1 = " + fixed(s.needle.a1_share, 2) + " k"},
        {"Exact solution", s.breathing ? "none while patients breathe"
                                       : "RMSE " + meanText(study.all.exact_rmse_n, 1.0, 3) + " N, maximum " +
                                             meanText(study.all.exact_max_n, 1.0, 2) + " N, identical " +
                                             percentText(study.all.exact_equal_share.mean) +
                                             " (closed form, without samples)"},
        {"Farther than " + fixed(kMm * study.run.settings.measure.event_window_m, 0) + " mm from every event",
         "maximum error " + meanText(study.all.max_outside_n, 1.0, 2) + " N (median " +
             fixed(study.all.max_outside_n.median, 2) + ")"},
        {"Outlier", "above mean + 2.7 standard deviations"},
        {"Paper",
         "Mastmeyer, Fortmeier, Handels: Evaluation of Direct Haptic 4D Volume Rendering of Partially "
         "Segmented Data for Liver Puncture Simulation. Scientific Reports 7, 2017"},
    });
}

void addLimits(Page& page, const ReportedStudy& study) {
    page.section("What this study cannot say");
    if (const std::size_t made_up = syntheticCount(study); made_up > 0) {
        page.paragraph(
            std::to_string(made_up) + " of the " + std::to_string(study.pairs.size()) +
            " patients are synthetic: a program drew their anatomy and their CT from a seed. They cannot "
            "stand for patients in care. Their labels are true by construction, where experts err at "
            "borders. Their anatomy is one model's range, with no disease but the tumour that blocks the "
            "common duct: no earlier operation, drain, stent, ascites, cirrhosis or anomalous duct. Their CT "
            "has the blur and noise that were put in, not the movement, metal, contrast timing and "
            "reconstruction of a scanner. The program that builds patients was developed with such patients "
            "at hand, and where it lays atlases over a CT these are patients of the same program, so that "
            "its errors here are at the lower end. And ± on this page is the spread over these patients' "
            "paths: it says nothing of how widely patients differ.");
        page.paragraph(
            "What they can show: where along a path and at which border errors of a segmentation become "
            "errors of a force, how large these are for a known error, and whether a change of the programs "
            "made either better or worse.");
    }
    page.paragraph(
        "Both forces are simulated, as in the paper: how near the reference's force is to that of a liver is "
        "another question. Axial force along planned paths is compared, not steering, bending or a hand that "
        "corrects itself.");
}

}  // namespace

ReportedStudy readStudy(const fs::path& out) {
    ReportedStudy study;
    study.run = readRunFacts(out / "summary.json");
    std::vector<PathResult> all;
    for (const std::string& name : study.run.names) {
        const fs::path folder = out / name;
        ReportedPair pair;
        pair.name = name;
        pair.facts = readFacts(folder / "pair.json");
        pair.plan = readPlanFacts(folder / "plan.json");
        pair.results = KeptBlocks(folder / "blocks", pair.facts.run, pair.facts.paths).all();
        pair.picture = bytesOf(folder / "paths.png");
        pair.summary = summarise(name, pair.results);
        pair.without_bone = summariseWithoutBone(name, pair.results);
        all.insert(all.end(), pair.results.begin(), pair.results.end());
        study.pairs.push_back(std::move(pair));
    }
    study.all = summarise("all", all);
    study.without_bone = summariseWithoutBone("without bone", std::move(all));
    return study;
}

std::string studyPage(const ReportedStudy& study) {
    Page page("Force errors of patients built from a CT alone",
              "The needle's axial force down planned paths to the bile ducts: in patients whose segmentation "
              "is a reference, and in patients built from the same CT without it.",
              "stylet-study");
    addHeadlines(page, study);
    page.section("Beside the paper");
    page.table(paperTable(study));
    addBoxes(page, study);
    addBorders(page, study);
    addCauses(page, study);
    addPlanning(page, study);
    addPatients(page, study);
    addSettings(page, study);
    addLimits(page, study);
    return page.html();
}

}  // namespace stylet::study
