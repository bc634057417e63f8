#include "tests/app/fault_matrix.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/support/file_text.h"

namespace stylet::test {
namespace {

namespace fs = std::filesystem;

std::vector<FaultRow> matrix;

// Faults of complete programs that are tested outside this suite.
const std::vector<FaultRow> kElsewhere{
    {"stylet run", "SIGKILL at any instant", "StoreRun.KilledRunLeavesOnlyWholeFrames"},
    {"stylet run", "SIGTERM, SIGHUP, SIGQUIT, SIGTSTP with a device",
     "FalconRunRealTime.ASignalWhileItPushesEndsInZero, InterruptsDeathTest"},
    {"stylet run", "device, headset, display, runtime lost",
     "DeviceRunRealTime, HeadsetRun, WindowRun, RunWithPictures.LostGpuEndsOnlyThePictures"},
    {"stylet run", "stale or damaged paths.json", "Run.OutdatedStoredPathsArePlannedAgain"},
    {"stylet run", "folder that cannot be made, bad scenario", "Run.AFolderThat..., Run.ABadScenario..."},
    {"stylet records", "a real disk that is full",
     "DiskFull.RealFullDiskLosesNoAcknowledgedData, DiskFull.DeletingFreesSpace"},
    {"stylet-model build", "stopped between or within stages",
     "StageStoreTest, BuildRun.SecondRunReusesAllStages"},
    {"stylet register", "SIGTERM, SIGINT at its stages; a decimal comma", "RegisterRunRealTime"},
    {"stylet-study run", "a process killed, failed",
     "StudyRun.RunResumesAfterALostRank, StudyRun.FailingRankAbortsAllRanks"},
};

class PrintMatrix : public testing::Environment {
    void TearDown() override {
        const auto print = [](const FaultRow& row, const char* state) {
            std::printf("  %-18s %-46s %-8s %s\n", row.program.c_str(), row.fault.c_str(), state,
                        row.outcome.c_str());
        };
        std::printf("\nfault matrix\n");
        for (const FaultRow& row : matrix)
            print(row, row.failed ? "FAILED" : "ok");
        for (const FaultRow& row : kElsewhere)
            print(row, "see");
        std::ofstream table(STYLET_MATRIX);
        table << "# Fault matrix\n\nWhole programs in hostile conditions, as tested by faults_run_test.\n\n| "
                 "program | fault | what happens | shown |\n"
                 "|---|---|---|---|\n";
        const auto line = [&](const FaultRow& row, const std::string& outcome, const std::string& shown) {
            table << "| " << row.program << " | " << row.fault << " | " << outcome << " | " << shown
                  << " |\n";
        };
        for (const FaultRow& row : matrix)
            line(row, row.outcome, row.failed ? "**FAILED**" : "ok");
        for (const FaultRow& row : kElsewhere)
            line(row, "see the test", "`" + row.outcome + "`");
    }
};
const auto* const kPrinted = testing::AddGlobalTestEnvironment(new PrintMatrix);

// Checks that the tests named in `outcome` exist. The outcome has the form "Suite.Name, Suite.Beginning...,
// Suite".
TEST(FaultMatrix, TestsElsewhereAreThere) {
    std::string tests;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(STYLET_SOURCE_DIR) / "tests"))
        if (entry.path().extension() == ".cpp") tests += readText(entry.path());
    for (const FaultRow& row : kElsewhere) {
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

}  // namespace

void addFaultRow(const FaultRow& row) {
    matrix.push_back(row);
}

}  // namespace stylet::test
