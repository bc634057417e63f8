#include "app/study/report.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "app/study/commands.h"
#include "app/study/paths_picture.h"
#include "app/study/report_figures.h"
#include "app/study/report_paper.h"
#include "app/study/report_tables.h"
#include "tests/app/study/study_on_disk.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"

namespace stylet::study {
namespace {

namespace fs = std::filesystem;
using test::readText;

class StudyReport : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new test::TempFolder;
        test::writeStudy(folder_->path());
        test::TestStudyOptions o(folder_->path());
        runStudy(o);
    }
    static void TearDownTestSuite() { delete folder_; }
    static fs::path out() { return *folder_ / "out"; }

    static test::TempFolder* folder_;
};
test::TempFolder* StudyReport::folder_ = nullptr;

TEST_F(StudyReport, PageShowsTheResultsOfTheRun) {
    const ReportedStudy study = readStudy(out());
    ASSERT_EQ(study.pairs.size(), 2u);
    const auto summary = nlohmann::json::parse(readText(out() / "summary.json"));
    EXPECT_EQ(study.all.paths, summary["all"]["paths"].get<std::size_t>());
    EXPECT_EQ(study.all.rmse_n.median, summary["all"]["rmse_n"]["median"].get<double>());
    EXPECT_EQ(study.without_bone.max_n.mean, summary["all_without_bone"]["max_n"]["mean"].get<double>());
    const PairFacts& facts = study.pairs[0].facts;
    EXPECT_EQ(facts.reference.name, "reference patient, seed 1");
    EXPECT_GT(facts.reference.labelled_share, 0.9);
    EXPECT_EQ(facts.dims, test::seededTruth().ct.grid.dims);
    EXPECT_EQ(facts.tissues[std::size_t(patient::Tissue::bone)].cut_force_n, INFINITY);
    EXPECT_FALSE(study.pairs[0].picture.empty());

    const std::string html = studyPage(study);
    for (const char* text :
         {"31,222", "0.12 ± 0.04 N", "0.65 ± 0.18 N", "0.05 %", "3.73 %", "88 %", "0.145 N",
          "made by stylet-model synth", "They cannot stand for patients in care", "bile ducts",
          "automatic: ", "Force table of the reference of"})
        EXPECT_NE(html.find(text), std::string::npos) << text;
    EXPECT_NE(html.find(countText(study.all.paths)), std::string::npos);
    EXPECT_EQ(html.find(">nan"), std::string::npos);
    EXPECT_EQ(writeReport(out()), out() / "report.html");
    EXPECT_EQ(readText(out() / "report.html"), html);
}

// The standard deviation of a single value is undefined.
TEST_F(StudyReport, MeansOfASinglePatientHaveNoSpread) {
    const test::TempFolder temp;
    fs::copy(folder_->path(), temp.path(), fs::copy_options::recursive);
    fs::remove(temp / "out/summary.json");  // resume: nothing is planned or computed again
    std::ofstream(temp / "study.toml") << "[[pair]]\nname = 'one'\nreference = 'truth'\nfound = 'built'\n";
    test::TestStudyOptions o(temp.path());
    runStudy(o);
    const auto summary = nlohmann::json::parse(readText(temp / "out/summary.json"));
    EXPECT_EQ(summary["patients_means"]["rmse_n"]["count"], 1);
    EXPECT_TRUE(summary["patients_means"]["rmse_n"]["sigma"].is_null());
    EXPECT_TRUE(summary["all"]["rmse_n"]["sigma"].is_number()) << "over many paths there is one";
    const std::string html = studyPage(readStudy(temp / "out"));
    const std::size_t begin = html.find("not given", html.find("Means of the patients"));
    const std::size_t end = html.find("Every patient with the same weight");
    ASSERT_LT(begin, end);
    const std::string means = html.substr(begin, end - begin);
    EXPECT_NE(means.find("RMSE 0."), std::string::npos) << means;
    EXPECT_EQ(means.find("±"), std::string::npos) << means;
}

