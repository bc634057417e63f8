// The program `stylet` run as a user runs it.
#pragma once

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
    nlohmann::json summary;  // of the folder given with --out, null when there is none
};

// A temporary folder to run the program in: its data, its output and, unless shared, its cache.
class Command {
  public:
    // `packaging/test` names an empty folder in STYLET_TEST_CACHE, so that each reference patient is made and
    // planned once for all tests of a build.
    enum class Cache { shared, own };

    Command() : Command(Cache::shared) {}
    explicit Command(Cache cache) {
        const char* shared = cache == Cache::shared ? std::getenv("STYLET_TEST_CACHE") : nullptr;
        variables_["XDG_CACHE_HOME"] = shared ? shared : (folder_ / "cache").string();
        variables_["XDG_DATA_HOME"] = (folder_ / "data").string();
    }

    // `arguments` as in a shell; "--out" is added and names a fresh folder, `out()` after the run.
    Outcome run(const std::string& arguments) {
        return runInto(folder_ / ("out" + std::to_string(++runs_)), arguments);
    }
    // The process number of the program goes into `number`, where one is named, for who wants to signal it.
    Outcome runInto(const std::filesystem::path& out, const std::string& arguments,
                    const std::filesystem::path& number = {}) {
        out_ = out;
        Outcome outcome = runBare(arguments + " --out '" + out_.string() + "'",
                                  number.empty() ? "" : "echo $$ >'" + number.string() + "'; exec env ");
        if (std::filesystem::exists(out_ / "summary.json"))
            outcome.summary = nlohmann::json::parse(textOf(out_ / "summary.json"));
        return outcome;
    }
    // As it is, without "--out"; `before` comes before the variables in the shell's line.
    Outcome runBare(const std::string& arguments, const std::string& before = "") {
        std::string line = before;
        for (const auto& [name, value] : variables_)
            line += name + "='" + value + "' ";
        const std::filesystem::path std_out = folder_ / "stdout", std_err = folder_ / "stderr";
        line += "'" + std::string(std::getenv("STYLET_BIN")) + "/stylet' " + arguments + " >'" +
                std_out.string() + "' 2>'" + std_err.string() + "'";
        const int status = std::system(line.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(std_out), textOf(std_err), {}};
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
