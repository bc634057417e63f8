// Tests programs in failing conditions: home, locale, clock, file systems, streams, disks, assets and caches.
#include "tests/app/faults_run.h"

#include <fcntl.h>

#include <array>

#include "tests/support/decimal_comma.h"

namespace stylet {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;
using test::readText;

TEST_F(FaultsRun, NoHome) {
    cell("stylet run", "no HOME, or no environment at all", "works, cache in the temporary folder");
    fs::create_directories(in("tmp"));
    expectWorks("-u HOME TMPDIR=" + in("tmp").string());
    EXPECT_TRUE(fs::exists(in("tmp/stylet/patients")));
    expectWorks("-i TMPDIR=" + in("tmp").string());
}

TEST_F(FaultsRun, UnwritableHomeIsReported) {
    cell("stylet run", "a HOME that cannot be written",
         "names the folder and the reason; a given patient works");
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
    cell("all with numbers", "a locale with a decimal comma; xx_YY.UTF-8", "the same numbers as without");
    const auto country = test::decimalComma(in("locales"), STYLET_ROUGH);
    if (country.empty()) GTEST_SKIP() << "localedef knows no de_DE: the package locales is missing";
    std::string german;
    for (const auto& [name, value] : country)
        german += name + "='" + value + "' ";
    needStudy();
    const std::string unknown = "LC_ALL=xx_YY.UTF-8 LANG=xx_YY.UTF-8";
    // Runs a line in three locales at the same time. The output and the files must be equal.
    const auto three = [&](const std::string& line, const std::string& out,
                           const std::vector<std::string>& files = {}) {
        const std::string to = out.empty() ? "" : " --out " + out;
        Started plain = start(line + (out.empty() ? "" : to + "-c"));
        Started comma = start(line + (out.empty() ? "" : to + "-de"), german);
        Started none = start(line + (out.empty() ? "" : to + "-xx"), unknown);
        EXPECT_EQ(plain.result(), 0) << line << readText(plain.err);
        EXPECT_EQ(comma.result(), 0) << line << readText(comma.err);
        EXPECT_EQ(none.result(), 0) << line << readText(none.err);
        for (const std::string& file : files) {
            const std::string text = readText(in(out + "-c") / file);
            EXPECT_FALSE(text.empty()) << file;
            EXPECT_TRUE(readText(in(out + "-de") / file) == text) << file;
            EXPECT_TRUE(readText(in(out + "-xx") / file) == text) << file;
        }
        if (!out.empty()) return;
        EXPECT_FALSE(readText(plain.out).empty());
        EXPECT_EQ(readText(comma.out), readText(plain.out));
        EXPECT_EQ(readText(none.out), readText(plain.out));
    };
    three("stylet run --fast --spacing-mm 5.0 --seed 1 --scenario quick.toml --rate-hz 1000.0", "run",
          {"force-depth.csv", "record/inputs.bin"});
    nlohmann::json plain = summaryIn("run-c"), comma = summaryIn("run-de"), none = summaryIn("run-xx");
    for (nlohmann::json* summary : {&plain, &comma, &none}) {
        summary->at("haptics").erase("max_step_us");
        summary->erase("start");  // contains durations
    }
    EXPECT_EQ(plain, comma);
    EXPECT_EQ(plain, none);
    three("stylet-model synth --seed 2 --spacing-mm 4.5", "patient",
          {"patient.toml", "labels.ctbl", "ct.nii.gz"});
    three("stylet-model check truth", "");
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
    EXPECT_THAT(said_, HasSubstr("kept"));
    EXPECT_EQ(filesIn("build-c").size(), 6u);
    expectSame("build-c", "build-de");
}

// HZ-RECORD-05
TEST_F(FaultsRun, AWallClockThatLeaps) {
    cell("stylet run", "a wall clock that leaps by days", "the same hash; stored");
    EXPECT_EQ(run(kAttempt + "--trainee T-3", "STYLET_TEST_CLOCK=1 LD_PRELOAD=" STYLET_ROUGH), 0) << err_;
    expectKept("T-3");
    EXPECT_EQ(run("stylet records list", "STYLET_TEST_CLOCK=1 LD_PRELOAD=" STYLET_ROUGH), 0) << err_;
    EXPECT_THAT(said_, HasSubstr("T-3"));
    EXPECT_EQ(nlohmann::json::parse(readText(storedOf("T-3")[0].folder / "summary.json")).at("state_hash"),
              hash_);
}

// Uses a read-only mount in the test's own child process if the machine allows it. Otherwise the test removes
// write permission from the folder, and root also drops its capability to override that.
TEST_F(FaultsRun, AFileSystemThatIsOnlyRead) {
    cell("every program", "a read-only mount", "can read; else names the file and the reason");
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
    refused("stylet-report attempt only/attempt --out only/attempt", "only/attempt: --out: ");
    refused("stylet-report cohort --out none", "only/home/.local/share/stylet/records: ");
    refused("stylet-model synth --spacing-mm 5 --out only/x", "only/.x");
    refused("stylet-model synth --spacing-mm 5 --out only/truth", "only/.truth");
    refused("stylet-model build --ct truth/ct.nii.gz --atlas truth --spacing-mm 4 --out only/x",
            "only/x-stages");
    refused("stylet-study plan " + kStudy + "only/x", "only/x");
    refused("stylet-study run " + kStudy + "only/study", "only/study: --out: ");
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

TEST_F(FaultsRun, ClosedPipeDoesNotStopTheAttempt) {
    cell("run, records, synth", "both outputs to a closed pipe", "the work continues and is stored");
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
    EXPECT_EQ(intoNothing("stylet-model synth --seed 3 --spacing-mm 5 --out made-unseen"), 0);
    EXPECT_THAT(run("stylet-model check made-unseen"), testing::AnyOf(0, 1)) << "2: it is not whole";
    fs::remove_all(in("made-unseen"));
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
    ASSERT_TRUE(s.waitFor([&] {
        return fs::read_symlink(state + "/exe").filename() == "stylet" &&
               readText(state + "/status").find("State:\tS") != std::string::npos;
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
    cell("stylet run", "stdin, stdout and stderr closed", "no output lands in a record; stored");
    EXPECT_EQ(run(kAttempt + "--trainee T-8", "", "<&- >&- 2>&-"), 0);
    expectKept("T-8");
    EXPECT_EQ(run("stylet replay '" + storedOf("T-8")[0].folder.string() + "' --fast --out again"), 0)
        << err_;
    EXPECT_EQ(hashIn("again"), hash_);
}

TEST_F(FaultsRun, FullStdoutIsReported) {
    cell("stylet records", "standard output to a full device", "status 2 and a message");
    EXPECT_EQ(run("stylet records list", "", ">/dev/full"), 2);
    expectSaid("stylet: standard output: not all of it could be written");
}

// HZ-RECORD-03
TEST_F(FaultsRun, TwoCopiesAtOnce) {
    cell("stylet run", "another copy on the same cache and store", "both work; one patient; both stored");
    const std::string cache = "XDG_CACHE_HOME=" + in("cache-shared").string();
    Started a = start(kAttempt + "--trainee T-9", cache), b = start(kAttempt + "--trainee T-9", cache);
    EXPECT_EQ(a.result(), 0) << readText(a.err);
    EXPECT_EQ(b.result(), 0) << readText(b.err);
    expectKept("T-9", 2);
    const fs::directory_iterator patients(in("cache-shared/stylet/patients"));
    EXPECT_EQ(std::distance(begin(patients), end(patients)), 1);
}

// HZ-RECORD-02, HZ-RECORD-13
TEST_F(FaultsRun, ADiskThatIsFull) {
    cell("run, synth, report", "files that cannot grow", "status 2, file and reason; no partial package");
    EXPECT_EQ(run(kAttempt + "--out full", full()), 2);
    expectSaid("full/record/samples.bin: file: File too large");
    EXPECT_EQ(run(kAttempt + "--trainee T-10", full()), 2);
    expectSaid(".local/share/stylet/records/");
    expectKept();
    const std::string cache = "XDG_CACHE_HOME=" + in("cache-full").string();
    EXPECT_EQ(run(kAttempt + "--out full", full() + cache), 2);
    expectSaid("ct.nii.gz: file: cannot be written: File too large");
    EXPECT_TRUE(fs::is_empty(in("cache-full/stylet/patients")));
    expectWorks(cache);
    EXPECT_EQ(run("stylet-model synth --seed 3 --spacing-mm 5 --out made", full()), 2);
    expectSaid("ct.nii.gz: file: cannot be written: File too large");
    for (const auto& entry : fs::directory_iterator(box_->path()))
        EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("made"))) << entry.path();
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
        EXPECT_EQ(run("stylet run --fast --spacing-mm 5 --scenario demo --out none",
                      "STYLET_ASSETS='" + in("assets").string() + "'"),
                  2)
            << asset;
        expectSaid(fs::path(asset).filename().stem().string());
    };
    expectNamed("tissue/ptcd.toml", "");
    expectNamed("tissue/ptcd.toml", "[[tissue]]\nname = \"skin\"\n");
    expectNamed("scenarios/demo.toml", "");
    expectNamed("scenarios/demo.toml", "name = \"demo\"\nmoments = [");
}

// HZ-RECORD-13
TEST_F(FaultsRun, ACacheThatIsDamaged) {
    cell("stylet run", "damaged files in the cache", "rebuilt; the same hash");
    fs::resize_file(patient() / "ct.nii.gz", fs::file_size(patient() / "ct.nii.gz") / 2);
    expectWorks();
    expectSaid("ct.nii.gz");
    expectSaid("rebuilding");
    std::ofstream(patient() / "patient.toml") << "no TOML";
    expectWorks();
    expectSaid("rebuilding");

    std::ofstream(in("touch.toml")) << "name = \"touch\"\nmoments = []\napproach_distance_mm = 5.0\n"
                                       "tool = \"finger\"\n"
                                       "[start]\ndeeper_mm = -10.0\n"
                                       "[hand]\nramp_s = 0.1\ntremor_mm = 0.1\n"
                                       "tremor_low_hz = 8.0\ntremor_high_hz = 10.0\n"
                                       "[[stage]]\ndo = \"move\"\ndeeper_mm = 4.0\nspeed_mm_s = 30.0\n";
    const std::string touch = "stylet run --fast --spacing-mm 5 --scenario touch.toml --out touch";
    EXPECT_EQ(run(touch), 0) << err_;
    const std::string hash = hashIn("touch");
    int files = 0;
    for (const auto& entry : fs::directory_iterator(in("home/.cache/stylet/derived"))) {
        std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(-3, std::ios::end);
        file << "xyz";
        ++files;
    }
    EXPECT_GE(files, 2);
    const auto made = [](const char* what) { return summaryIn("touch").at("start").at(what); };
    EXPECT_EQ(run(touch), 0) << err_;
    expectSaid("is damaged; rebuilding it");
    EXPECT_EQ(hashIn("touch"), hash);
    EXPECT_EQ(made("touch_maps_made"), 1);
    EXPECT_EQ(made("marks_made"), 1);
    EXPECT_EQ(made("patients_made"), 0);
    EXPECT_EQ(run(touch), 0) << err_;
    EXPECT_EQ(made("touch_maps_made"), 0);
    EXPECT_EQ(made("marks_made"), 0);
    EXPECT_THAT(err_, Not(HasSubstr("rebuilding")));
    EXPECT_EQ(hashIn("touch"), hash);
}

}  // namespace
}  // namespace stylet
