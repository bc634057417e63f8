// Runs complete programs in hostile conditions. The test prints a matrix and writes it to
// build/PRESET/faults.md. Each cell names a program, a fault and the expected outcome: a message with file
// and reason, an exit status, no stored data lost, and a working next start. The timing is deterministic: a
// signal is sent after a given output, a given file, or when the program blocks on a pipe without a reader.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "app/records/store.h"
#include "tests/app/study/pairs.h"
#include "tests/support/decimal_comma.h"
#include "tests/support/file_text.h"
#include "tests/support/temp_folder.h"

namespace stylet {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using test::textOf;

struct Row {
    std::string program, fault, outcome;
    bool failed = false;
};
std::vector<Row> matrix;

// Faults of complete programs that other tests cover.
const std::vector<Row> kElsewhere{
    {"stylet run", "SIGKILL at any instant", "StoreRun.KilledItLeavesWholeFramesOrNothing"},
    {"stylet run", "SIGTERM, SIGHUP, SIGQUIT, SIGTSTP with a device",
     "FalconRunRealTime.ASignalWhileItPushesEndsInZero"},
    {"stylet run", "device, headset, display, runtime lost",
     "DeviceRunRealTime, HeadsetRun, WindowRun, RunWithPictures.ADeviceThatIsLost..."},
    {"stylet run", "stale or damaged paths.json", "Run.StoredPathsOfAnotherTable..."},
    {"stylet run", "folder that cannot be made, bad scenario", "Run.AFolderThat..., Run.ABadScenario..."},
    {"stylet records", "a real disk that is full", "DiskFull.OfARealDisk, DiskFull.DeletingMakesRoom"},
    {"stylet-model build", "stopped between or within stages",
     "StageStoreTest, BuildRun.ASecondRunKeepsEverything"},
    {"stylet register", "SIGTERM, SIGINT at its stages; a decimal comma", "RegisterRunRealTime"},
    {"stylet-study run", "a process killed, failed", "StudyRun.ALostRank..., StudyRun.ARankThat..."},
};

class PrintMatrix : public testing::Environment {
    void TearDown() override {
        const auto print = [](const Row& row, const char* state) {
            std::printf("  %-18s %-46s %-8s %s\n", row.program.c_str(), row.fault.c_str(), state,
                        row.outcome.c_str());
        };
        std::printf("\nfault matrix\n");
        for (const Row& row : matrix)
            print(row, row.failed ? "FAILED" : "ok");
        for (const Row& row : kElsewhere)
            print(row, "see");
        std::ofstream table(STYLET_MATRIX);
        table << "# Fault matrix\n\nWhole programs in rough surroundings, as faults_run_test found them: "
                 "what was "
                 "done to which, and what comes of it.\n\n| program | fault | what happens | shown |\n"
                 "|---|---|---|---|\n";
        const auto line = [&](const Row& row, const std::string& outcome, const std::string& shown) {
            table << "| " << row.program << " | " << row.fault << " | " << outcome << " | " << shown
                  << " |\n";
        };
        for (const Row& row : matrix)
            line(row, row.outcome, row.failed ? "**FAILED**" : "ok");
        for (const Row& row : kElsewhere)
            line(row, "see the test", "`" + row.outcome + "`");
    }
};
const auto* const kPrinted = testing::AddGlobalTestEnvironment(new PrintMatrix);

bool until(const std::function<bool()>& done) {
    for (const auto begin = std::chrono::steady_clock::now(); !done(); std::this_thread::sleep_for(5ms))
        if (std::chrono::steady_clock::now() > begin + 120s) return false;
    return true;
}

// A running program. Its output goes to files, or where the shell line redirects it.
struct Started {
    pid_t pid = -1;
    fs::path out, err;
    bool ended = false;
    int status = 0;
    bool over() {
        if (!ended) ended = waitpid(pid, &status, WNOHANG) == pid;
        return ended;
    }
    bool says(const std::string& words) {
        return until([&] { return textOf(err).find(words) != std::string::npos || over(); }) &&
               textOf(err).find(words) != std::string::npos;
    }
    void wait() {
        if (!ended) waitpid(pid, &status, 0);
        ended = true;
    }
    // Exit status, or minus the signal number.
    int result() {
        wait();
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
};

class FaultsRun : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        box_ = new test::TempFolder;
        ASSERT_EQ(run(kAttempt + "--trainee T-1 --difficulty practice"), 0) << err_;
        ASSERT_EQ(run(kAttempt + "--out ref"), 0) << err_;
        hash_ = hashIn("ref");
    }
    static void TearDownTestSuite() { delete box_; }
    void TearDown() override {
        // Also resets what a failed test left behind.
        within_.clear(), variables_.clear();
        if (locked_) [[maybe_unused]]
            const int open = std::system(("chmod -R u+w '" + in("only").string() + "'").c_str());
        locked_ = false;
        if (!row_.program.empty()) matrix.push_back({row_.program, row_.fault, row_.outcome, HasFailure()});
    }
    void cell(const char* program, const char* fault, const char* outcome) {
        row_ = {program, fault, outcome};
    }

