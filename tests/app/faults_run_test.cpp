// Whole programs in rough surroundings. Each cell of the matrix that is printed at the end says what was done
// to which program and what has to come of it: words with file and reason, an exit status, nothing stored
// lost, and a next start that works. Moments are forced: a signal waits for words, for files, or for a pipe
// that nobody reads.
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
#include "tests/support/temp_folder.h"

namespace stylet {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct Row {
    std::string program, fault, outcome;
    bool failed = false;
};
std::vector<Row> matrix;

// What other tests show of whole programs.
const std::vector<Row> kElsewhere{
    {"stylet run", "SIGKILL at any instant", "StoreRun.KilledItLeavesWholeFramesOrNothing"},
    {"stylet run", "SIGTERM, SIGHUP, SIGQUIT, SIGTSTP with a device",
     "FalconRun.ASignalWhileItPushesEndsInZero"},
    {"stylet run", "device, headset, display, runtime lost", "DeviceRun, HeadsetRun, WindowRun, RunPictures"},
    {"stylet run", "stale or damaged paths.json", "Run.StoredPathsOfAnotherTable..."},
    {"stylet run", "folder that cannot be made, bad scenario", "Run.AFolderThat..., Run.ABadScenario..."},
    {"stylet records", "a real disk that is full", "DiskFull.OfARealDisk, DiskFull.DeletingMakesRoom"},
    {"stylet-model build", "stopped between or within stages",
     "StageStoreTest, BuildRun.ASecondRunKeepsEverything"},
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
    }
};
const auto* const kPrinted = testing::AddGlobalTestEnvironment(new PrintMatrix);

std::string textOf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

bool until(const std::function<bool()>& done) {
    for (const auto begin = std::chrono::steady_clock::now(); !done(); std::this_thread::sleep_for(5ms))
        if (std::chrono::steady_clock::now() > begin + 120s) return false;
    return true;
}

// A program that runs. Its words are in files, or where the line sends them.
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
    // Exit status, or minus the signal.
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
        if (!row_.program.empty()) matrix.push_back({row_.program, row_.fault, row_.outcome, HasFailure()});
    }
    void cell(const char* program, const char* fault, const char* outcome) {
        row_ = {program, fault, outcome};
    }

    static fs::path in(const std::string& name) { return *box_ / name; }
    static std::string program(const std::string& name) {
        return std::string(std::getenv("STYLET_BIN")) + "/" + name;
    }
    // A line of the shell, in the box: `before` (variables, traps), then the program with its arguments.
    static Started start(const std::string& arguments, const std::string& before = "",
                         const std::string& after = "") {
        Started s;
        static int number = 0;
        s.out = in("out" + std::to_string(++number)), s.err = in("err" + std::to_string(number));
        const std::string line = "cd '" + box_->path().string() + "' && " + before + " exec env " +
                                 variables_ + " " + program("") + arguments + " >'" + s.out.string() +
                                 "' 2>'" + s.err.string() + "' " + after;
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
    // An attempt as on the first day.
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
    // Nothing that was stored is lost.
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
    static std::string full() { return "trap '' XFSZ; ulimit -f 60;"; }  // each file, in the shell's blocks

    static inline const std::string kAttempt = "stylet run --fast --spacing-mm 5 --scenario demo ";
    static inline test::TempFolder* box_ = nullptr;
    static inline std::string variables_, hash_, said_, err_;
    Row row_;
};

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
TEST_F(FaultsRun, ADecimalComma) {
    cell("run, synth, report", "a locale with a decimal comma, switched on", "every number as without");
    fs::create_directories(in("locales"));
    if (std::system(
            ("localedef -i de_DE -f UTF-8 '" + in("locales/de_DE.UTF-8").string() + "' >/dev/null 2>&1")
                .c_str()))
        GTEST_SKIP() << "localedef knows no de_DE: the package locales is missing";
    const std::string german = "LOCPATH='" + in("locales").string() +
                               "' LC_ALL=de_DE.UTF-8 STYLET_TEST_LOCALE=1 LD_PRELOAD=" STYLET_ROUGH;
    const auto both = [&](const std::string& line, const std::string& out,
                          const std::vector<std::string>& files) {
        EXPECT_EQ(run(line + " --out " + out + "-c"), 0) << err_;
        EXPECT_EQ(run(line + " --out " + out + "-de", german), 0) << err_;
        for (const std::string& file : files) {
            const std::string plain = textOf(in(out + "-c") / file);
            EXPECT_FALSE(plain.empty()) << file;
            EXPECT_EQ(textOf(in(out + "-de") / file) == plain, true) << file;
        }
    };
    both("stylet run --fast --spacing-mm 5.0 --seed 1 --scenario demo --rate-hz 1000.0", "run",
         {"force-depth.csv", "record/inputs.bin"});
    nlohmann::json plain = summaryIn("run-c"), german_one = summaryIn("run-de");
    for (nlohmann::json* summary : {&plain, &german_one})
        summary->at("haptics").erase("max_step_us");
    EXPECT_EQ(plain, german_one);
    both("stylet-model synth --seed 2 --spacing-mm 4.5", "patient",
         {"patient.toml", "labels.ctbl", "ct.nii.gz"});
    both("stylet-report attempt ref", "report", {"attempt.html"});
    EXPECT_EQ(run("stylet-study plan no-such.toml --out study", german), 2);
    expectSaid("no-such.toml");
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
        expectWorks("XDG_CACHE_HOME=" + cache);
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

// A pipe in the place of the summary, which nobody reads, keeps the program at it.
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
    expectSaid("made anew");
    std::ofstream(patient() / "patient.toml") << "no TOML";
    expectWorks();
    expectSaid("made anew");

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
    EXPECT_EQ(run(tools), 0) << err_;
    expectSaid("is damaged; it is made anew");
    EXPECT_EQ(hashIn("tools"), hash);
    EXPECT_EQ(run(tools), 0) << err_;
    EXPECT_EQ(err_.find("made anew"), std::string::npos) << err_;
    EXPECT_EQ(hashIn("tools"), hash);
}

}  // namespace
}  // namespace stylet