// HZ-TEACH-22
// The paths were planned before the patient was refused.
TEST_F(StudyReport, OverruledVerdictsAreInEveryResult) {
    const test::TempFolder temp;
    fs::copy(folder_->path(), temp.path(), fs::copy_options::recursive);
    fs::remove(temp / "out/summary.json");  // resume: nothing is planned or computed again
    const fs::path built = temp / "built";
    patient::saveVerdict({patient::digest(patient::loadPackage(built)), true, {"REFUSED  skin: 0 ml"}},
                         built);
    test::TestStudyOptions o(temp.path());
    EXPECT_THROW(runStudy(o), DataError);
    o.accept_implausible = true;
    runStudy(o);
    const auto json = [&](const char* file) { return nlohmann::json::parse(readText(temp / "out" / file)); };
    EXPECT_FALSE(json("one/plan.json").contains("implausible"));
    EXPECT_EQ(json("one/pair.json")["implausible"].size(), 1u);
    EXPECT_EQ(json("two/pair.json")["implausible"].size(), 0u);
    const std::string line =
        "one: built patient, overruled: the check refused this patient: REFUSED  skin: 0 ml";
    EXPECT_NE(studyPage(readStudy(temp / "out")).find(line), std::string::npos);
    EXPECT_EQ(studyPage(readStudy(out())).find("Implausible patients were accepted"), std::string::npos);
}

void recomputeSummaries(ReportedStudy& study) {
    std::vector<PathResult> all;
    const auto clear = [](std::vector<PathResult> results) {
        std::erase_if(results, [](const PathResult& r) { return r.meets_bone; });
        return summarise("clear", results);
    };
    for (ReportedPair& p : study.pairs) {
        p.summary = summarise(p.name, p.results);
        p.without_bone = clear(p.results);
        all.insert(all.end(), p.results.begin(), p.results.end());
    }
    study.all = summarise("all", all);
    study.without_bone = clear(all);
}

void expectTexts(const std::string& html, const std::vector<std::string>& texts, bool says) {
    for (const std::string& text : texts)
        EXPECT_EQ(html.find(text) != std::string::npos, says) << text;
}