    static fs::path in(const std::string& name) { return *box_ / name; }
    static std::string program(const std::string& name) {
        return std::string(std::getenv("STYLET_BIN")) + "/" + name;
    }
    // Starts a shell line in the temporary folder: `before` (variables, traps), then the program with its
    // arguments.
    static Started start(const std::string& arguments, const std::string& before = "",
                         const std::string& after = "") {
        Started s;
        static int number = 0;
        s.out = in("out" + std::to_string(++number)), s.err = in("err" + std::to_string(number));
        const std::string line = "cd '" + box_->path().string() + "' && " + before + " exec " + within_ +
                                 " env " + variables_ + " " + program("") + arguments + " >'" +
                                 s.out.string() + "' 2>'" + s.err.string() + "' " + after;
        s.pid = fork();
        if (s.pid == 0) {
            for (const char* name : {"HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", "LC_ALL", "LANG", "DISPLAY"})
                unsetenv(name);
            setenv("HOME", in("home").c_str(), 1);
            setenv("XR_RUNTIME_JSON", "/nonexistent/runtime.json", 1);
            execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
            _exit(127);
        }
        return s;
    }
    static int run(const std::string& arguments, const std::string& before = "",
                   const std::string& after = "") {
        Started s = start(arguments, before, after);
        const int result = s.result();
        said_ = textOf(s.out), err_ = textOf(s.err);
        return result;
    }
    static nlohmann::json summaryIn(const std::string& folder) {
        return nlohmann::json::parse(textOf(in(folder) / "summary.json"));
    }
    static std::string hashIn(const std::string& folder) { return summaryIn(folder).at("state_hash"); }
    // Expects that an attempt still gives the same hash as the first run.
    static void expectWorks(const std::string& variables = "") {
        const std::string before = variables_;
        variables_ += " " + variables;
        EXPECT_EQ(run(kAttempt + "--out works"), 0) << err_;
        EXPECT_EQ(hashIn("works"), hash_);
        fs::remove_all(in("works"));
        variables_ = before;
    }
    static std::vector<records::StoredAttempt> storedOf(const std::string& trainee) {
        const records::Store store(in("home/.local/share/stylet/records"));
        EXPECT_TRUE(store.damage().empty());
        return store.attempts(trainee);
    }
    // Expects that no stored attempt is lost.
    static void expectKept(const std::string& trainee = "T-1", std::size_t count = 1) {
        const auto attempts = storedOf(trainee);
        EXPECT_EQ(attempts.size(), count);
        for (const records::StoredAttempt& attempt : attempts)
            EXPECT_EQ(attempt.state, records::AttemptState::done);
    }
    static void expectSaid(const std::string& words) {
        EXPECT_NE(err_.find(words), std::string::npos) << err_;
    }
    static fs::path patient() { return *fs::directory_iterator(in("home/.cache/stylet/patients")); }
    // Creates a small and coarse study: one pair of packages from the same CT.
    static void needStudy() {
        if (fs::exists(in("study.toml"))) return;
        ASSERT_EQ(run("stylet-model synth --seed 1 --spacing-mm 4 --out truth"), 0) << err_;
        patient::savePackage(test::movedAndCut(patient::loadPackage(in("truth"))), in("built"));
        std::ofstream(in("study.toml")) << "[[pair]]\nname = 'one'\nreference = 'truth'\nfound = 'built'\n";
    }
    static inline const std::string kStudy = "study.toml --skin-spacing-mm 12.5 --threads 1 --out ";

