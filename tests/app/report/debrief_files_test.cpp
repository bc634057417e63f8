// The files that a debrief reads and writes.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <map>

#include "app/records/export.h"
#include "app/report/attempt_page.h"
#include "app/report/commands.h"
#include "tests/app/report/attempts.h"
#include "tests/app/report/debrief.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"

namespace {

using namespace stylet::report;
using stylet::test::has;
using stylet::test::makeLoadedAttempt;
using stylet::test::TempFolder;

TEST(Debrief, ReadsSamplesAndReportsUnreadableFiles) {
    const TempFolder folder;
    LoadedAttempt a = makeLoadedAttempt(folder, 5000);
    ASSERT_EQ(a.course.size(), 5000u);
    EXPECT_TRUE(a.warnings.empty());
    EXPECT_EQ(a.course[100].tool, stylet::haptics::Tool::finger);
    EXPECT_FALSE(a.course[100].in_body);
    EXPECT_NEAR(a.course[3499].depth_m, 0.074, 1e-6);
    EXPECT_NEAR(a.course[3499].sent_n, 0.4 * std::fabs(a.course[3499].force_n), 1e-6);
    EXPECT_EQ(deepestRow(a.course), 3499u);
    std::filesystem::resize_file(folder / "record/samples.bin",
                                 std::filesystem::file_size(folder / "record/samples.bin") - 10);
    a = loadAttempt(folder.path());
    EXPECT_LT(a.course.size(), 5000u);
    EXPECT_GE(a.course.size(), 4000u);
    ASSERT_EQ(a.warnings.size(), 1u);
    std::ofstream(folder / "record/samples.bin") << "nonsense";
    std::ofstream(folder / "duct_left.png") << "no picture";
    a = loadAttempt(folder.path());
    EXPECT_TRUE(a.course.empty());
    const std::string html = attemptReport(a, {}).html;
    EXPECT_TRUE(has(html, "What could not be read"));
    EXPECT_TRUE(has(html, "duct_left.png: header: is not that of a PNG"));
    EXPECT_TRUE(has(html, "The needle did not enter the body."));
}

TEST(Debrief, FolderProvidesTickLengthAndPatient) {
    const TempFolder folder;
    auto attempt = stylet::test::makeTestAttempt("", "", 71.0, true);
    attempt.info.patient_digest = 77, attempt.info.dt_s = 0.00025;
    attempt.events.clear();
    stylet::test::writeAttemptFolder(folder.path(), 1000, attempt);
    const LoadedAttempt a = loadAttempt(folder.path());
    EXPECT_EQ(a.stored.id, folder.path().filename());
    EXPECT_EQ(a.stored.info.dt_s, 0.00025);
    EXPECT_EQ(a.stored.info.patient_digest, 77u);
    EXPECT_TRUE(has(timelineFigure(a).description, "Timeline of 1.0 s."));  // shortest timeline that is drawn
    EXPECT_TRUE(has(timelineFigure(a).description, "in the body for 0.1 s"));
}

// Everything that a report writes, by file name.
std::map<std::string, std::string> reportOf(const std::string& attempt, const std::filesystem::path& records,
                                            const TempFolder& folder) {
    ReportOptions o;
    o.attempt = attempt, o.records = records, o.out = folder / "report";
    std::filesystem::remove_all(o.out);
    reportAttempt(o);
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(o.out))
        files[entry.path().filename().string()] = stylet::test::readText(entry.path());
    return files;
}