// The page's statements on bone, skin, order and force follow the numbers and quote them.
TEST_F(StudyReport, ExplanationsFollowTheNumbers) {
    ReportedStudy study = readStudy(out());
    study.run.labels = FoundLabels::partial;
    for (ReportedPair& p : study.pairs) {
        ASSERT_EQ(p.clearance.size(), p.results.size());
        p.facts.found.thresholds.t2_sensitive_hu = 150;
        p.facts.reference.thresholds.t2_sensitive_hu = 200;
        p.plan.skin_spacing_m = 0.0025;
        p.clearance.assign(p.results.size(), 0.5);
        for (PathResult& r : p.results) {
            r.meets_bone = false, r.same_order = r.same_order_inside = r.same_order_noticeable = true;
            r.borders.missed = r.borders.invented = 0;
            for (BorderError& b : r.by_tissue)
                b.missed = b.invented = 0;
            r.sampled.rmse_n = 0.2, r.sampled.max_n = 1.75, r.max_outside_n = 0.0;
            r.cause = {Model::full, patient::Tissue::fascia, haptics::NeedleEventKind::border, 0.001};
            r.event_m[std::size_t(patient::Tissue::fascia)] = 0.00125;
        }
    }
    recomputeSummaries(study);
    const std::vector<std::string> of_bone{" N without bone",
                                           "C3 below 0.1",
                                           "probably the threshold is too low",
                                           "largest of all is bone",
                                           "on paths that meet no bone",
                                           "RMSE, mean of the paths that meet no bone"};
    const std::vector<std::string> of_skin{"(missed on ", "rim of partial volume",
                                           "that argument does not apply"};
    std::string html = studyPage(study);
    expectTexts(html, of_bone, false);
    expectTexts(html, of_skin, false);
    expectTexts(html,
                {"0 (0.0 %)", "skin voxels 2.5 mm apart", "to every voxel of the ducts", "22.0 N at once",
                 "fascia tenting at its border (100 % of the paths)", "1.25 mm off on average",
                 "100 % of these paths come to 80 % or more of these 1.8 N",
                 "100.0 % of the paths are above it: this contradicts the paper"},
                true);

    // Every fourth path runs close to a rib, and bone stops half of these. On every second path
    // the border of the skin is missed.
    ReportedPair& one = study.pairs[0];
    ASSERT_GE(one.results.size(), 8u);
    one.results.resize(8), one.clearance.resize(8);
    study.pairs.resize(1);
    for (std::size_t i = 0; i < 8; ++i) {
        PathResult& r = one.results[i];
        r.by_tissue[std::size_t(patient::Tissue::skin)].missed = i % 2 == 0;
        r.borders.missed = i % 2 == 0;
        r.same_order = r.same_order_noticeable = i % 2 != 0;
        if (i % 4 == 0) one.clearance[i] = 0.05;
    }
    one.results[0].meets_bone = true;
    one.results[0].sampled.rmse_n = 8.6, one.results[0].sampled.max_n = 21.5;
    one.results[0].max_outside_n = 21.5;
    study.run.settings.steering.breathing = true;
    recomputeSummaries(study);
    html = studyPage(study);
    expectTexts(html, of_bone, true);
    expectTexts(html, of_skin, true);
    expectTexts(
        html,
        {"1 (12.5 %)",
         "100 % of the paths that meet bone have C3 below 0.1, and 50 % of all paths with C3 below 0.1",
         "is 150 HU (reference 200): probably", "86 % of the mean", "21.50 N (largest)",
         "1.75 N (largest without bone)", "50.0 % of the paths (by patient 50.0 %); 100.0 % without skin",
         "(missed on 50 %)", "0.000 ± 0.000 N (largest 0.00) on paths", "to 22.0 N at most",
         "Outliers among the paths that meet no bone"},
        true);
    // A bone threshold that is not lower than the reference's is not reported as a cause.
    one.facts.found.thresholds.t2_sensitive_hu = 210;
    expectTexts(studyPage(study), {"probably the threshold"}, false);
    // The same differences, but too thin to notice; then differences that are noticed, but few.
    const std::string thin = "almost all differences are layers too thin to notice";
    expectTexts(html, {thin}, false);
    for (PathResult& r : one.results)
        r.same_order_noticeable = true;
    recomputeSummaries(study);
    html = studyPage(study);
    expectTexts(html, {thin}, true);
    expectTexts(html, {"that argument does not apply"}, false);
    study.all.same_order_share = study.all.same_order_noticeable_share = 0.985;
    html = studyPage(study);
    expectTexts(html, {thin}, false);
    expectTexts(html, {"that argument does not apply"}, false);
}

TEST_F(StudyReport, PageAndTablesNameTheLabelsCompared) {
    ReportedStudy study = readStudy(out());
    ASSERT_EQ(study.run.labels, FoundLabels::all);
    for (const auto& [labels, text] :
         {std::pair{FoundLabels::all, "ompared: all labels, as in training"},
          {FoundLabels::partial, "ompared: fascia, liver, vessels and ducts, as in the paper"}}) {
        study.run.labels = labels;
        for (const report::Table& table : {paperTable(study), patientTable(study), borderTable(study),
                                           tissueTable(study), largestTable(study)})
            EXPECT_NE(table.caption.find(text), std::string::npos) << table.caption;
        EXPECT_NE(studyPage(study).find(std::string("without it. C") + text), std::string::npos);
    }
}

// A patient made with --variant has diseases that the other synthetic patients lack.
TEST_F(StudyReport, LimitsNameTheHardCases) {
    ReportedStudy study = readStudy(out());
    const std::string healthy = " of them have no disease but the tumour";
    expectTexts(studyPage(study), {"2" + healthy}, true);
    expectTexts(studyPage(study), {"hard cases"}, false);
    study.pairs[0].facts.reference.provenance += " --variant ascites,stent";
    expectTexts(
        studyPage(study),
        {"1 of them has no disease but the tumour", "1 of them is a hard case", ": one (ascites,stent). "},
        true);
    study.pairs[1].facts.reference.provenance += " --variant native";
    expectTexts(studyPage(study), {"no disease but the tumour", "the blur and noise that"}, false);
    expectTexts(studyPage(study), {"2 of them are hard cases", "one (ascites,stent), two (native). "}, true);
}