    // Variables that stop the next program at this point (rough_surroundings.cpp).
    static std::string stoppedAt(const std::string& moment) {
        return "STYLET_TEST_SIGNAL=15 STYLET_TEST_AT='" + moment + "' LD_PRELOAD=" STYLET_ROUGH;
    }
    static std::vector<fs::path> filesIn(const std::string& folder) {
        std::vector<fs::path> files;
        for (const auto& entry : fs::recursive_directory_iterator(in(folder)))
            if (entry.is_regular_file() && entry.path().extension() != ".new")
                files.push_back(entry.path().lexically_relative(in(folder)));
        std::sort(files.begin(), files.end());
        return files;
    }
    // Expects that every file left by a stopped run equals that of an undisturbed run.
    static void expectWholeFiles(const std::string& left, const std::string& undisturbed) {
        if (!fs::exists(in(left))) return;
        for (const fs::path& file : filesIn(left))
            EXPECT_TRUE(textOf(in(left) / file) == textOf(in(undisturbed) / file)) << file;
    }
    static void expectSame(const std::string& a, const std::string& b) {
        EXPECT_EQ(filesIn(a), filesIn(b));
        expectWholeFiles(a, b);
    }
    static std::string full() { return "trap '' XFSZ; ulimit -f 60;"; }  // per file, in the shell's blocks

    static inline const std::string kAttempt = "stylet run --fast --spacing-mm 5 --scenario demo ";
    static inline test::TempFolder* box_ = nullptr;
    static inline std::string variables_, within_, hash_, said_, err_;
    static inline bool locked_ = false;  // the folder "only" is read-only
    Row row_;
};

// The outcome has the form "Suite.Name, Suite.Beginning..., Suite".
TEST(FaultMatrix, TestsElsewhereAreThere) {
    std::string tests;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(STYLET_SOURCE_DIR) / "tests"))
        if (entry.path().extension() == ".cpp") tests += textOf(entry.path());
    for (const Row& row : kElsewhere) {
        std::string names = row.outcome + ",";
        for (std::size_t end; (end = names.find(',')) != std::string::npos; names.erase(0, end + 2)) {
            const std::string name = names.substr(0, names.find("...") < end ? names.find("...") : end);
            const std::size_t dot = name.find('.');
            const std::string begin = dot == std::string::npos
                                          ? "(" + name + ", "
                                          : "(" + name.substr(0, dot) + ", " + name.substr(dot + 1);
            EXPECT_NE(tests.find(begin), std::string::npos) << row.program << ": " << name;
        }
    }
}

TEST_F(FaultsRun, NoHome) {
    cell("stylet run", "no HOME, or no environment at all", "works, cache in the temporary folder");
    fs::create_directories(in("tmp"));
    expectWorks("-u HOME TMPDIR=" + in("tmp").string());
    EXPECT_TRUE(fs::exists(in("tmp/stylet/patients")));
    expectWorks("-i TMPDIR=" + in("tmp").string());
}

TEST_F(FaultsRun, AHomeThatTakesNothing) {
    cell("stylet run", "a HOME that takes nothing", "says which folder and why; a given patient works");
    EXPECT_EQ(run(kAttempt + "--out none", "HOME=/proc/nothing"), 2);
    expectSaid("/proc/nothing/.cache/stylet/patients");
    expectSaid("cannot be made: No such file");
    EXPECT_EQ(run(kAttempt + "--trainee T-2", "HOME=/proc/nothing"), 2);
    expectSaid("/proc/nothing/.local/share/stylet/records");
    EXPECT_EQ(run(kAttempt + "--out given --patient '" + patient().string() + "'", "HOME=/proc/nothing"), 0)
        << err_;
    EXPECT_EQ(hashIn("given"), hash_);
}