// HZ-TEACH-20
TEST(Debrief, ReportsOfAStoredAndAnExportedAttemptAreTheSameBytes) {
    const TempFolder folder;
    stylet::records::Store store(folder / "store");
    const auto made = stylet::test::makeTestAttempt("", "trainee-A", 71.0, true);
    for (const bool torn : {false, true}) {
        const std::string id = store.begin(made.info);
        auto begun = store.attempt(id);
        begun.result = made.result, begun.events = made.events;
        stylet::test::writeAttemptFolder(begun.folder, 5000, begun);
        if (torn) std::ofstream(begun.folder / "record/samples.bin", std::ios::app) << "half a frame";
        store.finish(id);
        const auto stored = reportOf(id, folder / "store", folder);
        EXPECT_EQ(stored.size(), 5u) << "page, course, events, metrics and xAPI";
        EXPECT_EQ(has(stored.at("attempt.html"), "record/samples.bin: 12 bytes behind"), torn);
        const std::filesystem::path taken = folder / (torn ? "taken-torn" : "taken");
        exportAttempts(store, "trainee-A", taken);
        EXPECT_EQ(reportOf((taken / "attempts" / id).string(), "/nonexistent", folder), stored);
        EXPECT_EQ(reportOf(begun.folder.string() + "/", "/nonexistent", folder), stored);
        // Copied again under another name.
        std::filesystem::copy(taken / "attempts" / id, taken / "another name",
                              std::filesystem::copy_options::recursive);
        EXPECT_EQ(reportOf((taken / "another name").string(), "/nonexistent", folder), stored);
    }
}

// The store's index is not asked: the folder itself says that it was imported.
// HZ-RECORD-07
TEST(Debrief, AFolderThatWasImportedSaysSo) {
    const TempFolder folder;
    auto made = stylet::test::makeTestAttempt("", "trainee-A", 71.0, true);
    {
        stylet::records::Store store(folder / "store");
        made.id = store.begin(made.info);
        store.abandon(made.id);
    }
    const std::filesystem::path copied = folder / "store" / "attempts" / made.id;
    stylet::test::writeAttemptFolder(copied, 5000, made);
    const auto page = [&] { return reportOf(copied.string(), "/nonexistent", folder).at("attempt.html"); };
    EXPECT_FALSE(has(page(), "State: imported"));
    EXPECT_TRUE(stylet::records::Store(folder / "store").attempt(made.id).imported);
    EXPECT_TRUE(has(page(), "State: imported: it enters no statistics"));
}

TEST(Debrief, ExportsBesideTheRecordAreNeverRead) {
    const TempFolder folder;
    const std::filesystem::path attempt = folder / "attempt";
    stylet::test::writeAttemptFolder(attempt, 5000);
    const auto before = reportOf(attempt.string(), "/nonexistent", folder);
    const std::vector<std::string> exports{"summary.json", "force-depth.csv",  "force-depth.png",
                                           "slices.png",   "attempt.json",     "flight-1.csv",
                                           "frames.json",  "record/frames.csv"};
    for (const char* text : {"{}", "garbage", R"({"target_hit": false, "score": {"total": 1}})"}) {
        for (const std::string& name : exports)
            std::ofstream(attempt / name) << text;
        EXPECT_EQ(reportOf(attempt.string(), "/nonexistent", folder), before) << text;
    }
    for (const std::string& name : exports)
        std::filesystem::remove(attempt / name);
    EXPECT_EQ(reportOf(attempt.string(), "/nonexistent", folder), before);
    for (const std::string& name : exports)
        std::filesystem::create_directory(attempt / name);
    EXPECT_EQ(reportOf(attempt.string(), "/nonexistent", folder), before);
}

