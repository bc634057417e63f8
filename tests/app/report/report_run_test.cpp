// Runs the programs as users do: make an attempt, then report it.
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "tests/app/records/privacy.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"

namespace {

namespace fs = std::filesystem;
using stylet::test::readText;

struct ProgramResult {
    int status = -1;
    std::string out, err;
};

// One cache for the whole suite, because making the patients takes most of the time.
class ReportRun : public testing::Test {
  protected:
    static void SetUpTestSuite() { command_ = new stylet::test::Command; }
    static void TearDownTestSuite() { delete command_; }
    ProgramResult report(const std::string& arguments) {
        const fs::path out = folder_ / "out", err = folder_ / "err";
        const int status = std::system(("'" + std::string(std::getenv("STYLET_BIN")) + "/stylet-report' " +
                                        arguments + " >'" + out.string() + "' 2>'" + err.string() + "'")
                                           .c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(out), readText(err)};
    }
    stylet::test::TempFolder folder_;
    static inline stylet::test::Command* command_ = nullptr;
};

TEST_F(ReportRun, ReportsAnAttemptFolder) {
    ASSERT_EQ(command_->run("run --fast --scenario demo --spacing-mm 3 --seed 4").status, 0);
    const ProgramResult r =
        report("attempt '" + command_->out().string() + "' --out '" + (folder_ / "r").string() + "'");
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(r.out, (folder_ / "r/attempt.html").string() + "\n");
    const std::string html = readText(folder_ / "r/attempt.html");
    EXPECT_NE(html.find("reference path, exact"), std::string::npos);
    EXPECT_NE(html.find("data:image/png;base64,"), std::string::npos);
    EXPECT_EQ(html.find("What could not be read"), std::string::npos);
    EXPECT_GT(readText(folder_ / "r/course.csv").size(), 10000u);
    EXPECT_FALSE(fs::exists(folder_ / "r/xapi.json"));  // no trainee was given
    // Four ticks per millisecond, on another patient, which other tests make too.
    const fs::path first = command_->out();
    const stylet::test::Outcome fast =
        command_->run("run --fast --spacing-mm 2.5 --rate-hz 4000 --scenario '" +
                      stylet::test::testScenario("short").string() + "'");
    ASSERT_EQ(fast.status, 0) << fast.err;
    const ProgramResult quick =
        report("attempt '" + command_->out().string() + "' --out '" + (folder_ / "q").string() + "'");
    ASSERT_EQ(quick.status, 0) << quick.err;
    const auto tenths = std::llround(fast.summary["haptics"]["ticks"].get<double>() / 400.0);
    const std::string clock = fmt::format("<b>{}:{:02}.{}</b>", tenths / 600, tenths / 10 % 60, tenths % 10);
    EXPECT_NE(readText(folder_ / "q/attempt.html").find(clock), std::string::npos) << clock;
    const auto record = nlohmann::json::parse(readText(command_->out() / "record/record.json"));
    const ProgramResult other =
        report("attempt '" + first.string() + "' --patient '" +
               record["patient"]["folder"].get<std::string>() + "' --out '" + (folder_ / "o").string() + "'");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("is not the one that the attempt was made on"), std::string::npos) << other.err;
    // An attempt may be its own reference.
    const ProgramResult both =
        report("attempt '" + command_->out().string() + "' --reference '" + command_->out().string() +
               "' --out '" + (folder_ / "b").string() + "'");
    ASSERT_EQ(both.status, 0) << both.err;
    EXPECT_NE(readText(folder_ / "b/attempt.html").find("attempt " + command_->out().filename().string()),
              std::string::npos);
}