// HZ-RECORD-15
TEST_F(FaultsRun, ALocaleOfAnotherCountryOrOfNone) {
    cell("all that has numbers", "a decimal comma, switched on; xx_YY.UTF-8", "every number as without");
    const auto country = test::decimalComma(in("locales"), STYLET_ROUGH);
    if (country.empty()) GTEST_SKIP() << "localedef knows no de_DE: the package locales is missing";
    std::string german;
    for (const auto& [name, value] : country)
        german += name + "='" + value + "' ";
    needStudy();
    const std::string unknown = "LC_ALL=xx_YY.UTF-8 LANG=xx_YY.UTF-8";
    // Runs a line in all three locales at once. The output and the files must be the same.
    const auto three = [&](const std::string& line, const std::string& out,
                           const std::vector<std::string>& files = {}, int status = 0) {
        const std::string to = out.empty() ? "" : " --out " + out;
        Started plain = start(line + (out.empty() ? "" : to + "-c"));
        Started comma = start(line + (out.empty() ? "" : to + "-de"), german);
        Started none = start(line + (out.empty() ? "" : to + "-xx"), unknown);
        EXPECT_EQ(plain.result(), status) << line << textOf(plain.err);
        EXPECT_EQ(comma.result(), status) << line << textOf(comma.err);
        EXPECT_EQ(none.result(), status) << line << textOf(none.err);
        for (const std::string& file : files) {
            const std::string text = textOf(in(out + "-c") / file);
            EXPECT_FALSE(text.empty()) << file;
            EXPECT_TRUE(textOf(in(out + "-de") / file) == text) << file;
            EXPECT_TRUE(textOf(in(out + "-xx") / file) == text) << file;
        }
        if (!out.empty()) return;
        EXPECT_FALSE(textOf(plain.out).empty());
        EXPECT_EQ(textOf(comma.out), textOf(plain.out));
        EXPECT_EQ(textOf(none.out), textOf(plain.out));
    };
    three("stylet run --fast --spacing-mm 5.0 --seed 1 --scenario demo --rate-hz 1000.0", "run",
          {"force-depth.csv", "record/inputs.bin"});
    nlohmann::json plain = summaryIn("run-c"), comma = summaryIn("run-de"), none = summaryIn("run-xx");
    for (nlohmann::json* summary : {&plain, &comma, &none}) {
        summary->at("haptics").erase("max_step_us");
        summary->erase("start");  // durations
    }
    EXPECT_EQ(plain, comma);
    EXPECT_EQ(plain, none);
    three("stylet-model synth --seed 2 --spacing-mm 4.5", "patient",
          {"patient.toml", "labels.ctbl", "ct.nii.gz"});
    three("stylet-model check truth", "", {}, 1);  // too coarse for training
    three("stylet records list", "");
    three("stylet-report attempt ref", "report", {"attempt.html", "course.csv", "metrics.csv"});
    three("stylet-report trainee T-1", "report", {"trainee.html", "attempts.csv", "xapi.json"});
    three("stylet-report cohort", "report", {"cohort.html"});
    three("stylet-study all --sampled-paths 1 study.toml --skin-spacing-mm 12.5", "study",
          {"one/plan.csv", "one/plan.json", "one/paths.json", "one/paths.csv", "one/samples.csv",
           "summary.json", "report.html"});

    // Build stages written under one locale are reused under another.
    const std::string build =
        "stylet-model build --ct truth/ct.nii.gz --atlas patient-c --spacing-mm 4.0 --stages stages";
    EXPECT_EQ(run(build + " --out build-de", german), 0) << err_;
    EXPECT_EQ(run(build + " --out build-c"), 0) << err_;
    EXPECT_NE(said_.find("kept"), std::string::npos) << said_;
    EXPECT_EQ(filesIn("build-c").size(), 5u);
    expectSame("build-c", "build-de");
}

// HZ-RECORD-05
TEST_F(FaultsRun, AWallClockThatLeaps) {
    cell("stylet run", "a wall clock that leaps by days", "the same hash; stored");
    EXPECT_EQ(run(kAttempt + "--trainee T-3", "STYLET_TEST_CLOCK=1 LD_PRELOAD=" STYLET_ROUGH), 0) << err_;
    expectKept("T-3");
    EXPECT_EQ(run("stylet records list", "STYLET_TEST_CLOCK=1 LD_PRELOAD=" STYLET_ROUGH), 0) << err_;
    EXPECT_NE(said_.find("T-3"), std::string::npos) << said_;
    EXPECT_EQ(nlohmann::json::parse(textOf(storedOf("T-3")[0].folder / "summary.json")).at("state_hash"),
              hash_);
}

