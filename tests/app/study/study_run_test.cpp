// Runs stylet-study as users do: alone and in several ranks. Checks its page in a browser.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cstdlib>
#include <regex>
#include <sstream>

#include "tests/app/study/study_on_disk.h"
#include "tests/support/browser.h"
#include "tests/support/file_text.h"

namespace {

namespace fs = std::filesystem;
using stylet::test::readText;
using stylet::test::TempFolder;

const std::string kProgram = std::string(std::getenv("STYLET_BIN")) + "/stylet-study";

struct Outcome {
    int status = -1;
    std::string text;  // stdout and stderr
};

class StudyRun : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new TempFolder;
        stylet::test::writeStudy(folder_->path());
    }
    static void TearDownTestSuite() { delete folder_; }

    static Outcome shell(const std::string& line) {
        const fs::path text = *folder_ / "text";
        const int status = std::system(("( " + line + " ) >'" + text.string() + "' 2>&1").c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(text)};
    }
    // Plans from every skin voxel, which gives at least two blocks of paths per pair.
    static std::string command(const std::string& verb, const std::string& out,
                               const std::string& more = "") {
        return "'" + kProgram + "' " + verb + " '" + (*folder_ / "study.toml").string() + "' --out '" +
               (*folder_ / out).string() + "' --threads 1 " + more;
    }
    // Runs the whole study once into "alone": in one process and without interruption.
    static void needAlone() {
        if (fs::exists(*folder_ / "alone/report.html")) return;
        const Outcome all = shell(command("all", "alone"));
        ASSERT_EQ(all.status, 0) << all.text;
    }

    static TempFolder* folder_;
};
TempFolder* StudyRun::folder_ = nullptr;

const char* const kFiles[] = {"one/paths.json", "one/plan.csv",  "one/plan.json",  "one/paths.png",
                              "one/pair.json",  "one/paths.csv", "two/paths.json", "two/plan.json",
                              "two/paths.csv",  "two/pair.json", "summary.json",   "report.html"};

void expectSameFiles(const fs::path& a, const fs::path& b) {
    for (const char* file : kFiles) {
        ASSERT_TRUE(fs::exists(a / file)) << file;
        EXPECT_TRUE(readText(a / file) == readText(b / file)) << file;
    }
}

TEST_F(StudyRun, NanIsNoSpacing) {
    for (const std::string option : {"--skin-spacing-mm", "--target-spacing-mm"}) {
        const Outcome refused = shell(command("all", "nan", option + " nan"));
        EXPECT_NE(refused.status, 0);
        EXPECT_NE(refused.text.find(option + ": nan is not in 0 to 50"), std::string::npos) << refused.text;
    }
    EXPECT_FALSE(fs::exists(*folder_ / "nan"));
}

TEST_F(StudyRun, PageDrawsWithoutErrorsOrNetwork) {
    ASSERT_NO_FATAL_FAILURE(needAlone());
    stylet::test::Browser browser;
    for (const int width : {1280, 400}) {
        browser.open(*folder_ / "alone/report.html", width, 900);
        if (const char* shots = std::getenv("STYLET_SHOTS"))
            browser.screenshot(fs::path(shots) / ("study-" + std::to_string(width) + ".png"));
        EXPECT_EQ(browser.complaints(), std::vector<std::string>{});
        for (const std::string& address : browser.requests())
            EXPECT_TRUE(address.starts_with("file://") || address.starts_with("data:")) << address;
        const auto drawn = browser.evaluate(R"(Array.from(document.querySelectorAll('canvas')).map(c => {
            const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data, seen = new Set();
            for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200) seen.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]);
            return seen.size > 2; }))");
        EXPECT_GE(drawn.size(), 7u);
        for (const auto& one : drawn)
            EXPECT_EQ(one, true);
        EXPECT_LE(browser.evaluate("document.documentElement.scrollWidth").get<int>(), width);
        EXPECT_EQ(browser.evaluate("Array.from(document.images).every(i => i.alt && i.naturalWidth > 0)"),
                  true);
    }
}

// `stylet-study report` rebuilds the same report.html from the files on disk.
TEST_F(StudyRun, ReportIsRebuiltFromDisk) {
    ASSERT_NO_FATAL_FAILURE(needAlone());
    const std::string before = readText(*folder_ / "alone/report.html");
    fs::remove(*folder_ / "alone/report.html");
    const Outcome report = shell("'" + kProgram + "' report '" + (*folder_ / "alone").string() + "'");
    ASSERT_EQ(report.status, 0) << report.text;
    EXPECT_TRUE(readText(*folder_ / "alone/report.html") == before);
    const Outcome none = shell("'" + kProgram + "' report '" + (*folder_ / "nowhere").string() + "'");
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.text.find("summary.json: file: cannot be read: plan and run the study first"),
              std::string::npos)
        << none.text;
}

