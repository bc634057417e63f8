// Detects unintended changes of behaviour: every scenario ends in the state listed in state_hashes.csv, on
// the same patients with the same planned paths. After an intended change, replace the rows with those that
// the failures print.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/stores/patient_source.h"
#include "base/hash.h"
#include "base/hex.h"
#include "patient/patient.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/app/trainer/scripted_attempt.h"

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

fs::path fileOf(const std::string& scenario) {
    const fs::path shipped = test::assets() / "scenarios" / (scenario + ".toml");
    return fs::exists(shipped) ? shipped : test::testScenario(scenario);
}

constexpr double kSpacing_mm = 3.0;

// A reference patient in the cache of the program.
struct CachedPatient {
    CachedPatient(const fs::path& cache, std::uint64_t seed)
        : opened(openPatient({{}, seed, kSpacing_mm / 1000.0, cache, test::assets(), false})) {}
    std::string endHash(const StateHashRow& row) const {
        const Scenario scenario = loadScenario(fileOf(row.scenario));
        const patient::PlannedPath path = referencePath(patient, opened.folder, "", scenario.course);
        return hexText(test::playScripted(patient, touch, path, scenario, std::stoull(row.seed)).state_hash);
    }

    const OpenedPatient opened;
    const patient::Patient patient{opened.package};
    const haptics::TouchMap touch = haptics::makeTouchMap(patient);
};

void expectListed(const StateHashRow& row, const std::string& hash, const char* by) {
    EXPECT_EQ(hash, row.hash) << by << ", the new row: " << row.scenario << ',' << row.seed << ',' << hash;
}

// The program plays the demo, and one scenario for which it chooses another path. It also makes and plans the
// patients. All scenarios are played in this process, which is several times faster.
TEST(StateHashes, EveryScenarioEndsInItsListedState) {
    test::Command command(test::Command::Cache::own);
    const std::vector<StateHashRow> rows = listedHashes();
    for (const StateHashRow& row : rows) {
        if (row.scenario != "demo" && row.scenario + row.seed != "drainage1") continue;
        const test::Outcome outcome =
            command.run("run --headless --fast --fps 0 --spacing-mm " + std::to_string(kSpacing_mm) +
                        " --seed " + row.seed + " --scenario '" + fileOf(row.scenario).string() + "'");
        ASSERT_FALSE(outcome.summary.is_null()) << row.scenario << ": " << outcome.err;
        expectListed(row, outcome.summary.at("state_hash").get<std::string>(), "stylet run");
    }
    std::set<std::string> listed;
    std::map<std::string, CachedPatient> patients;
    for (const StateHashRow& row : rows) {
        listed.insert(row.scenario);
        const CachedPatient& patient =
            patients.try_emplace(row.seed, command / "cache/stylet", std::stoull(row.seed)).first->second;
        expectListed(row, patient.endHash(row), "in this process");
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
    EXPECT_EQ(hash.value(), 0x36b4f78dc41165e6u) << "the new value: 0x" << std::hex << hash.value() << "u";
}

}  // namespace
}  // namespace stylet::trainer