TEST_F(FaultsRun, ASignalWhileThePatientIsMade) {
    cell("stylet run", "SIGTERM, SIGINT, SIGKILL: patient is made", "ends; the next start makes it");
    for (const int signal : {SIGTERM, SIGINT, SIGKILL}) {
        const std::string cache = "cache-signal-" + std::to_string(signal);
        Started s =
            start("stylet run --fast --spacing-mm 2 --scenario demo --out none", "XDG_CACHE_HOME=" + cache);
        ASSERT_TRUE(s.says("making the reference patient"));
        kill(s.pid, signal);
        EXPECT_EQ(s.result(), -signal);
        for (const auto& entry : fs::directory_iterator(in(cache + "/stylet/patients")))
            EXPECT_TRUE(entry.path().filename().string().starts_with(".")) << entry.path();
        if (signal == SIGTERM) expectWorks("XDG_CACHE_HOME=" + cache);
        fs::remove_all(in(cache));
    }
}

// HZ-RECORD-01
TEST_F(FaultsRun, ASignalInThePuncture) {
    cell("stylet run", "SIGTERM, SIGINT, SIGHUP: in the attempt",
         "cut short, said so, replays as far as it goes");
    std::size_t cut = 0;
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
        Started s = start("stylet run --headless --spacing-mm 5 --scenario demo --trainee T-5");
        const auto record = [&] {
            for (const auto& entry :
                 fs::recursive_directory_iterator(in("home/.local/share/stylet/records/attempts")))
                if (entry.path().filename() == "inputs.bin" &&
                    !fs::exists(entry.path().parent_path() / "seen"))
                    if (textOf(entry.path().parent_path() / "record.json").find("final_tick") ==
                            std::string::npos &&
                        fs::file_size(entry.path()) > 30'000)
                        return entry.path();
            return fs::path();
        };
        ASSERT_TRUE(until([&] { return !record().empty() || s.over(); }));
        const fs::path inputs = record();
        ASSERT_FALSE(inputs.empty()) << textOf(s.err);
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
        ASSERT_TRUE(until([&] { return fs::exists(in(out) / "slices.png") || s.over(); }));
        EXPECT_FALSE(s.over()) << textOf(s.err);
        kill(s.pid, signal);
        EXPECT_EQ(s.result(), -signal);
        EXPECT_EQ(run("stylet replay " + out + "/record --fast --out again"), 0) << err_;
        EXPECT_EQ(hashIn("again"), hash_);
    }
}

TEST_F(FaultsRun, ASignalInAReplay) {
    cell("stylet replay", "SIGTERM, SIGINT, SIGKILL: as it begins", "ends; the record is untouched");
    const std::string before = textOf(in("ref/record/inputs.bin")) + textOf(in("ref/record/record.json"));
    for (const int signal : {SIGTERM, SIGINT, SIGKILL}) {
        fs::remove_all(in("replayed"));
        Started s = start("stylet replay ref/record --out replayed");
        ASSERT_TRUE(until([&] { return fs::exists(in("replayed")) || s.over(); }));
        kill(s.pid, signal);
        EXPECT_EQ(s.result(), -signal);
    }
    EXPECT_EQ(textOf(in("ref/record/inputs.bin")) + textOf(in("ref/record/record.json")), before);
    EXPECT_EQ(run("stylet replay ref/record --fast --out replayed"), 0) << err_;
}

// HZ-RECORD-02
TEST_F(FaultsRun, ASignalAtEachStageOfAPatientFromASeed) {
    cell("stylet-model synth", "SIGTERM: each stage, each file, at the end",
         "dies of it; no package is there, the old one stays");
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
        EXPECT_EQ(all[i].result(), -SIGTERM) << i << textOf(all[i].err);
        EXPECT_FALSE(fs::exists(in("stopped") / (i < moments.size() ? std::to_string(i) : "end")));
    }
    EXPECT_EQ(run("stylet-model check stopped/end"), 2);
    expectSaid("stopped/end/patient.toml");
    // With an older package in its place.
    fs::copy(in("seeded"), in("older"));
    EXPECT_EQ(run("stylet-model synth --seed 5 --spacing-mm 5 --out older", stoppedAt("rename older")),
              -SIGTERM);
    expectSame("older", "seeded");
    EXPECT_EQ(run(synth + "stopped/end"), 0) << err_;
    expectSame("stopped/end", "seeded");
}