// HZ-RECORD-07
TEST(Debrief, ADamagedRecordIsRefusedWithItsReason) {
    const TempFolder folder;
    const auto refused = [&](const std::string& file, const std::string& field) {
        stylet::test::expectRefused([&] { loadAttempt(folder.path()); }, file, field);
        stylet::test::writeAttemptFolder(folder.path(), 500);
    };
    refused("record.json", "file");  // there is none
    const std::filesystem::path json = folder / "record/record.json", inputs = folder / "record/inputs.bin";
    using stylet::records::kRecordVersion;
    const auto version = [](std::uint32_t number) { return fmt::format("\"format_version\": {}", number); };
    for (const auto& [from, to, field] : std::vector<std::array<std::string, 3>>{
             {"{", "[", "json"},
             {version(kRecordVersion), version(kRecordVersion - 1), "format_version"},
             {"\"target_hit\": true", "\"target_hit\": 1", "result.target_hit"},
             {"\"total\": 71.0", "\"total\": \"71\"", "result.score.total"},
             {"\"kind\": \"tool\"", "\"kind\": 0", "events[0].kind"},
             {"\"lateral_cut_m\"", "\"lateral_cut\"", "result.lateral_cut_m"}}) {
        std::string text = stylet::test::readText(json);
        ASSERT_TRUE(has(text, from)) << from;
        text.replace(text.find(from), from.size(), to);
        std::ofstream(json) << text;
        refused("record.json", field);
    }
    std::filesystem::resize_file(inputs, 20);
    refused("inputs.bin", "header");
    std::string bytes = stylet::test::readText(inputs);
    bytes[20] ^= 1;
    std::ofstream(inputs, std::ios::binary) << bytes;
    refused("inputs.bin", "header");
    std::filesystem::remove(inputs);
    refused("inputs.bin", "file");
    EXPECT_NO_THROW(loadAttempt(folder.path()));
    std::filesystem::remove(folder / "record/samples.bin");
    EXPECT_EQ(loadAttempt(folder.path()).warnings.size(), 1u) << "samples of a finished attempt are missed";
}

TEST(Debrief, RemovesStaleFilesOfAnEarlierReport) {
    const TempFolder folder;
    auto unfinished = stylet::test::makeTestAttempt("", "", 0.0, false);
    unfinished.result.reset();
    stylet::test::writeAttemptFolder(folder / "attempt", 1000, unfinished);
    ReportOptions o;
    o.attempt = (folder / "attempt").string();
    o.out = folder / "out";
    std::filesystem::create_directories(o.out);
    for (const char* name : {"metrics.csv", "xapi.json", "mine.txt"})
        std::ofstream(o.out / name) << "earlier";
    reportAttempt(o);
    EXPECT_FALSE(std::filesystem::exists(o.out / "metrics.csv"));
    EXPECT_FALSE(std::filesystem::exists(o.out / "xapi.json"));
    EXPECT_TRUE(std::filesystem::exists(o.out / "mine.txt"));
    // A folder that is no patient is refused.
    o.patient = folder.path();
    EXPECT_THROW(reportAttempt(o), stylet::DataError);
}

TEST(Debrief, ReportsRecoveredAttempts) {
    const TempFolder folder;
    std::string id;
    {
        stylet::records::Store store(folder.path());
        stylet::records::AttemptInfo info;
        info.trainee = "trainee-A";
        id = store.begin(info);
    }
    ReportOptions o;
    o.records = folder.path(), o.out = folder / "out";
    testing::internal::CaptureStderr();
    reportCohort(o);
    EXPECT_TRUE(
        has(testing::internal::GetCapturedStderr(), "stylet-report: attempt " + id + " was cut short"));
}

// A report on an attempt of ten minutes. Users wait for it and send it by mail, so its time and size matter.
TEST(Debrief, TenMinutesAreReportedInSeconds) {
    const TempFolder folder;
#ifdef STYLET_SANITIZED
    constexpr std::uint64_t kTicks = 60000;
#else
    constexpr std::uint64_t kTicks = 600000;
#endif
    stylet::test::writeAttemptFolder(folder.path(), kTicks);
    const std::clock_t begun = std::clock();
    const LoadedAttempt files = loadAttempt(folder.path());
    const AttemptReport report = attemptReport(files, {});
    const double seconds = double(std::clock() - begun) / CLOCKS_PER_SEC;
    std::printf("%llu ticks: %.2f s of processor time, %.2f MB\n", static_cast<unsigned long long>(kTicks),
                seconds, double(report.html.size()) * 1e-6);
    EXPECT_EQ(files.course.size(), kTicks);
    EXPECT_LT(report.html.size(), 5'000'000u);
#if !defined(STYLET_SANITIZED) && defined(__OPTIMIZE__)
    EXPECT_LT(seconds, 5.0);
#endif
}

}  // namespace