TEST_F(StudyRun, AnOutFolderThatCannotBeMadeIsNamed) {
    const fs::path file = *folder_ / "a-file";
    std::ofstream(file) << "no folder";
    for (const char* verb : {"plan", "run", "all"}) {
        const Outcome refused = shell(command(verb, "a-file"));
        EXPECT_EQ(refused.status, 2);
        EXPECT_EQ(refused.text,
                  "stylet-study: " + file.string() + ": --out: cannot be made: Not a directory\n");
    }
    fs::create_directory(*folder_ / "taken");
    std::ofstream(*folder_ / "taken/one") << "no folder";
    const Outcome refused = shell(command("all", "taken"));
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.text.find("taken/one: --out: cannot be made: Not a directory"), std::string::npos)
        << refused.text;
}

// The study's program contains no device, SQL or GPU code, neither as libraries nor as our own modules.
TEST_F(StudyRun, LinksNeitherDeviceNorSqlNorGpu) {
    const Outcome libraries = shell("ldd '" + kProgram + "'");
    ASSERT_EQ(libraries.status, 0);
    static const std::regex forbidden(
        "lib(sqlite|SQLiteCpp|pq|pqxx|vulkan|openxr|hidapi|usb|openal|glfw|GL|EGL|OpenCL|cuda|InsightToolkit|"
        "itk|ITK)[^a-z]",
        std::regex::icase);
    std::smatch found;
    EXPECT_FALSE(std::regex_search(libraries.text, found, forbidden)) << found.str();
    const Outcome needed = shell("readelf -d '" + kProgram + "' | grep NEEDED");
    ASSERT_EQ(needed.status, 0);
    static const std::regex expected(
        "\\[lib(cairo|fmt|mpi|tomlplusplus|stdc\\+\\+|m|gcc_s|c|z|pthread)\\.so|\\[ld-linux");
    std::istringstream lines(needed.text);
    for (std::string line; std::getline(lines, line);)
        EXPECT_TRUE(std::regex_search(line, expected)) << line;
    const Outcome symbols = shell("nm -C --defined-only '" + kProgram +
                                  "' | grep -c -E 'stylet::(records|render|xr|trainer|training|devices)::'");
    EXPECT_EQ(symbols.text, "0\n");
}

#ifdef STYLET_MPIRUN

// Shell line that runs `line` in `count` ranks.
std::string ranks(int count, const std::string& line) {
    return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 '" STYLET_MPIRUN
           "' --oversubscribe -n " +
           std::to_string(count) + " " + line;
}

// RunResumesAfterALostRank has two ranks.
TEST_F(StudyRun, AnyNumberOfRanksGivesTheSameFiles) {
    ASSERT_NO_FATAL_FAILURE(needAlone());
    for (const int count : {1, 4}) {
        const std::string out = "ranks-" + std::to_string(count);
        const Outcome all = shell(ranks(count, command("all", out)));
        ASSERT_EQ(all.status, 0) << count << ": " << all.text;
        expectSameFiles(*folder_ / "alone", *folder_ / out);
    }
}

// HZ-RECORD-13
TEST_F(StudyRun, RunResumesAfterALostRank) {
    ASSERT_NO_FATAL_FAILURE(needAlone());
    // The second of four ranks blocks while it writes its first block into a pipe without a reader. It is
    // killed once the first rank has written a block.
    const fs::path out = *folder_ / "lost", pipe = out / "two/blocks/000000.results.new";
    fs::create_directories(pipe.parent_path());
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const fs::path block = out / "one/blocks/000000.results";
    const Outcome lost = shell(ranks(
        4, "sh -c 'if [ \"$OMPI_COMM_WORLD_RANK\" = 1 ]; then (while [ ! -e \"" + block.string() +
               "\" ]; do sleep 0.01; done; kill -9 $$) & fi; exec \"$@\"' sh " + command("all", "lost")));
    EXPECT_NE(lost.status, 0);
    EXPECT_NE(lost.text.find("the same command resumes the study"), std::string::npos) << lost.text;
    ASSERT_FALSE(fs::exists(out / "summary.json"));
    ASSERT_TRUE(fs::exists(block));
    fs::remove(pipe);
    const auto written = fs::last_write_time(block);
    const Outcome resumed = shell(ranks(2, command("all", "lost")));
    ASSERT_EQ(resumed.status, 0) << resumed.text;
    EXPECT_NE(resumed.text.find("blocks were there"), std::string::npos) << resumed.text;
    EXPECT_EQ(fs::last_write_time(block), written);
    expectSameFiles(*folder_ / "alone", out);
}

TEST_F(StudyRun, FailingRankAbortsAllRanks) {
    std::ofstream(*folder_ / "bad.toml")
        << "[[pair]]\nname = 'one'\nreference = 'truth'\nfound = 'built'\n"
           "[[pair]]\nname = 'gone'\nreference = 'truth'\nfound = 'nowhere'\n";
    const Outcome bad = shell(ranks(2, "'" + kProgram + "' all '" + (*folder_ / "bad.toml").string() +
                                           "' --out '" + (*folder_ / "bad").string() + "'"));
    EXPECT_NE(bad.status, 0);
    EXPECT_NE(bad.text.find("nowhere"), std::string::npos) << bad.text;
}

#endif

}  // namespace
