// Runs the program `stylet` as a user does.
#pragma once

#include <signal.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/file_text.h"
#include "tests/support/temp_folder.h"

namespace stylet::test {

struct Outcome {
    int status = -1;
    std::string out, err;
    nlohmann::json summary;  // summary.json in the --out folder; null if there is none
};

// Sends a signal to the program whose process id is in the file `number` (Command::runInto). Does nothing if
// the program has not started yet.
inline void signalProgram(const std::filesystem::path& number, int signal = SIGINT) {
    if (const int process = std::atoi(readText(number).c_str()); process > 0) kill(process, signal);
}

// Temporary folder in which the program runs. It contains the program's data, its output and, unless shared,
// its cache.
class Command {
  public:
    // shared: the folder from STYLET_TEST_CACHE, if set. packaging/test starts with an empty one, so every
    // reference patient is generated and planned once per run of the tests.
    enum class Cache { shared, own };

    Command() : Command(Cache::shared) {}
    explicit Command(Cache cache) {
        const char* shared = cache == Cache::shared ? std::getenv("STYLET_TEST_CACHE") : nullptr;
        variables_["XDG_CACHE_HOME"] = shared ? shared : (folder_ / "cache").string();
        variables_["XDG_DATA_HOME"] = (folder_ / "data").string();
    }

    // `arguments` as in a shell. Adds "--out" with a new folder, which `out()` returns after the run.
    Outcome run(const std::string& arguments) {
        return runInto(folder_ / ("out" + std::to_string(++runs_)), arguments);
    }
    // Writes the program's process id to the file `number`, if given, so that the caller can send it a
    // signal.
    Outcome runInto(const std::filesystem::path& out, const std::string& arguments,
                    const std::filesystem::path& number = {}) {
        out_ = out;
        Outcome outcome = runBare(arguments + " --out '" + out_.string() + "'",
                                  number.empty() ? "" : "echo $$ >'" + number.string() + "'; exec env ");
        if (std::filesystem::exists(out_ / "summary.json"))
            outcome.summary = nlohmann::json::parse(readText(out_ / "summary.json"));
        return outcome;
    }
    // Runs the program without adding "--out". `before` is placed before the variables in the shell line.
    Outcome runBare(const std::string& arguments, const std::string& before = "") {
        std::string line = before;
        for (const auto& [name, value] : variables_)
            line += name + "='" + value + "' ";
        const std::filesystem::path std_out = folder_ / "stdout", std_err = folder_ / "stderr";
        line += "'" + std::string(std::getenv("STYLET_BIN")) + "/stylet' " + arguments + " >'" +
                std_out.string() + "' 2>'" + std_err.string() + "'";
        const int status = std::system(line.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(std_out), readText(std_err), {}};
    }
    const std::filesystem::path& out() const { return out_; }
    void set(const std::string& variable, const std::string& value) { variables_[variable] = value; }
    void unset(const std::string& variable) { variables_.erase(variable); }
    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

  private:
    TempFolder folder_;
    std::map<std::string, std::string> variables_;
    std::filesystem::path out_;
    int runs_ = 0;
};

}  // namespace stylet::test
