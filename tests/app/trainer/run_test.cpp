// The main job from the outside, on small reference patients.
#include "app/trainer/run.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdio>
#include <random>

#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using test::Command;
using test::Outcome;

const std::string kSmall = " --spacing-mm 2.5";

std::string hashOf(const Outcome& outcome) {
    return outcome.summary.at("state_hash").get<std::string>();
}

std::filesystem::path onlyPatientIn(const std::filesystem::path& cache) {
    return std::filesystem::directory_iterator(cache / "stylet" / "patients")->path();
}

std::size_t lines(const std::string& text) {
    return std::size_t(std::count(text.begin(), text.end(), '\n'));
}

// One patient for the whole suite: making it is most of the time.
class Run : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        command_ = new Command;
        demo_ = new Outcome(command_->run("run --headless --fast --scenario demo" + kSmall));
        demo_folder_ = command_->out();
    }
    static void TearDownTestSuite() {
        delete demo_;
        delete command_;
    }

    static inline Command* command_ = nullptr;
    static inline Outcome* demo_ = nullptr;
    static inline std::filesystem::path demo_folder_;
};

TEST_F(Run, TheDemoHitsTheDuctAndLeavesItsFolder) {
    ASSERT_EQ(demo_->status, 0) << demo_->err;
    EXPECT_TRUE(demo_->summary.at("target_hit").get<bool>()) << demo_->out;
    for (const char* file :
         {"force-depth.csv", "force-depth.png", "slices.png", "record/inputs.bin", "record/record.json"})
        EXPECT_TRUE(std::filesystem::exists(demo_folder_ / file)) << file;
}

TEST_F(Run, TheSummaryHoldsEveryFieldTheIssueNames) {
    const json& s = demo_->summary;
    for (const char* field : {"patient", "scenario", "seed", "target_hit", "punctures", "peak_force_n",
                              "lateral_cut_m", "haptics", "frames", "skips", "state_hash"})
        EXPECT_TRUE(s.contains(field)) << field;
    for (const char* field : {"ticks", "rate_hz", "late_ticks", "faults", "max_step_us"})
        EXPECT_TRUE(s.at("haptics").at(field).is_number()) << field;
    EXPECT_EQ(s.at("haptics").at("faults"), 0);
    EXPECT_EQ(s.at("haptics").at("late_ticks"), 0);
    EXPECT_EQ(s.at("frames"), 0);
    EXPECT_EQ(hashOf(*demo_).size(), 16u);
    ASSERT_FALSE(s.at("punctures").empty());
    double last_tick = 0.0;
    for (const json& puncture : s.at("punctures")) {
        for (const char* field : {"border_depth_m", "tenting_m", "force_before_n", "force_after_n", "tick"})
            EXPECT_TRUE(puncture.at(field).is_number()) << field;
        EXPECT_GE(puncture.at("tick").get<double>(), last_tick);
        last_tick = puncture.at("tick").get<double>();
        EXPECT_LE(puncture.at("force_before_n").get<double>(), s.at("peak_force_n").get<double>() + 1e-12);
    }
    EXPECT_EQ(s.at("punctures").at(0).at("tissue"), "skin");
}

TEST_F(Run, TheSameCommandEndsInTheSameHash) {
    EXPECT_EQ(hashOf(command_->run("run --headless --fast --scenario demo" + kSmall)), hashOf(*demo_));
}

TEST_F(Run, ItsRecordReplaysToItsHash) {
    const Outcome replay = command_->run("replay '" + demo_folder_.string() + "/record' --fast");
    EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
    EXPECT_EQ(hashOf(replay), hashOf(*demo_));
    EXPECT_EQ(replay.summary.at("punctures"), demo_->summary.at("punctures"));
    EXPECT_EQ(test::textOf(command_->out() / "force-depth.csv"),
              test::textOf(demo_folder_ / "force-depth.csv"));
}

TEST_F(Run, OneBitOfOneTableValueChangesTheHashAndRefusesTheRecord) {
    patient::Package package = patient::loadPackage(onlyPatientIn(*command_ / "cache"));
    double& friction = package.tissues[std::size_t(patient::Tissue::vessel)].friction_n;
    friction = std::bit_cast<double>(std::bit_cast<std::uint64_t>(friction) ^ 1u);
    const std::filesystem::path other = *command_ / "other-table";
    patient::savePackage(package, other);
    EXPECT_NE(hashOf(command_->run("run --headless --fast --patient '" + other.string() + "'")),
              hashOf(*demo_));

    const Outcome replay =
        command_->run("replay '" + demo_folder_.string() + "' --fast --patient '" + other.string() + "'");
    EXPECT_EQ(replay.status, 2);
    EXPECT_NE(replay.err.find("digest"), std::string::npos) << replay.err;
}

TEST_F(Run, ATornRecordIsReplayedAsFarAsItGoesAndSaidToBeTorn) {
    const std::filesystem::path torn = *command_ / "torn";
    std::filesystem::copy(demo_folder_ / "record", torn);
    std::filesystem::resize_file(torn / "inputs.bin", std::filesystem::file_size(torn / "inputs.bin") - 1000);
    const Outcome replay = command_->run("replay '" + torn.string() + "' --fast");
    EXPECT_EQ(replay.status, 1) << "the recorded end was not reached";
    EXPECT_NE(replay.err.find("torn"), std::string::npos) << replay.err;
}

TEST_F(Run, WithoutAHoldHitOrMissIsRecorded) {
    const Outcome breathing = command_->run("run --headless --fast --scenario demo-breathing" + kSmall);
    EXPECT_EQ(breathing.status, 0);
    EXPECT_TRUE(breathing.summary.at("target_hit").is_boolean());
    EXPECT_GT(breathing.summary.at("lateral_cut_m").get<double>(),
              demo_->summary.at("lateral_cut_m").get<double>());
    EXPECT_NE(hashOf(breathing), hashOf(*demo_));
}

TEST_F(Run, WithoutARuntimeItSaysSoInOneLineAndGoesOn) {
    Command command;
    command.set("XDG_CACHE_HOME", (*command_ / "cache").string());
    command.set("XR_RUNTIME_JSON", "/nonexistent/runtime.json");
    const Outcome outcome = command.run("run --headless --fast --fps 1 --scenario demo" + kSmall);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.summary.at("frames"), 0);
    EXPECT_EQ(hashOf(outcome), hashOf(*demo_));
    EXPECT_EQ(lines(outcome.err), 1u) << outcome.err;
    EXPECT_NE(outcome.err.find("continuing without pictures"), std::string::npos) << outcome.err;
}

TEST_F(Run, ABadScenarioIsRefusedInOneLine) {
    const std::filesystem::path bad = *command_ / "bad.toml";
    std::ofstream(bad) << "name = \"bad\"\nmoments = [\"spleen\"]\n";
    const Outcome outcome = command_->run("run --fast --scenario '" + bad.string() + "'");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(lines(outcome.err), 1u) << outcome.err;
    EXPECT_NE(outcome.err.find("bad.toml: moments: "), std::string::npos) << outcome.err;
}

TEST_F(Run, ThreeNewPatientsAreAllHit) {
    std::random_device random;
    for (int i = 0; i < 3; ++i) {
        const std::uint32_t seed = random();
        std::printf("seed %u\n", seed);
        const Outcome outcome =
            command_->run("run --headless --fast --seed " + std::to_string(seed) + kSmall);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>()) << "seed " << seed << "\n" << outcome.out;
        EXPECT_NE(hashOf(outcome), hashOf(*demo_));
    }
}

}  // namespace
}  // namespace stylet::trainer