// HZ-RECORD-11
TEST_F(StudyReport, HostileTextIsEscaped) {
    const std::string hostile = "</script><script>alert(1)</script><img src=x>\xFF";
    ReportedStudy study = readStudy(out());
    ReportedPair& pair = study.pairs[0];
    pair.name = hostile;
    pair.facts.reference.name = pair.facts.reference.licence = pair.facts.found.provenance = hostile;
    pair.facts.reference.labels[0].name = pair.facts.reference.labels[0].provenance = hostile;
    pair.facts.reference.labels[1].provenance = "threshold: 2 mm shell";
    pair.facts.own_table = hostile;
    pair.facts.reference.labelled_share = 0.3;
    const std::string html = studyPage(study);
    EXPECT_EQ(html.find("<script>alert"), std::string::npos);
    EXPECT_EQ(html.find("<img src=x"), std::string::npos);
    EXPECT_EQ(html.find('\xFF'), std::string::npos);
    EXPECT_NE(html.find("Own force table: "), std::string::npos);
    EXPECT_NE(html.find("(threshold: 2 mm shell)"), std::string::npos);
    EXPECT_NE(html.find("its reference has labels in 30 % of the body"), std::string::npos);
}

TEST_F(StudyReport, PageReportsMissingPaths) {
    ReportedStudy study = readStudy(out());
    for (ReportedPair& pair : study.pairs) {
        pair.results.clear();
        pair.summary = pair.without_bone = summarise(pair.name, {});
        pair.plan.candidates = pair.plan.kept = 0;
    }
    study.all = study.without_bone = summarise("all", {});
    const std::string html = studyPage(study);
    EXPECT_NE(html.find("No path was found in any patient"), std::string::npos);
    EXPECT_NE(html.find("one: no path was found: the reference has no bile duct"), std::string::npos);
    EXPECT_EQ(html.find("31,222"), std::string::npos);
    // One of two patients has no path.
    ReportedStudy half = readStudy(out());
    half.pairs[0] = study.pairs[0];
    EXPECT_NE(studyPage(half).find("1 without a path"), std::string::npos);
}

TEST_F(StudyReport, MissingFilesAreReported) {
    const test::TempFolder temp;
    const fs::path copy = temp / "out";
    fs::copy(out(), copy, fs::copy_options::recursive);
    const auto refused = [&](const fs::path& file, const std::string& text, const std::string& field) {
        const std::string before = readText(copy / file);
        text.empty() ? void(fs::remove(copy / file)) : void(std::ofstream(copy / file) << text);
        test::expectRefused([&] { readStudy(copy); }, file.string(), field);
        std::ofstream(copy / file) << before;
    };
    // A pair without paths has no picture.
    fs::remove(copy / "one/paths.png");
    EXPECT_TRUE(readStudy(copy).pairs[0].picture.empty());
    refused("summary.json", "", "file");
    refused("summary.json", "[]", "json");
    refused("summary.json",
            R"({"format": "stylet study 1", "settings": {}, "patients": [{"name": "../up"}]})",
            "patients[0].name");
    refused("summary.json", R"({"format": "stylet study 1", "settings": {}, "patients": []})",
            "settings.samples");
    refused("summary.json", R"({"format": "stylet study 1", "settings": {}})", "patients");
    refused("one/pair.json", "", "file");
    refused("one/pair.json", "{", "json");
    refused("one/pair.json", R"({"format": "stylet study pair 3"})", "reference");
    refused("one/pair.json",
            std::regex_replace(readText(copy / "one/pair.json"), std::regex("\"labels\""), "\"other\""),
            "reference.labels");
    refused("one/plan.json", "", "file");
    refused("one/plan.json", R"({"format": "stylet study plan 1", "skin_spacing_mm": 0})",
            "target_spacing_mm");
    fs::remove(copy / "one/blocks/000000.results");
    test::expectRefused([&] { readStudy(copy); }, "000000.results", "file");
}

