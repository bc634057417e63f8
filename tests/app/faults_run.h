// Runs complete programs in hostile conditions. Each test is a cell of the fault matrix: a program, a fault
// and the expected outcome. In every outcome no stored data is lost and the next start works. The timing is
// deterministic: a signal is sent after a given output, after a given file appears, or when the program
// blocks on a pipe without a reader.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/records/store.h"
#include "tests/app/fault_matrix.h"
#include "tests/app/study/pairs.h"
#include "tests/support/file_text.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wait_until.h"

namespace stylet {

// A running program. Its output goes to files, or where the shell line redirects it.
struct Started {
    pid_t pid = -1;
    std::filesystem::path out, err;
    bool ended = false;
    int status = 0;
    bool over() {
        if (!ended) ended = waitpid(pid, &status, WNOHANG) == pid;
        return ended;
    }
    // Waits until `done` returns true or the program ends. Returns false after two minutes.
    template <typename Done>
    bool waitFor(const Done& done) {
        return test::waitUntil([&] { return done() || over(); }, std::chrono::seconds(120), 5);
    }
    bool says(const std::string& words) {
        const auto said = [&] { return test::readText(err).find(words) != std::string::npos; };
        return waitFor(said) && said();
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
        std::ofstream(in("quick.toml"))
            << test::readText(std::filesystem::path(STYLET_SOURCE_DIR) / "tests/scenarios/short.toml")
            << "\n[breath]\nperiod_s = 1.0\n";  // the breath-hold begins sooner
        ASSERT_EQ(run(kAttempt + "--trainee T-1 --difficulty practice"), 0) << err_;
        ASSERT_EQ(run(kAttempt + "--out ref"), 0) << err_;
        hash_ = hashIn("ref");
    }
    static void TearDownTestSuite() { delete box_; }
    void TearDown() override {
        // Also resets the changes of a test that failed before it could undo them.
        within_.clear(), variables_.clear();
        if (locked_) [[maybe_unused]]
            const int open = std::system(("chmod -R u+w '" + in("only").string() + "'").c_str());
        locked_ = false;
        if (!row_.program.empty()) test::addFaultRow({row_.program, row_.fault, row_.outcome, HasFailure()});
    }
    void cell(const char* program, const char* fault, const char* outcome) {
        row_ = {program, fault, outcome};
    }

    static std::filesystem::path in(const std::string& name) { return *box_ / name; }
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
        said_ = test::readText(s.out), err_ = test::readText(s.err);
        return result;
    }
    static nlohmann::json summaryIn(const std::string& folder) {
        return nlohmann::json::parse(test::readText(in(folder) / "summary.json"));
    }
    static std::string hashIn(const std::string& folder) { return summaryIn(folder).at("state_hash"); }
    // Expects that an attempt still gives the same hash as the first run.
    static void expectWorks(const std::string& variables = "") {
        const std::string before = variables_;
        variables_ += " " + variables;
        EXPECT_EQ(run(kAttempt + "--out works"), 0) << err_;
        EXPECT_EQ(hashIn("works"), hash_);
        std::filesystem::remove_all(in("works"));
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
    static void expectSaid(const std::string& words) { EXPECT_THAT(err_, testing::HasSubstr(words)); }
    static std::filesystem::path patient() {
        return *std::filesystem::directory_iterator(in("home/.cache/stylet/patients"));
    }
    // Creates a small and coarse study: one pair of packages from the same CT.
    static void needStudy() {
        if (std::filesystem::exists(in("study.toml"))) return;
        ASSERT_EQ(run("stylet-model synth --seed 1 --spacing-mm 4 --out truth"), 0) << err_;
        patient::savePackage(test::movedAndCut(patient::loadPackage(in("truth"))), in("built"));
        std::ofstream(in("study.toml")) << "[[pair]]\nname = 'one'\nreference = 'truth'\nfound = 'built'\n";
    }
    static inline const std::string kStudy = "study.toml --skin-spacing-mm 12.5 --threads 1 --out ";

    // Environment variables that stop the next program at this point (rough_surroundings.cpp).
    static std::string stoppedAt(const std::string& moment) {
        return "STYLET_TEST_SIGNAL=15 STYLET_TEST_AT='" + moment + "' LD_PRELOAD=" STYLET_ROUGH;
    }
    static std::vector<std::filesystem::path> filesIn(const std::string& folder) {
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(in(folder)))
            if (entry.is_regular_file() && entry.path().extension() != ".new")
                files.push_back(entry.path().lexically_relative(in(folder)));
        std::sort(files.begin(), files.end());
        return files;
    }
    // Expects that every file left by a stopped run equals the file of an undisturbed run.
    static void expectWholeFiles(const std::string& left, const std::string& undisturbed) {
        if (!std::filesystem::exists(in(left))) return;
        for (const std::filesystem::path& file : filesIn(left))
            EXPECT_TRUE(test::readText(in(left) / file) == test::readText(in(undisturbed) / file)) << file;
    }
    static void expectSame(const std::string& a, const std::string& b) {
        EXPECT_EQ(filesIn(a), filesIn(b));
        expectWholeFiles(a, b);
    }
    static std::string full() { return "trap '' XFSZ; ulimit -f 60;"; }  // limits each file to 60 blocks

    static inline const std::string kAttempt = "stylet run --fast --spacing-mm 5 --scenario quick.toml ";
    static inline test::TempFolder* box_ = nullptr;
    static inline std::string variables_, within_, hash_, said_, err_;
    static inline bool locked_ = false;  // the folder "only" is read-only
    test::FaultRow row_;
};

}  // namespace stylet
