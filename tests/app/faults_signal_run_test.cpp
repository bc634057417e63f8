// Sends signals to programs at each stage of their work.
#include "tests/app/faults_run.h"

#include <sys/stat.h>

namespace stylet {
namespace {

namespace fs = std::filesystem;
using test::readText;

TEST_F(FaultsRun, ASignalWhileThePatientIsMade) {
    cell("stylet run", "SIGTERM, SIGINT, SIGKILL: patient is made", "ends; the next start generates it");
    for (const int signal : {SIGTERM, SIGINT, SIGKILL}) {
        const fs::path cache = in("cache-signal-" + std::to_string(signal));
        Started s = start("stylet run --fast --spacing-mm 2 --scenario demo --out none",
                          "XDG_CACHE_HOME=" + cache.string());
        ASSERT_TRUE(s.says("making the reference patient"));
        kill(s.pid, signal);
        EXPECT_EQ(s.result(), -signal);
        for (const auto& entry : fs::directory_iterator(cache / "stylet/patients"))
            EXPECT_TRUE(entry.path().filename().string().starts_with(".")) << entry.path();
        if (signal == SIGTERM) expectWorks("XDG_CACHE_HOME=" + cache.string());
        fs::remove_all(cache);
    }
}

// HZ-RECORD-01
TEST_F(FaultsRun, ASignalInThePuncture) {
    cell("stylet run", "SIGTERM, SIGINT, SIGHUP: in the attempt",
         "reported as cut short; the recorded part replays");
    std::size_t cut = 0;
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
        Started s = start("stylet run --headless --spacing-mm 5 --scenario demo --trainee T-5");
        const auto record = [&] {
            for (const auto& entry :
                 fs::recursive_directory_iterator(in("home/.local/share/stylet/records/attempts")))
                if (entry.path().filename() == "inputs.bin" &&
                    !fs::exists(entry.path().parent_path() / "seen"))
                    if (readText(entry.path().parent_path() / "record.json").find("final_tick") ==
                            std::string::npos &&
                        fs::file_size(entry.path()) > 30'000)
                        return entry.path();
            return fs::path();
        };
        ASSERT_TRUE(s.waitFor([&] { return !record().empty(); }));
        const fs::path inputs = record();
        ASSERT_FALSE(inputs.empty()) << readText(s.err);
        kill(s.pid, signal);
        EXPECT_EQ(s.result(), -signal);
        std::ofstream(inputs.parent_path() / "seen");
        EXPECT_EQ(run("stylet records list"), 0) << err_;
        expectSaid("was cut short");
        EXPECT_EQ(run("stylet replay '" + inputs.parent_path().string() + "' --fast --out again"), 0) << err_;
        const auto attempts = storedOf("T-5");
        EXPECT_EQ(attempts.size(), ++cut);
        for (const auto& attempt : attempts)
            EXPECT_EQ(attempt.state, records::AttemptState::cut_short);
    }
    expectKept();
}

// summary.json is a pipe without a reader, so the program blocks while writing its results.
TEST_F(FaultsRun, ASignalWhileResultsAreWritten) {
    cell("stylet run", "SIGTERM, SIGKILL: results are written", "the record is whole");
    for (const int signal : {SIGTERM, SIGKILL}) {
        const std::string out = "results-" + std::to_string(signal);
        fs::create_directories(in(out));
        ASSERT_EQ(mkfifo((in(out) / "summary.json").c_str(), 0600), 0);
        Started s = start(kAttempt + "--out " + out);
        ASSERT_TRUE(s.waitFor([&] { return fs::exists(in(out) / "slices.png"); }));
        EXPECT_FALSE(s.over()) << readText(s.err);
        kill(s.pid, signal);
        EXPECT_EQ(s.result(), -signal);
        EXPECT_EQ(run("stylet replay " + out + "/record --fast --out again"), 0) << err_;
        EXPECT_EQ(hashIn("again"), hash_);
    }
}

TEST_F(FaultsRun, ASignalInAReplay) {
    cell("stylet replay", "SIGTERM, SIGINT, SIGKILL: as it begins", "ends; the record is untouched");
    // An attempt that takes long in real time.
    ASSERT_EQ(run("stylet run --fast --spacing-mm 5 --scenario demo --out slow"), 0) << err_;
    const auto record = [] {
        return readText(in("slow/record/inputs.bin")) + readText(in("slow/record/record.json"));
    };
    const std::string before = record();
    for (const int signal : {SIGTERM, SIGINT, SIGKILL}) {
        fs::remove_all(in("replayed"));
        Started s = start("stylet replay slow/record --out replayed");
        ASSERT_TRUE(s.waitFor([&] { return fs::exists(in("replayed")); }));
        kill(s.pid, signal);
        EXPECT_EQ(s.result(), -signal);
    }
    EXPECT_EQ(record(), before);
    EXPECT_EQ(run("stylet replay slow/record --fast --out replayed"), 0) << err_;
}

// HZ-RECORD-02
TEST_F(FaultsRun, ASignalAtEachStageOfAPatientFromASeed) {
    cell("stylet-model synth", "SIGTERM: each stage, each file, at the end",
         "ends; no package appears, an older one stays");
    const std::string synth = "stylet-model synth --seed 4 --spacing-mm 5 --threads 1 --out ";
    ASSERT_EQ(run(synth + "seeded"), 0) << err_;
    const auto stages = std::count(err_.begin(), err_.end(), '\n');
    EXPECT_GE(stages, 10);
    std::vector<std::string> moments{"open patient.toml", "open ct.nii.gz", "open labels.nii.gz",
                                     "open motion.nii.gz"};
    for (int stage = 1; stage <= stages; ++stage)
        moments.push_back("word " + std::to_string(stage));
    std::vector<Started> all;
    for (std::size_t i = 0; i < moments.size(); ++i)
        all.push_back(start(synth + "stopped/" + std::to_string(i), stoppedAt(moments[i])));
    all.push_back(start(synth + "stopped/end", stoppedAt("rename end")));
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(all[i].result(), -SIGTERM) << i << readText(all[i].err);
        EXPECT_FALSE(fs::exists(in("stopped") / (i < moments.size() ? std::to_string(i) : "end")));
    }
    EXPECT_EQ(run("stylet-model check stopped/end"), 2);
    expectSaid("stopped/end/patient.toml");
    // The same with an older package in the target folder.
    fs::copy(in("seeded"), in("older"));
    EXPECT_EQ(run("stylet-model synth --seed 5 --spacing-mm 5 --out older", stoppedAt("rename older")),
              -SIGTERM);
    expectSame("older", "seeded");
    EXPECT_EQ(run(synth + "stopped/end"), 0) << err_;
    expectSame("stopped/end", "seeded");
}

TEST_F(FaultsRun, ASignalAtEachStageOfAStudy) {
    cell("study plan, run", "SIGTERM: as each of its files is written",
         "no report; the next run completes the study");
    needStudy();
    ASSERT_EQ(run("stylet-study all " + kStudy + "study-whole"), 0) << err_;
    fs::copy(in("study-whole"), in("study-cut"), fs::copy_options::recursive);
    const auto cut = [&](const char* command, const std::string& moment) {
        EXPECT_EQ(run(std::string("stylet-study ") + command + " " + kStudy + "study-cut", stoppedAt(moment)),
                  -SIGTERM)
            << moment;
        fs::remove(in("study-cut/report.html"));  // report of the earlier study
        EXPECT_EQ(run("stylet-study report study-cut"), 2) << moment;
        expectSaid("study-cut/summary.json: file: cannot be read: plan and run the study first");
        expectWholeFiles("study-cut", "study-whole");
    };
    for (const char* file : {"plan.csv", "plan.json", "paths.png", "paths.json"})
        cut("plan", std::string("rename ") + file);
    fs::remove_all(in("study-cut/one/blocks"));  // the blocks belong to the same paths
    EXPECT_FALSE(fs::exists(in("study-cut/one/paths.json")));
    for (const char* file : {"paths.json", "pair.json", "000000.results", "paths.csv", "summary.json"})
        cut("run", std::string("rename ") + file);
    EXPECT_EQ(run("stylet-study all " + kStudy + "study-cut"), 0) << err_;
    expectSame("study-cut", "study-whole");
}

TEST_F(FaultsRun, ASignalAtEachStageOfADebrief) {
    cell("stylet-report", "SIGTERM: as each of its files is written",
         "whole files only; the next run writes them again");
    ASSERT_EQ(run("stylet-report attempt ref --out debrief"), 0) << err_;
    for (const char* moment : {"open attempt.html.new", "rename attempt.html", "rename course.csv",
                               "rename events.csv", "rename metrics.csv"}) {
        EXPECT_EQ(run("stylet-report attempt ref --out debrief-cut", stoppedAt(moment)), -SIGTERM) << moment;
        expectWholeFiles("debrief-cut", "debrief");
    }
    EXPECT_EQ(run("stylet-report attempt ref --out debrief-cut"), 0) << err_;
    for (const auto& entry : fs::directory_iterator(in("debrief-cut")))
        EXPECT_NE(entry.path().extension(), ".new");
    expectSame("debrief-cut", "debrief");
}

}  // namespace
}  // namespace stylet