TEST_F(ReportRun, ReportsAttemptsOfAStore) {
    const std::string store = "--records '" + (folder_ / "store").string() + "'";
    std::string id;
    for (const char* trainee : {"pilot-7", "pilot-7", "pilot-8"}) {
        const stylet::test::Outcome made =
            command_->runBare("run --fast --scenario demo --spacing-mm 3 --seed 4 --trainee " +
                              std::string(trainee) + " " + store);
        ASSERT_EQ(made.status, 0) << made.err;
        const std::size_t at = made.out.find("stored as attempt ");
        ASSERT_NE(at, std::string::npos) << made.out;
        id = made.out.substr(at + 18, made.out.find(' ', at + 18) - at - 18);
    }
    const auto to = [&](const char* name) {
        return " " + store + " --out '" + (folder_ / name).string() + "'";
    };
    ProgramResult r = report("attempt " + id + " --cohort" + to("a"));
    ASSERT_EQ(r.status, 0) << r.err;
    const std::string attempt = readText(folder_ / "a/attempt.html");
    for (const char* text : {"Attempt of pilot-8", "reference path, exact", "the track of its tip", " of 100",
                             "Percentile by points"})
        EXPECT_NE(attempt.find(text), std::string::npos) << text;
    EXPECT_EQ(attempt.find("What could not be read"), std::string::npos);
    EXPECT_NE(readText(folder_ / "a/metrics.csv").find("Total,"), std::string::npos);
    const auto statements = nlohmann::json::parse(readText(folder_ / "a/xapi.json"));
    EXPECT_EQ(statements.size(), 4u);
    r = report("trainee pilot-7" + to("t"));
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NE(readText(folder_ / "t/trainee.html").find("2 attempts, 2 of them finished"), std::string::npos);
    r = report("cohort --scenario demo" + to("c"));
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NE(readText(folder_ / "c/cohort.html").find("3 attempts of 2 trainees"), std::string::npos);
    r = report("attempt no-such-attempt" + to("n"));
    EXPECT_EQ(r.status, 2);
    // A result that was changed by hand is no longer the stored one.
    const fs::path record = folder_ / "store" / "attempts" / id / "record" / "record.json";
    std::string json = readText(record);
    const std::string hit = "\"target_hit\": true";
    ASSERT_NE(json.find(hit), std::string::npos);
    json.replace(json.find(hit), hit.size(), "\"target_hit\":false");
    std::ofstream(record) << json;
    for (const std::string& options : {"attempt " + id, "attempt " + id + " --reference " + id}) {
        r = report(options + to("e"));
        EXPECT_EQ(r.status, 2);
        EXPECT_NE(r.err.find("record.json: its checksum does not match"), std::string::npos) << r.err;
        EXPECT_FALSE(fs::exists(folder_ / "e/attempt.html"));
    }
}

// A trainee's attempt made, exported and reported by the programs, with a umask that allows everything.
// HZ-RECORD-10, HZ-TEACH-20
TEST_F(ReportRun, StoredAndExportedAttemptsHaveTheSameReportAndArePrivate) {
    const std::string open = "umask 000; ", store = "'" + (folder_ / "store").string() + "'";
    const stylet::test::Outcome made = command_->runBare(
        "run --fast --headless --scenario demo --spacing-mm 3 --seed 4 --trainee pilot-7 --records " + store,
        open);
    ASSERT_EQ(made.status, 0) << made.err;
    EXPECT_EQ(stylet::test::openEntries(folder_ / "store"), "");
    const std::string id = fs::directory_iterator(folder_ / "store/attempts")->path().filename().string();
    ASSERT_EQ(
        command_
            ->runBare("records export --records " + store + " '" + (folder_ / "taken").string() + "'", open)
            .status,
        0);
    EXPECT_EQ(stylet::test::openEntries(folder_ / "taken"), "");
    const auto written = [&](const std::string& attempt) {
        fs::remove_all(folder_ / "page");
        const ProgramResult r = report("attempt " + attempt + " --records " + store + " --out '" +
                                       (folder_ / "page").string() + "'");
        EXPECT_EQ(r.status, 0) << r.err;
        EXPECT_EQ(stylet::test::openEntries(folder_ / "page"), "");
        std::map<std::string, std::string> files;
        for (const auto& file : fs::directory_iterator(folder_ / "page"))
            files[file.path().filename().string()] = readText(file.path());
        return files;
    };
    const auto stored = written(id);
    EXPECT_EQ(stored.size(), 5u);
    EXPECT_NE(stored.at("attempt.html").find("the track of its tip"), std::string::npos) << "with slices";
    EXPECT_EQ(written("'" + (folder_ / "taken/attempts" / id).string() + "'"), stored);
    for (const auto& file : fs::directory_iterator(folder_ / "store/attempts" / id))
        if (file.is_regular_file()) std::ofstream(file.path()) << "garbage";
    EXPECT_EQ(written(id), stored) << "exports are not read";
}

TEST_F(ReportRun, InvalidArgumentsAreReported) {
    const std::string out = " --out '" + (folder_ / "r").string() + "'";
    ProgramResult r = report("attempt '" + folder_.path().string() + "'" + out);
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("record/record.json: file: "), std::string::npos) << r.err;
    r = report("cohort --records '" + folder_.path().string() + "'" + out);
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("store: does not exist"), std::string::npos) << r.err;
    r = report("trainee 'Jane Doe'" + out);
    EXPECT_EQ(r.status, 2);
    EXPECT_GE(report("nonsense").status, 100);
    EXPECT_GE(report("attempt x").status, 100);
    EXPECT_FALSE(fs::exists(folder_ / "r"));
}

}  // namespace