TEST_F(FaultsRun, ASignalAtEachStageOfAStudy) {
    cell("study plan, run", "SIGTERM: as each of its files is written",
         "no report of it; the next run is as undisturbed");
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
    fs::remove_all(in("study-cut/one/blocks"));  // they belong to the same paths
    EXPECT_FALSE(fs::exists(in("study-cut/one/paths.json")));
    for (const char* file : {"paths.json", "pair.json", "000000.results", "paths.csv", "summary.json"})
        cut("run", std::string("rename ") + file);
    EXPECT_EQ(run("stylet-study all " + kStudy + "study-cut"), 0) << err_;
    expectSame("study-cut", "study-whole");
}

TEST_F(FaultsRun, ASignalAtEachStageOfADebrief) {
    cell("stylet-report", "SIGTERM: as each of its files is written", "whole files only; made anew");
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

// Uses a read-only mount in the test's own child process if the machine allows it. Otherwise it removes
// write permission from the folder, and root also drops its capability to override it.
TEST_F(FaultsRun, AFileSystemThatIsOnlyRead) {
    cell("every program", "a read-only mount", "reads what is there; else the file and the reason");
    needStudy();
    ASSERT_EQ(run(kAttempt + "--out only/attempt"), 0) << err_;
    fs::copy(in("truth"), in("only/truth"));
    fs::copy(in("home"), in("only/home"), fs::copy_options::recursive);
    ASSERT_EQ(run("stylet-study all " + kStudy + "only/study"), 0) << err_;
    const std::string only = "'" + in("only").string() + "'";
    std::string reason = "Read-only file system";
    within_ =
        "unshare -rm sh -c 'mount --bind \"$0\" \"$0\" && mount -o remount,bind,ro \"$0\" && "
        "cd \"$PWD\" && exec \"$@\"' " +
        only;
    const bool mounted = std::system((within_ + " true 2>/dev/null").c_str()) == 0;
    if (!mounted) {
        std::printf("no mount can be made here: a folder without the right to write in its place\n");
        reason = "Permission denied";
        within_ = geteuid() == 0 ? "setpriv --inh-caps=-dac_override --bounding-set=-dac_override" : "";
        if (!within_.empty() && std::system((within_ + " true 2>/dev/null").c_str()) != 0)
            GTEST_SKIP() << "this root can neither mount nor give up its power over files";
        locked_ = true;
        ASSERT_EQ(std::system(("chmod -R a-w " + only).c_str()), 0);
    }
    const auto refused = [&](const std::string& line, const std::string& file) {
        EXPECT_EQ(run(line, "HOME=" + only + "/home"), 2) << line;
        expectSaid(file);
        expectSaid(reason);
    };
    refused(kAttempt + "--out only/x", "only/x");
    refused(kAttempt + "--trainee T-1", "only/home/.local/share/stylet/records: ");
    variables_ = "XDG_CACHE_HOME=" + in("only/cache").string();
    refused(kAttempt + "--out none", "only/cache/stylet/patients");
    variables_.clear();
    refused("stylet records list", "only/home/.local/share/stylet/records: ");
    refused("stylet replay only/attempt/record --fast --out only/x", "only/x");
    refused("stylet-report attempt only/attempt --out only/attempt", "only/attempt/");
    refused("stylet-report cohort --out none", "only/home/.local/share/stylet/records: ");
    refused("stylet-model synth --spacing-mm 5 --out only/x", "only/.x");
    refused("stylet-model synth --spacing-mm 5 --out only/truth", "only/.truth");
    refused("stylet-model build --ct truth/ct.nii.gz --atlas truth --spacing-mm 4 --out only/x",
            "only/x-stages");
    refused("stylet-study plan " + kStudy + "only/x", "only/x");
    refused("stylet-study run " + kStudy + "only/study", "only/study/");
    refused("stylet-study report only/study", "only/study/report.html");
    const auto works = [&](const std::string& line) {
        EXPECT_EQ(run(line, "HOME=" + only + "/home"), 0) << line << err_;
    };
    works(kAttempt + "--out read");
    EXPECT_EQ(hashIn("read"), hash_);
    works("stylet replay only/attempt/record --fast --out read");
    EXPECT_EQ(hashIn("read"), hash_);
    works("stylet-report attempt only/attempt --out read");
    works("stylet-study plan " + kStudy + "read-study");
}

TEST_F(FaultsRun, NobodyReads) {
    cell("run, records", "both outputs to a pipe that is closed", "the attempt goes on and is stored");
    const auto intoNothing = [&](const std::string& line) {
        std::array<int, 2> pipe{};
        EXPECT_EQ(pipe2(pipe.data(), 0), 0);
        close(pipe[0]);
        Started s = start(line, "", ">&" + std::to_string(pipe[1]) + " 2>&1");
        close(pipe[1]);
        return s.result();
    };
    EXPECT_EQ(intoNothing(kAttempt + "--trainee T-6"), 0);
    expectKept("T-6");
    EXPECT_EQ(intoNothing("stylet records list"), 0);
}

TEST_F(FaultsRun, APipeThatIsFull) {
    cell("stylet run", "errors to a pipe that is full", "waits until it is read; stored");
    std::array<int, 2> pipe{};
    ASSERT_EQ(pipe2(pipe.data(), O_NONBLOCK), 0);
    const std::string kilobyte(1024, '.');
    while (write(pipe[1], kilobyte.data(), kilobyte.size()) > 0) {
    }
    fcntl(pipe[1], F_SETFL, 0);
    Started s = start(kAttempt + "--trainee T-7", "", "2>&" + std::to_string(pipe[1]));
    close(pipe[1]);
    const std::string state = "/proc/" + std::to_string(s.pid);
    ASSERT_TRUE(until([&] {
        return (fs::read_symlink(state + "/exe").filename() == "stylet" &&
                textOf(state + "/status").find("State:\tS") != std::string::npos) ||
               s.over();
    }));
    EXPECT_FALSE(s.over());
    fcntl(pipe[0], F_SETFL, 0);
    std::string read_all(4096, '\0');
    while (read(pipe[0], read_all.data(), read_all.size()) > 0) {
    }
    close(pipe[0]);
    EXPECT_EQ(s.result(), 0);
    expectKept("T-7");
}

TEST_F(FaultsRun, StandardStreamsThatAreClosed) {
    cell("stylet run", "stdin, stdout and stderr closed", "no word lands in a record; stored");
    EXPECT_EQ(run(kAttempt + "--trainee T-8", "", "<&- >&- 2>&-"), 0);
    expectKept("T-8");
    EXPECT_EQ(run("stylet replay '" + storedOf("T-8")[0].folder.string() + "' --fast --out again"), 0)
        << err_;
    EXPECT_EQ(hashIn("again"), hash_);
}

TEST_F(FaultsRun, WordsThatCannotBeWritten) {
    cell("stylet records", "standard output to a full device", "status 2, says so");
    EXPECT_EQ(run("stylet records list", "", ">/dev/full"), 2);
    expectSaid("stylet: standard output: not all of it could be written");
}

// HZ-RECORD-03
TEST_F(FaultsRun, TwoCopiesAtOnce) {
    cell("stylet run", "another copy on the same cache and store", "both work, one patient, both stored");
    const std::string cache = "XDG_CACHE_HOME=cache-shared";
    Started a = start(kAttempt + "--trainee T-9", cache), b = start(kAttempt + "--trainee T-9", cache);
    EXPECT_EQ(a.result(), 0) << textOf(a.err);
    EXPECT_EQ(b.result(), 0) << textOf(b.err);
    expectKept("T-9", 2);
    const fs::directory_iterator patients(in("cache-shared/stylet/patients"));
    EXPECT_EQ(std::distance(begin(patients), end(patients)), 1);
}

// HZ-RECORD-02, HZ-RECORD-13
TEST_F(FaultsRun, ADiskThatIsFull) {
    cell("run, synth, report", "files that may grow no further",
         "status 2, file and reason; no half package");
    EXPECT_EQ(run(kAttempt + "--out full", full()), 2);
    expectSaid("full/record/inputs.bin: file: File too large");
    EXPECT_EQ(run(kAttempt + "--trainee T-10", full()), 2);
    expectSaid(".local/share/stylet/records/");
    expectKept();
    EXPECT_EQ(run(kAttempt + "--out full", full() + "XDG_CACHE_HOME=cache-full"), 2);
    expectSaid("ct.nii.gz: file: cannot be written: File too large");
    EXPECT_TRUE(fs::is_empty(in("cache-full/stylet/patients")));
    expectWorks("XDG_CACHE_HOME=cache-full");
    EXPECT_EQ(run("stylet-model synth --seed 3 --spacing-mm 5 --out made", full()), 2);
    expectSaid("ct.nii.gz: file: cannot be written: File too large");
    for (const auto& entry : fs::directory_iterator(box_->path()))
        EXPECT_EQ(entry.path().filename().string().find("made"), std::string::npos) << entry.path();
    EXPECT_EQ(run("stylet-report attempt ref --out report-full", full()), 2);
    expectSaid("attempt.html: file: cannot be written");
}

TEST_F(FaultsRun, AssetsThatAreMissingOrDamaged) {
    cell("stylet run", "an asset that is missing or damaged", "status 2, its name and the reason");
    const fs::path assets = std::getenv("STYLET_ASSETS");
    const auto expectNamed = [&](const std::string& asset, const std::string& text) {
        fs::remove_all(in("assets"));
        fs::create_directories(in("assets"));
        for (const auto& entry : fs::directory_iterator(assets))
            if (entry.path().filename() != fs::path(asset).parent_path())
                fs::create_directory_symlink(entry.path(), in("assets") / entry.path().filename());
        const fs::path folder = in("assets") / fs::path(asset).parent_path();
        fs::copy(assets / fs::path(asset).parent_path(), folder, fs::copy_options::recursive);
        fs::remove(folder / fs::path(asset).filename());
        if (!text.empty()) std::ofstream(folder / fs::path(asset).filename()) << text;
        EXPECT_EQ(run(kAttempt + "--out none", "STYLET_ASSETS='" + in("assets").string() + "'"), 2) << asset;
        expectSaid(fs::path(asset).filename().stem().string());
    };
    expectNamed("tissue/ptcd.toml", "");
    expectNamed("tissue/ptcd.toml", "[[tissue]]\nname = \"skin\"\n");
    expectNamed("scenarios/demo.toml", "");
    expectNamed("scenarios/demo.toml", "name = \"demo\"\nmoments = [");
}

// HZ-RECORD-13
TEST_F(FaultsRun, ACacheThatIsDamaged) {
    cell("stylet run", "damaged files in the cache", "made anew; the same hash");
    fs::resize_file(patient() / "ct.nii.gz", fs::file_size(patient() / "ct.nii.gz") / 2);
    expectWorks();
    expectSaid("ct.nii.gz");
    expectSaid("rebuilding");
    std::ofstream(patient() / "patient.toml") << "no TOML";
    expectWorks();
    expectSaid("rebuilding");

    const std::string tools = "stylet run --fast --spacing-mm 5 --scenario five-tools --out tools";
    EXPECT_EQ(run(tools), 0) << err_;
    const std::string hash = hashIn("tools");
    int files = 0;
    for (const auto& entry : fs::directory_iterator(in("home/.cache/stylet/derived"))) {
        std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(-3, std::ios::end);
        file << "xyz";
        ++files;
    }
    EXPECT_GE(files, 2);
    const auto made = [](const char* what) { return summaryIn("tools").at("start").at(what); };
    EXPECT_EQ(run(tools), 0) << err_;
    expectSaid("is damaged; rebuilding it");
    EXPECT_EQ(hashIn("tools"), hash);
    EXPECT_EQ(made("touch_maps_made"), 1);
    EXPECT_EQ(made("marks_made"), 1);
    EXPECT_EQ(made("patients_made"), 0);
    EXPECT_EQ(run(tools), 0) << err_;
    EXPECT_EQ(made("touch_maps_made"), 0);
    EXPECT_EQ(made("marks_made"), 0);
    EXPECT_EQ(err_.find("rebuilding"), std::string::npos) << err_;
    EXPECT_EQ(hashIn("tools"), hash);
}

}  // namespace
}  // namespace stylet