// An interrupted run is resumed. A completed study is run again from the start.
TEST_F(StudyReport, UnfinishedRunsResume) {
    const test::TestStudyOptions o(folder_->path());
    const std::string summary = readText(out() / "summary.json"), paths = readText(out() / "one/paths.csv");
    const fs::path lost = out() / "one/blocks/000000.results", stays = out() / "two/blocks/000000.results";
    const auto past = fs::file_time_type::clock::now() - std::chrono::hours(1);
    fs::last_write_time(stays, past);
    const auto before = fs::last_write_time(stays);
    fs::remove(out() / "summary.json");
    fs::remove(lost);
    runStudy(o);
    EXPECT_TRUE(fs::exists(lost));
    EXPECT_EQ(fs::last_write_time(stays), before);
    EXPECT_EQ(readText(out() / "summary.json"), summary);
    EXPECT_EQ(readText(out() / "one/paths.csv"), paths);
    runStudy(o);
    EXPECT_NE(fs::last_write_time(stays), before);
    EXPECT_EQ(readText(out() / "summary.json"), summary);
}

TEST_F(StudyReport, BoxesSpanTheQuartiles) {
    const ReportedStudy study = readStudy(out());
    const Plot plot = boxPlot(study, {"RMSE, N",
                                      3,
                                      1.0,
                                      [](const Summary& s) -> const Spread& { return s.rmse_n; },
                                      [](const PathResult& r) { return r.sampled.rmse_n; },
                                      {kNoticeableForce_n}});
    ASSERT_EQ(plot.figure.boxes.size(), 3u);
    EXPECT_EQ(plot.figure.x.names, (std::vector<std::string>{"all", "one", "two"}));
    EXPECT_EQ(plot.figure.boxes[1].median, study.pairs[0].summary.rmse_n.median);
    EXPECT_EQ(plot.figure.boxes[2].high, study.pairs[1].summary.rmse_n.upper_whisker);
    EXPECT_EQ(plot.figure.lines.at(0).y, kNoticeableForce_n);
    EXPECT_EQ(plot.figure.lines.at(0).text, "just noticeable: 0.145 N");
    EXPECT_EQ(plot.numbers.rows.size(), 3u);
    std::size_t drawn = 0, outliers = 0;
    for (const auto& series : plot.figure.series)
        if (series.small) drawn = series.points.size();
    for (const ReportedPair& pair : study.pairs)
        for (const PathResult& r : pair.results)
            outliers += r.sampled.rmse_n > pair.summary.rmse_n.upper_whisker ||
                        r.sampled.rmse_n < pair.summary.rmse_n.lower_whisker;
    EXPECT_EQ(drawn + plot.beyond, outliers);
}

TEST(StudyReportTexts, CountsAndShares) {
    EXPECT_EQ(countText(0), "0");
    EXPECT_EQ(countText(999), "999");
    EXPECT_EQ(countText(31222), "31,222");
    EXPECT_EQ(countText(1234567), "1,234,567");
    EXPECT_EQ(percentText(0.0373, 2), "3.73 %");
    EXPECT_EQ(percentText(kNone), "–");
}

TEST(PathsPicture, IsAPngOfPaths) {
    const patient::Patient reference(test::seededTruth());
    const patient::TissueMap map(reference);
    const auto png = pathsPicture(map, test::seededPaths(), "seed 1", 2);
    ASSERT_GT(png.size(), 10000u);
    EXPECT_EQ(std::string(png.begin() + 1, png.begin() + 4), "PNG");
    EXPECT_EQ(pathsPicture(map, test::seededPaths(), "seed 1", 1), png);
    EXPECT_TRUE(pathsPicture(map, {}, "nobody", 1).empty());
}

}  // namespace
}  // namespace stylet::study
