#include "app/study/report.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "app/study/paths_picture.h"
#include "app/study/report_figures.h"
#include "app/study/report_paper.h"
#include "app/study/report_tables.h"
#include "app/study/result_blocks.h"
#include "base/whole_file.h"
#include "patient/package/origin.h"

namespace stylet::study {

using patient::Tissue;
using report::fixed;
using report::Page;
using report::Table;

namespace fs = std::filesystem;

namespace {

// ---- from disk

Summary summariseWithoutBone(const std::string& name, std::vector<PathResult> results) {
    std::erase_if(results, [](const PathResult& r) { return r.meets_bone; });
    return summarise(name, results);
}

std::vector<std::uint8_t> readPicture(const fs::path& file) {
    constexpr std::size_t kMostBytes = 64 << 20;
    const std::string bytes = readWholeFile(file, kMostBytes);
    return {bytes.begin(), bytes.end()};
}

// ---- sections

void addHeadlines(Page& page, const ReportedStudy& study) {
    const Summary& s = study.all;
    std::vector<report::Headline> headlines{
        {countText(s.paths), "paths in " + std::to_string(steeredCount(study)) + " patients"},
        {fixed(s.rmse_n.median, 3) + " N", "RMSE of the median path"},
        {meanText(s.rmse_n, 1.0, 3) + " N", "RMSE, mean of all paths"},
        {fixed(s.max_n.median, 2) + " N", "maximum error of the median path"},
        {percentText(s.equal_share.mean), "of the forces are identical"},
        {fixed(kMm * s.mean_distance_m.mean, 2) + " mm", "mean distance of the borders"}};
    if (s.bone_paths > 0)
        headlines.insert(headlines.begin() + 3, {meanText(study.without_bone.rmse_n, 1.0, 3) + " N",
                                                 "RMSE, mean of the paths that meet no bone"});
    page.headlines(headlines);
}

void addOverruled(Page& page, const ReportedStudy& study) {
    std::vector<std::string> verdicts;
    for (const ReportedPair& p : study.pairs)
        for (const std::string& verdict : p.facts.implausible)
            verdicts.push_back(p.name + ": " + verdict);
    if (!verdicts.empty())
        page.paragraph(
            "Implausible patients were accepted (--accept-implausible); all numbers include them: " +
            joined(verdicts) + ".");
}

std::string beyondText(const Plot& plot) {
    return plot.beyond == 0
               ? ""
               : " " + countText(plot.beyond) + " values lie above the axis; the table has the largest.";
}

void addBoxes(Page& page, const ReportedStudy& study) {
    page.section("Force errors");
    page.paragraph(
        "Each box contains the middle half of a patient's paths, with a bar at the median. The whiskers end "
        "at the last values within one and a half box lengths; dots are paths beyond them. Dashed: the just "
        "noticeable difference.");
    const std::string boxes = "Box plots, one a patient and one of all.";
    Plot plot = boxPlot(study, {"RMSE of a path, N",
                                3,
                                1.0,
                                [](const Summary& s) -> const Spread& { return s.rmse_n; },
                                [](const PathResult& r) { return r.sampled.rmse_n; },
                                {kNoticeableForce_n}});
    page.figure({plot.figure, boxes + " Root mean squared force error of the paths.",
                 "RMSE per path, as Fig. 6 of the paper." + beyondText(plot), plot.numbers});
    plot = boxPlot(study, {"maximum error of a path, N",
                           2,
                           1.0,
                           [](const Summary& s) -> const Spread& { return s.max_n; },
                           [](const PathResult& r) { return r.sampled.max_n; },
                           {kNoticeableForce_n}});
    page.figure({plot.figure, boxes + " Maximum absolute force error of the paths.",
                 "Maximum absolute error per path, as Fig. 7 of the paper (its \"MAE\")." + beyondText(plot),
                 plot.numbers});
    plot = boxPlot(study, {"identical forces of a path, %", 1, 100.0,
                           [](const Summary& s) -> const Spread& { return s.equal_share; },
                           [](const PathResult& r) { return r.sampled.equal_share; }});
    plot.figure.y.max = 100.0;
    page.figure({plot.figure, boxes + " Share of bit-equal forces of the paths.",
                 "Share of samples whose forces are equal to the last bit, as Fig. 8 of the paper.",
                 plot.numbers});
    page.table(patientTable(study));
}

void addBorders(Page& page, const ReportedStudy& study) {
    page.section("Borders");
    page.paragraph(
        "Along each path, each surface of a tissue in one patient is compared with the nearest one in the "
        "other patient. The mean of these distances is the path's mean surface distance; the largest is its "
        "Hausdorff distance.");
    Plot plot = borderPlot(study, "mean surface distance of a path, mm",
                           [](const TissueSummary& t) -> const Spread& { return t.mean_distance_m; },
                           {kMm * kNoticeableDistance_m});
    page.figure({plot.figure, "Mean and standard deviation of the mean surface distances, by tissue.",
                 "Mean surface distance per path: mean and standard deviation, as Fig. 4 of the paper.",
                 plot.numbers});
    plot = borderPlot(study, "Hausdorff distance of a path, mm",
                      [](const TissueSummary& t) -> const Spread& { return t.hausdorff_m; },
                      {kMm * kNoticeableDistance_m, kMm * kNoticeableOutlier_m});
    page.figure({plot.figure, "Mean and standard deviation of the Hausdorff distances, by tissue.",
                 "Hausdorff distance per path: mean and standard deviation, as Fig. 5 of the paper.",
                 plot.numbers});
    page.table(borderTable(study));
    page.table(tissueTable(study));
    page.paragraph(
        "Offset below zero: the needle enters the tissue too early in the built patient. Missed: only the "
        "reference has the tissue near the path. Invented, or one too many: only the built patient has it. "
        "Such a border has no distance and is not part of the shares below 2 and 3 mm. The last two columns "
        "divide the squared errors by the tissue of the reference that the tip was in.");
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
    page.figure({plot.figure, "Root mean squared force error along the way from the skin to the target.",
                 "RMSE in each twentieth of the way, of the paths that meet no bone.", plot.numbers});
    page.paragraph(
        "The cause of a path's largest error is the event that only one of the two patients has at that "
        "depth and after which the error rose the most. Displacement: depth of the event in the built "
        "patient minus depth of the nearest event of the same kind in the reference. It is below zero if the "
        "event comes too early, and empty if only one patient has such an event.");
    const std::string outliers = "whose maximum error lies above mean + 2.7 standard deviations";
    addCauseTable(page, "Outliers: paths " + outliers, study.all.outlier_causes);
    if (study.all.bone_paths > 0)
        addCauseTable(page, "Outliers among the paths that meet no bone, " + outliers + " of their own",
                      study.without_bone.outlier_causes);
    addCauseTable(page, "All paths that meet no bone and have an error", study.without_bone.causes);
    page.collapsibleTable(largestTable(study));
    page.collapsibleTable(causeTable("All paths with an error", study.all.causes));
    for (const ReportedPair& p : study.pairs)
        if (!p.without_bone.outlier_causes.empty())
            page.collapsibleTable(causeTable("Outliers of " + p.name + " among its paths that meet no bone",
                                             p.without_bone.outlier_causes));
}

void addPlanning(Page& page, const ReportedStudy& study) {
    page.section("Planned paths");
    const patient::PlanSettings asked;
    page.paragraph("Straight from " + voxelsText(study, &PlanFacts::skin_spacing_m, "skin voxel") +
                   " in the access area to " + voxelsText(study, &PlanFacts::target_spacing_m, "voxel") +
                   " of the ducts' centre lines in the reference. C1: no risk structure on the way. C2: " +
                   numberText(kMm * asked.max_length_m) +
                   " mm at most. C3: clearance from risk structures, full at 10 mm, half as much under a "
                   "rib. C4: way in the duct along the needle, full at 10 mm. Q is the mean of C3 and C4; "
                   "the best path of each skin voxel is kept if its Q is " +
                   numberText(asked.min_quality) + " or better.");
    page.paragraph(
        "In addition to the paper, C1 also blocks a path that does not run between two ribs, crosses the "
        "skin twice, leaves the hand no room above the table, passes a risk structure with hardly any "
        "clearance, or comes closer to it than its border is certain. Within " +
        numberText(kMm * asked.near_target_m) +
        " mm of the duct's wall, where a vessel runs beside every duct, vessels count for C1 but not for "
        "C3.");
    const Plot plot = scorePlot(study);
    const bool breathed = std::any_of(study.pairs.begin(), study.pairs.end(),
                                      [](const ReportedPair& p) { return p.plan.breaths > 0; });
    page.figure(
        {plot.figure, "Histograms of the scores C3, C4 and Q of the kept paths.",
         std::string("Histograms of the kept paths' scores.") +
             (breathed ? " The worst Q is that of the breath's phases: 0 where a path is lost in one." : ""),
         plot.numbers});
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

// Lists the reference's labels that are neither drawn by hand nor synthetic.
std::string undrawnText(const PackageFacts& reference) {
    std::string text;
    for (const LabelFacts& l : reference.labels)
        if (!l.provenance.starts_with("manual") && l.provenance != "synthetic")
            text += (text.empty() ? "" : "; ") + l.name + " (" + l.provenance + ")";
    return text;
}

void addPatients(Page& page, const ReportedStudy& study) {
    page.section("Patients");
    page.table(labelTable(study));
    for (const ReportedPair& p : study.pairs)
        if (p.facts.reference.labelled_share < patient::kFullShare)
            page.paragraph(p.name + ": its reference has labels in " +
                           percentText(p.facts.reference.labelled_share, 0) +
                           " of the body. Elsewhere the thresholds decide in both patients, so skin, fat, "
                           "muscle and unlabelled bone are not independent there. The errors of the body "
                           "wall are underestimated; only the labelled structures are really compared.");
    for (const ReportedPair& p : study.pairs)
        if (const std::string undrawn = undrawnText(p.facts.reference); !undrawn.empty())
            page.paragraph(p.name + ": these labels of its reference were not drawn by a person: " + undrawn +
                           ". Errors there are measured against a program.");
    page.table(thresholdTable(study));
    std::vector<const PairFacts*> shown;
    for (const ReportedPair& p : study.pairs) {
        if (std::any_of(shown.begin(), shown.end(), [&](const PairFacts* f) {
                return f->tissues == p.facts.tissues && f->own_table == p.facts.own_table;
            }))
            continue;
        shown.push_back(&p.facts);
        const bool own = !p.facts.own_table.empty();
        page.table(forceTable(p.facts, own ? "Own force table: " + p.facts.own_table
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

// Lists the built patients' labels that are used, in the paper's words, and names the vessels.
std::string labelsText(const ReportedStudy& study) {
    if (study.run.labels == FoundLabels::all) return comparedLabels(study.run.labels);
    std::vector<std::string> vessels;
    for (const ReportedPair& p : study.pairs)
        for (const LabelFacts& l : p.facts.found.labels)
            if (l.counts && l.tissue == Tissue::vessel &&
                std::find(vessels.begin(), vessels.end(), l.name) == vessels.end())
                vessels.push_back(l.name);
    return "the built patient's fascia, liver, ducts and vessels" +
           (vessels.empty() ? "" : " (" + joined(vessels) + "; the paper: the liver's)") +
           "; elsewhere thresholds over the CT, as in the paper";
}

void addSettings(Page& page, const ReportedStudy& study) {
    const SteeringSettings& s = study.run.settings.steering;
    const Spread& outside = study.without_bone.max_outside_n;
    page.section("How it was measured");
    page.facts({
        {"Samples a path", "at least " + countText(std::size_t(s.samples)) + ", at most " +
                               fixed(kMm * s.max_spacing_m, 3) + " mm apart"},
        {"Samples in all", countText(study.all.samples) + " in each of the two models"},
        {"Labels that count", labelsText(study)},
        {"Breathing",
         s.breathing ? "on, the needle at " + fixed(kMm * s.speed_m_s, 0) + " mm/s" : "off, as in the paper"},
        {"Force against bone",
         s.breathing ? "rises with bone's stiffness to " + fixed(s.needle.max_force_n, 1) + " N at most"
                     : fixed(s.needle.max_force_n, 1) + " N at once"},
        {"Incline before a puncture", "a1 = " + fixed(s.needle.a1_share, 2) + " k"},
        {"Exact solution", s.breathing ? "none while patients breathe"
                                       : "RMSE " + meanText(study.all.exact_rmse_n, 1.0, 3) + " N, maximum " +
                                             meanText(study.all.exact_max_n, 1.0, 2) + " N, identical " +
                                             percentText(study.all.exact_equal_share.mean) +
                                             " (closed form, without samples)"},
        {"Farther than " + fixed(kMm * study.run.settings.measure.event_window_m, 0) + " mm from every event",
         "maximum error " + meanText(outside, 1.0, 3) + " N (largest " + fixed(outside.max, 2) + ")" +
             (study.all.bone_paths > 0 ? " on paths that meet no bone" : "")},
        {"Outlier", "above mean + 2.7 standard deviations"},
        {"Paper",
         "Mastmeyer, Fortmeier, Handels: Evaluation of Direct Haptic 4D Volume Rendering of Partially "
         "Segmented Data for Liver Puncture Simulation. Scientific Reports 7, 2017"},
    });
}

// What the synthetic patients lack. A hard case has what its variants add.
std::string syntheticLimits(const ReportedStudy& study, std::size_t synthetic) {
    std::vector<std::string> hard_cases;
    for (const ReportedPair& p : study.pairs)
        if (const std::string_view variants = patient::synthVariants(p.facts.reference.provenance);
            isSynthetic(p.facts) && !variants.empty())
            hard_cases.push_back(p.name + " (" + std::string(variants) + ")");
    std::string text = "Their anatomy is one model's range. ";
    if (const std::size_t plain = synthetic - hard_cases.size(); plain > 0)
        text += std::to_string(plain) + (plain == 1 ? " of them has" : " of them have") +
                " no disease but the tumour that blocks the common duct: no earlier operation, "
                "drain, stent, ascites, cirrhosis or anomalous duct. Their CT has the blur and noise that "
                "were put in, not the movement, metal, contrast timing and reconstruction of a scanner. ";
    if (!hard_cases.empty())
        text += std::to_string(hard_cases.size()) +
                (hard_cases.size() == 1 ? " of them is a hard case" : " of them are hard cases") +
                ", with the disease, body or scan that its variants add by a few "
                "rules: " +
                joined(hard_cases) + ". ";
    return text;
}

void addLimits(Page& page, const ReportedStudy& study) {
    page.section("Limits of this study");
    if (const std::size_t made_up = syntheticCount(study); made_up > 0) {
        page.paragraph(
            std::to_string(made_up) + " of the " + std::to_string(study.pairs.size()) +
            " patients are synthetic: a program drew their anatomy and their CT from a seed. They cannot "
            "stand for patients in care. Their labels are true by construction, where experts err at "
            "borders. " +
            syntheticLimits(study, made_up) +
            "The program that builds patients was developed with such patients at hand, and where it lays "
            "atlases over a CT these are patients of the same program, so that it "
            "may err less here than elsewhere. And ± on this page is the spread over these patients' paths, "
            "or between these patients: it says nothing of how widely patients in care differ.");
        page.paragraph(
            "What they can show: where along a path and at which border errors of a segmentation become "
            "errors of a force, how large these are for a known error, and whether a change of the programs "
            "made either better or worse.");
    }
    page.paragraph(
        "Both forces are simulated, as in the paper. The study does not show how close the reference's force "
        "is to that of a real liver. It compares the axial force along planned paths, not steering, bending "
        "or corrections by the user.");
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
        pair.results = ResultBlocks(folder / "blocks", pair.facts.run, pair.facts.paths).all();
        for (const patient::PlannedPath& path : patient::loadPaths(folder / "paths.json").paths)
            pair.clearance.push_back(path.clearance_score);
        if (fs::exists(folder / "paths.png")) pair.picture = readPicture(folder / "paths.png");
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
              "is a reference, and in patients built from the same CT without it. Compared: " +
                  comparedLabels(study.run.labels) + ".",
              "stylet-study");
    if (study.all.paths > 0) addHeadlines(page, study);
    addOverruled(page, study);
    if (study.all.paths > 0) {
        page.section("Beside the paper");
        page.table(paperTable(study));
        addBoxes(page, study);
        addBorders(page, study);
        addCauses(page, study);
    } else {
        page.paragraph("No path was found in any patient: there is nothing to compare.");
    }
    addPlanning(page, study);
    addPatients(page, study);
    addSettings(page, study);
    addLimits(page, study);
    return page.html();
}

}  // namespace stylet::study
