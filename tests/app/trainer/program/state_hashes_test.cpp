// Detects unintended changes of behaviour: every scenario ends in the state listed in state_hashes.csv, on
// the same patients with the same planned paths. After an intended change, replace the rows with those that
// the failures print.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "base/hash.h"
#include "patient/patient.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

namespace fs = std::filesystem;

struct StateHashRow {
    std::string scenario, seed, hash;
};

std::vector<StateHashRow> listedHashes() {
    std::ifstream in(test::assets().parent_path() / "tests/app/trainer/state_hashes.csv");
    std::vector<StateHashRow> rows;
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line, "scenario,seed,state_hash");
    while (std::getline(in, line)) {
        std::istringstream fields(line);
        StateHashRow row;
        std::getline(fields, row.scenario, ',');
        std::getline(fields, row.seed, ',');
        std::getline(fields, row.hash);
        rows.push_back(row);
    }
    return rows;
}

fs::path scenarioFile(const std::string& name) {
    const fs::path shipped = test::assets() / "scenarios" / (name + ".toml");
    return fs::exists(shipped) ? shipped : test::testScenario(name);
}

TEST(StateHashes, EveryScenarioEndsInItsListedState) {
    test::Command command(test::Command::Cache::own);
    std::set<std::string> listed;
    for (const StateHashRow& row : listedHashes()) {
        listed.insert(row.scenario);
        const test::Outcome outcome =
            command.run("run --headless --fast --fps 0 --spacing-mm 3 --seed " + row.seed + " --scenario '" +
                        scenarioFile(row.scenario).string() + "'");
        ASSERT_FALSE(outcome.summary.is_null()) << row.scenario << ": " << outcome.err;
        EXPECT_EQ(outcome.summary.at("state_hash"), row.hash)
            << "the new row: " << row.scenario << ',' << row.seed << ','
            << outcome.summary.at("state_hash").get<std::string>();
    }
    for (const auto& entry : fs::directory_iterator(test::assets() / "scenarios"))
        if (entry.path().extension() == ".toml") {
            EXPECT_TRUE(listed.contains(entry.path().stem().string())) << entry.path() << " has no row";
        }

    // Hash of the packages on which these attempts ran, and of their planned paths, to the last byte.
    StateHash hash;
    std::set<fs::path> folders;
    for (const auto& entry : fs::directory_iterator(command / "cache/stylet/patients"))
        folders.insert(entry.path());
    ASSERT_EQ(folders.size(), 2u);
    for (const fs::path& folder : folders) {
        hash.add(patient::digest(patient::loadPackage(folder)));
        for (const char* file : {"patient.toml", "paths.json"})
            hash.add(std::string_view(test::readText(folder / file)));
    }
    EXPECT_EQ(hash.value(), 0x300b544c17a3b10bu) << "the new value: 0x" << std::hex << hash.value() << "u";
}

}  // namespace
}  // namespace stylet::trainer
