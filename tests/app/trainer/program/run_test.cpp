// Runs `stylet run` and `stylet replay` as a user does, on small reference patients.
#include "app/trainer/program/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdio>
#include <fstream>
#include <random>

#include "app/records/record.h"
#include "base/hex.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/app/trainer/marker.h"
#include "tests/app/trainer/scripted_attempt.h"
#include "tests/support/seed.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using test::Command;
using test::Outcome;
using testing::HasSubstr;

const std::string kSmall = " --spacing-mm 2.5";

std::string hashOf(const Outcome& outcome) {
    return outcome.summary.at("state_hash").get<std::string>();
}

std::filesystem::path onlyPatientIn(const std::filesystem::path& cache) {
    return std::filesystem::directory_iterator(cache / "stylet" / "patients")->path();
}

#ifdef STYLET_SANITIZED
constexpr double kMinRate_hz = 20.0;
constexpr int kNewPatients = 1;
#else
// A loop with twice the period would reach 500 Hz. The lowest rate was 896 Hz, the best of 20 runs on a
// machine that stalled while two other programs used its two processors.
constexpr double kMinRate_hz = 700.0;
constexpr int kNewPatients = 3;
#endif

std::size_t lines(const std::string& text) {
    return std::size_t(std::count(text.begin(), text.end(), '\n'));
}

// All tests share one patient, because creating it takes most of the time.
class Run : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        command_ = new Command(Command::Cache::own);
        demo_ = new Outcome(command_->run("run --headless --fast --scenario demo" + kSmall));
        demo_folder_ = command_->out();
        std::ofstream(quickFile()) << quickText();
        quick_ = new Outcome(command_->run(quick(kSmall)));
    }
    static void TearDownTestSuite() {
        delete quick_;
        delete demo_;
        delete command_;
    }
    // A puncture of about three seconds, for the tests in which it does not matter what is played.
    static std::string quickText() {
        return test::readText(test::testScenario("short")) + "\n[breath]\nperiod_s = 1.0\n";
    }
    static std::filesystem::path quickFile() { return *command_ / "quick.toml"; }
    static std::string quick(const std::string& options) {
        return "run --headless --fast --scenario '" + quickFile().string() + "'" + options;
    }

    static inline Command* command_ = nullptr;
    static inline Outcome *demo_ = nullptr, *quick_ = nullptr;
    static inline std::filesystem::path demo_folder_;
};

TEST_F(Run, DemoHitsTheDuctAndWritesItsFolder) {
    ASSERT_EQ(demo_->status, 0) << demo_->err;
    EXPECT_TRUE(demo_->summary.at("target_hit").get<bool>()) << demo_->out;
    for (const char* file :
         {"force-depth.csv", "force-depth.png", "slices.png", "record/inputs.bin", "record/record.json"})
        EXPECT_TRUE(std::filesystem::exists(demo_folder_ / file)) << file;
}

TEST_F(Run, TheSummaryHoldsEveryField) {
    const json& s = demo_->summary;
    for (const char* field :
         {"patient", "scenario", "seed", "target_hit", "punctures", "peak_force_n", "lateral_cut_m", "dose",
          "contrast", "haptics", "frames", "skips", "state_hash"})
        EXPECT_TRUE(s.contains(field)) << field;
    for (const char* field : {"ticks", "rate_hz", "late_ticks", "faults", "max_step_us"})
        EXPECT_TRUE(s.at("haptics").at(field).is_number()) << field;
    EXPECT_EQ(s.at("haptics").at("faults"), 0);
    EXPECT_EQ(s.at("haptics").at("fault_names"), "none");
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

// In an ordinary puncture, the passivity controller stays far below the 0.145 N that people notice.
TEST_F(Run, PassivityControllerIsNotFeltInTheDemo) {
    const json& controller = demo_->summary.at("haptics").at("controller");
    EXPECT_GT(controller.at("contact_ticks").get<int>(), 5000);
    EXPECT_GT(controller.at("peak_n").get<double>(), 0.0);  // the controller is active
    EXPECT_LT(controller.at("peak_n").get<double>(), 0.02);
    EXPECT_LT(controller.at("rms_n").get<double>(), 0.002);
    EXPECT_LT(controller.at("felt_share").get<double>(), 0.1);  // fraction of ticks with more than 1 mN
}

TEST_F(Run, TheSameCommandEndsInTheSameHash) {
    const Outcome again = command_->run("run --headless --fast --scenario demo" + kSmall);
    EXPECT_EQ(hashOf(again), hashOf(*demo_));
    // The second run uses the cached data of the first.
    for (const char* what : {"patients_made", "marks_made", "plans_made"}) {
        EXPECT_EQ(demo_->summary.at("start").at(what), 1) << what;
        EXPECT_EQ(again.summary.at("start").at(what), 0) << what;
    }
}

TEST_F(Run, ItsRecordReplaysToItsHash) {
    const Outcome replay = command_->run("replay '" + demo_folder_.string() + "/record' --fast");
    EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
    EXPECT_EQ(hashOf(replay), hashOf(*demo_));
    EXPECT_EQ(replay.summary.at("punctures"), demo_->summary.at("punctures"));
    EXPECT_EQ(replay.summary.at("force_truth"), demo_->summary.at("force_truth"));
    EXPECT_EQ(test::readText(command_->out() / "force-depth.csv"),
              test::readText(demo_folder_ / "force-depth.csv"));
}

// The reference patient is fully segmented. The test compares its force with the force on a partial
// segmentation, in which thresholds replace all labels except fascia, liver, vessels and ducts. Most of the
// insertion has no error.
TEST_F(Run, TheForceOverThePartialSegmentationIsCompared) {
    const json& truth = demo_->summary.at("force_truth");
    EXPECT_EQ(truth.at("felt"), "full");
    EXPECT_EQ(truth.at("insertions"), 1);
    const json& all = truth.at("all_insertions");
    EXPECT_GT(all.at("ticks").get<int>(), 5000);
    EXPECT_GT(all.at("equal_share").get<double>(), 0.7);
    EXPECT_GT(all.at("largest_n").get<double>(), 0.0);
    EXPECT_LT(all.at("rms_n").get<double>(), all.at("largest_n").get<double>());
}

TEST_F(Run, RestartFromABookmarkEndsInTheSameHash) {
    const std::filesystem::path begun = *command_ / "begun";
    std::filesystem::create_directories(begun);
    std::filesystem::copy(demo_folder_ / "record", begun / "record");
    json info = json::parse(test::readText(begun / "record" / "record.json"));
    info["bookmarks"] =
        json::array({{{"tick", 9'000}, {"text", "before the skin"}}, {{"tick", 15'000}, {"text", ""}}});
    std::ofstream(begun / "record" / "record.json") << info;
    const Outcome again =
        command_->run("run --headless --fast --from '" + begun.string() + "@before the skin'" + kSmall);
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(hashOf(again), hashOf(*demo_));
    EXPECT_THAT(again.err, HasSubstr("until bookmark 1 (before the skin) at 9.0 s"));
    EXPECT_THAT(again.out, HasSubstr("1 bookmark; restart there: stylet run --from"));
    const std::string from = "run --headless --fast --from '" + begun.string() + "'";
    EXPECT_GE(command_->run(from + " --seed 2").status, 100) << "the record has its seed";
    const Outcome other = command_->run(from + " --scenario procedure");
    EXPECT_NE(other.status, 0);
    EXPECT_THAT(other.err, HasSubstr("--from restarts the scenario \"demo\"; remove --scenario"));
    EXPECT_THAT(command_->run(from + " --rate-hz 2000").err,
                HasSubstr("--rate-hz: --from continues at the rate of the recorded attempt"));
    const Outcome none = command_->run("run --headless --fast --from '" + demo_folder_.string() + "'");
    EXPECT_EQ(none.status, 2);
    EXPECT_THAT(none.err, HasSubstr("bookmarks: the attempt has none"));
}

TEST_F(Run, AThinNeedleReplaysToItsHash) {
    const std::string run = quick(kSmall);
    const Outcome thin = command_->run(run + " --needle chiba-22g");
    ASSERT_EQ(thin.status, 0) << thin.err;
    EXPECT_NE(hashOf(thin), hashOf(*quick_));
    const Outcome replay = command_->run("replay '" + command_->out().string() + "' --fast");
    EXPECT_EQ(replay.status, 0) << replay.out;
    EXPECT_EQ(hashOf(replay), hashOf(thin));
    EXPECT_EQ(hashOf(command_->run(run + " --needle needle-17g")), hashOf(*quick_));
    const Outcome none = command_->run(run + " --needle chiba-33g");
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.err.find("instrument \"chiba-33g\": not among: chiba-21g, "), std::string::npos)
        << none.err;
    for (const char* other : {"scalpel", "drain"}) {
        const Outcome wrong = command_->run(run + " --needle " + other);
        EXPECT_EQ(wrong.status, 2);
        EXPECT_NE(wrong.err.find("kind: is no needle"), std::string::npos) << wrong.err;
    }
    const Outcome retry =
        command_->run("run --fast --from '" + demo_folder_.string() + "' --needle chiba-22g");
    EXPECT_GE(retry.status, 100) << "the record has its needle";
}

// The record keeps the needle's own file values: a replay does not read the file again.
TEST_F(Run, TheScenarioOrTheCommandLineChoosesTheNeedle) {
    const test::TempFolder temp;
    const std::filesystem::path own = temp / "own.toml", needle = temp / "my-needle.toml";
    std::string mine = test::readText(test::assets() / "instruments" / "chiba-21g.toml");
    mine.replace(mine.find("21 G Chiba needle"), 17, "my own needle");
    std::ofstream(needle) << mine;
    std::ofstream(own) << "needle = \"" + needle.string() + "\"\n" + quickText();
    const std::string run = "run --headless --fast --scenario '" + own.string() + "'" + kSmall;
    const Outcome by_scenario = command_->run(run);
    ASSERT_EQ(by_scenario.status, 0) << by_scenario.err;
    const records::Record record = records::loadRecord(command_->out() / "record");
    EXPECT_EQ(record.info.needle, "my-needle");
    EXPECT_EQ(record.header.instruments.needle.title, "my own needle");
    EXPECT_DOUBLE_EQ(record.header.instruments.needle.shape.outer_m, 0.00082);
    EXPECT_DOUBLE_EQ(record.header.settings.tools.needle.friction_scale, 0.82 / 1.5);
    std::filesystem::remove(needle);
    EXPECT_EQ(hashOf(command_->run("replay '" + command_->out().string() + "' --fast")), hashOf(by_scenario));
    EXPECT_EQ(command_->run(run).status, 2) << "its needle has gone";
    ASSERT_EQ(command_->run(run + " --needle trocar-18g").status, 0) << "the command line comes first";
    EXPECT_EQ(records::loadRecord(command_->out() / "record").header.instruments.needle.name, "trocar-18g");
}

// The record names the instruments of all tools, and a replay or a restart uses them.
TEST_F(Run, TheScenarioOrTheCommandLineChoosesEveryInstrument) {
    const test::TempFolder temp;
    const std::filesystem::path own = temp / "own.toml", probe = temp / "my-probe.toml",
                                scalpel = temp / "my-scalpel.toml";
    const auto shipped = [](const std::string& name) {
        return test::readText(test::assets() / "instruments" / (name + ".toml"));
    };
    std::string blunt = shipped("scalpel"), small = shipped("probe-linear");
    blunt.replace(blunt.find("cut_force_n = 0.4"), 17, "cut_force_n = 0.6");
    small.replace(small.find("length_mm = 40.0"), 16, "length_mm = 30.0");
    std::ofstream(scalpel) << blunt;
    std::ofstream(probe) << small;
    std::ofstream(own) << "instruments = [\"probe-linear\", '" + scalpel.string() + "']\n" + quickText();
    const std::string run = "run --headless --fast --scenario '" + own.string() + "'" + kSmall;
    const Outcome by_scenario = command_->run(run);
    ASSERT_EQ(by_scenario.status, 0) << by_scenario.err;
    EXPECT_NE(hashOf(by_scenario), hashOf(*quick_));
    const records::Record first = records::loadRecord(command_->out() / "record");
    EXPECT_EQ(first.info.probe, "probe-linear");
    EXPECT_EQ(first.info.scalpel, "my-scalpel");
    EXPECT_EQ(first.info.needle + first.info.finger, "needle-17gfinger");
    EXPECT_EQ(first.header.settings.tools.scalpel.cut_force_n, 0.6);
    EXPECT_EQ(first.header.settings.tools.probe.length_m, 0.040);

    const Outcome by_option =
        command_->run(run + " --instrument '" + probe.string() + "' --instrument chiba-22g");
    ASSERT_EQ(by_option.status, 0) << by_option.err;
    const records::Record second = records::loadRecord(command_->out() / "record");
    EXPECT_EQ(second.info.probe, "my-probe");
    EXPECT_EQ(second.info.scalpel, "my-scalpel") << "the scenario's, as the option names none";
    EXPECT_EQ(second.info.needle, "chiba-22g");
    EXPECT_EQ(second.header.instruments.probe.transducer, "linear");
    EXPECT_EQ(second.header.settings.tools.probe.length_m, 0.030);
    std::filesystem::remove(probe);
    EXPECT_EQ(hashOf(command_->run("replay '" + command_->out().string() + "' --fast")), hashOf(by_option));
}

TEST_F(Run, InstrumentsThatNoToolCanUseAreRefused) {
    const test::TempFolder temp;
    const std::filesystem::path deaf = temp / "deaf.toml";
    std::string text = test::readText(test::assets() / "instruments" / "probe-convex.toml");
    text.replace(text.find("\"convex\""), 8, "\"tin\"");
    std::ofstream(deaf) << text;
    const auto refusal = [&](const std::string& options) {
        const Outcome none = command_->run("run --headless --fast" + kSmall + options);
        EXPECT_EQ(none.status, 2) << none.err;
        return none.err;
    };
    EXPECT_THAT(refusal(" --instrument spoon"), HasSubstr("instrument \"spoon\": not among: "));
    EXPECT_THAT(refusal(" --instrument probe-convex --instrument probe-linear"),
                HasSubstr("kind: is a second probe, besides \"probe-convex\""));
    EXPECT_THAT(refusal(" --needle chiba-21g --instrument chiba-22g"),
                HasSubstr("kind: is a second needle, besides \"chiba-21g\""));
    EXPECT_THAT(refusal(" --instrument '" + deaf.string() + "'"), HasSubstr("transducer: \"tin\" not found"));
    const Outcome retry =
        command_->run("run --fast --from '" + demo_folder_.string() + "' --instrument probe-linear");
    EXPECT_GE(retry.status, 100) << "the record has its instruments";
}

TEST_F(Run, InstrumentsAreListed) {
    const Outcome list = command_->runBare("instruments");
    ASSERT_EQ(list.status, 0) << list.err;
    EXPECT_THAT(list.out,
                HasSubstr("needle-17g     17 G PTCD needle: 17 G, 1.5 mm x 150 mm, chiba tip of 3.7 mm"));
    EXPECT_THAT(list.out, HasSubstr("drain          8.5 F biliary drain: 2.83 mm x 400 mm\n"));
}

TEST_F(Run, AnUnknownLookIsRefused) {
    const Outcome none = command_->run("run --headless --fast --look x-ray" + kSmall);
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.err.find("look \"x-ray\": not among: closed, "), std::string::npos) << none.err;
}

// Without a GPU: checks the flow of contrast medium and the patient's dose.
TEST_F(Run, CholangiographyFillsTheDuctsAndKeepsItsLedger) {
    const Outcome shown = command_->run("run --headless --fast --scenario cholangiography" + kSmall);
    ASSERT_EQ(shown.status, 0) << shown.err;
    EXPECT_TRUE(shown.summary.at("target_hit").get<bool>()) << shown.out;
    const json& dose = shown.summary.at("dose");
    EXPECT_NEAR(dose.at("contrast_ml").get<double>(), 0.3 * 3.0 + 1.0 * 12.0, 0.01);
    EXPECT_NEAR(dose.at("fluoroscopy_s").get<double>(), 3.0 + 12.0 + 2.0 + 5.0, 0.01);
    EXPECT_NEAR(dose.at("pulses").get<double>(), 22.0 * 7.5, 2.0);
    EXPECT_GT(dose.at("dose_area_gy_m2").get<double>(), 0.0);
    const json& contrast = shown.summary.at("contrast");
    EXPECT_EQ(contrast.at("last_place"), "duct");
    EXPECT_NEAR(contrast.at("ducts_ml").get<double>() + contrast.at("liver_ml").get<double>() +
                    contrast.at("washed_out_ml").get<double>(),
                12.9, 0.01);
    EXPECT_GT(contrast.at("ducts_ml").get<double>(), 8.0);
    EXPECT_TRUE(contrast.at("at_stop").get<bool>()) << "at the tumour";
    EXPECT_THAT(shown.out, HasSubstr("stands at the obstruction"));
    const std::filesystem::path folder = command_->out();
    const Outcome replay = command_->run("replay '" + folder.string() + "' --fast");
    EXPECT_EQ(replay.status, 0) << replay.out;
    EXPECT_EQ(hashOf(replay), hashOf(shown));
    EXPECT_EQ(replay.summary.at("dose"), dose);
    EXPECT_EQ(replay.summary.at("contrast"), contrast);
}

TEST_F(Run, AWrongTipStainsTheLiver) {
    const Outcome shown = command_->run("run --headless --fast --scenario wrong-tip" + kSmall);
    ASSERT_EQ(shown.status, 0) << shown.err;
    EXPECT_FALSE(shown.summary.at("target_hit").get<bool>());
    const json& contrast = shown.summary.at("contrast");
    EXPECT_EQ(contrast.at("last_place"), "liver");
    EXPECT_EQ(contrast.at("ducts_ml"), 0.0);
    EXPECT_NEAR(contrast.at("liver_ml").get<double>() + contrast.at("washed_out_ml").get<double>(), 2.0,
                0.01);
    EXPECT_GT(contrast.at("washed_out_ml").get<double>(), 0.02) << "it fades";
}

// Runs the demo with a recorded breath. Replays it without the recording.
TEST_F(Run, ARecordedBreathReplaysToItsHash) {
    const auto demoBreathing = [&](const std::string& name, const std::filesystem::path& recording) {
        const std::filesystem::path file = *command_ / (name + ".toml");
        std::ofstream(file) << test::readText(test::assets() / "scenarios" / "demo.toml")
                            << "\n[breath]\nrecording = \"" << recording.string() << "\"\n";
        return command_->run("run --headless --fast --scenario '" + file.string() + "'" + kSmall);
    };
    const auto expectReplayed = [&](const Outcome& outcome, const std::filesystem::path& record) {
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>()) << outcome.out;
        const Outcome replay = command_->run("replay '" + record.string() + "' --fast");
        EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
        EXPECT_EQ(hashOf(replay), hashOf(outcome));
    };
    const std::filesystem::path marker = *command_ / "marker.csv", other = *command_ / "other.csv";
    test::writeMarker(marker, 4.0);
    test::writeMarker(other, 4.1);
    const Outcome recorded = demoBreathing("recorded", "marker.csv");
    const std::filesystem::path record = command_->out() / "record";
    EXPECT_NE(hashOf(recorded), hashOf(*demo_));
    EXPECT_NE(hashOf(demoBreathing("other", "other.csv")), hashOf(recorded));
    EXPECT_EQ(hashOf(demoBreathing("again", "marker.csv")), hashOf(recorded));
    std::filesystem::remove(marker);
    expectReplayed(recorded, record);

    const char* data = std::getenv("STYLET_DATA");
    if (!data) GTEST_SKIP() << "STYLET_DATA is not set: no recording but the made one was played";
    const Outcome real =
        demoBreathing("real", std::filesystem::path(data) / "breathing/201205181211-LAC-1-N-320-6.csv");
    expectReplayed(real, command_->out() / "record");
}

// HZ-TEACH-07
TEST_F(Run, OneBitOfOneTableValueChangesTheHashAndRefusesTheRecord) {
    patient::Package package = patient::loadPackage(onlyPatientIn(*command_ / "cache"));
    double& friction = package.tissues[std::size_t(patient::Tissue::vessel)].friction_n;
    friction = std::bit_cast<double>(std::bit_cast<std::uint64_t>(friction) ^ 1u);
    const std::filesystem::path other = *command_ / "other-table";
    patient::savePackage(package, other);
    EXPECT_NE(hashOf(command_->run(quick(" --patient '" + other.string() + "'"))), hashOf(*quick_));

    const Outcome replay =
        command_->run("replay '" + demo_folder_.string() + "' --fast --patient '" + other.string() + "'");
    EXPECT_EQ(replay.status, 2);
    EXPECT_THAT(replay.err, HasSubstr("digest"));
}

// HZ-TEACH-13
TEST_F(Run, TruncatedRecordIsReplayedToItsEndAndReported) {
    const std::filesystem::path torn = *command_ / "torn";
    std::filesystem::copy(demo_folder_ / "record", torn);
    std::filesystem::resize_file(torn / "inputs.bin", std::filesystem::file_size(torn / "inputs.bin") - 1000);
    const Outcome replay = command_->run("replay '" + torn.string() + "' --fast");
    EXPECT_EQ(replay.status, 1) << "the recorded end was not reached";
    EXPECT_THAT(replay.err, HasSubstr("after its last complete frame"));
}

// HZ-TEACH-17
TEST_F(Run, WithoutAHoldHitOrMissIsRecorded) {
    const Outcome breathing = command_->run("run --headless --fast --scenario demo-breathing" + kSmall);
    EXPECT_EQ(breathing.status, 0);
    EXPECT_TRUE(breathing.summary.at("target_hit").is_boolean());
    EXPECT_GT(breathing.summary.at("lateral_cut_m").get<double>(),
              demo_->summary.at("lateral_cut_m").get<double>());
    EXPECT_NE(hashOf(breathing), hashOf(*demo_));
}

// Needs real time: without --fast, the ticks follow the wall clock.
TEST(RunRealTime, TheTicksFollowTheWallClock) {
    Command command;
    const std::filesystem::path still = test::writeStillScenario(command / "still.toml", 1.2);
    // A stall of the machine affects one run, but not all of them.
    double best_rate_hz = 0.0;
    for (int attempt = 0; attempt < 20 && best_rate_hz < kMinRate_hz; ++attempt) {
        const Outcome outcome =
            command.run("run --headless --fps 0 --scenario '" + still.string() + "'" + kSmall);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.summary.at("clock"), "real time");
        const json& haptics = outcome.summary.at("haptics");
        EXPECT_GT(haptics.at("ticks").get<double>(), 1000.0);
        EXPECT_LT(haptics.at("rate_hz").get<double>(), 1001.0);
        EXPECT_EQ(haptics.at("faults"), 0);
        best_rate_hz = std::max(best_rate_hz, haptics.at("rate_hz").get<double>());
    }
    RecordProperty("rate_hz", std::to_string(best_rate_hz));
    EXPECT_GT(best_rate_hz, kMinRate_hz);
}

// Needs real time: instructor's commands on stdin. A stdin that is closed or ends does not stop the attempt.
TEST(RunRealTime, AScriptedAttemptReadsTheInstructorsCommands) {
    Command command;
    const std::filesystem::path still = test::writeStillScenario(command / "still.toml", 1.2);
    const std::string run =
        "run --headless --no-mirror --fps 0 --scenario '" + still.string() + "'" + kSmall + " --out '";
    const auto play = [&](const std::string& name, const std::string& before, const std::string& input) {
        const Outcome outcome = command.runBare(run + (command / name).string() + "' " + input, before);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return outcome.err;
    };
    const std::string err = play("piped", "printf 'bookmark here\\ncough\\nprobe\\npause' | ", "");
    EXPECT_THAT(err, HasSubstr("instructor: bookmark: here"));
    EXPECT_THAT(err, HasSubstr("instructor: cough\n"));
    EXPECT_THAT(err, HasSubstr("\"probe\" is not an instructor's command"));
    EXPECT_THAT(err, HasSubstr("instructor: pause: goes on"))
        << "without window and stdin, nobody can resume";
    const std::filesystem::path record = command / "piped" / "record";
    const std::vector<records::Bookmark> bookmarks = records::loadRecord(record).info.bookmarks;
    ASSERT_EQ(bookmarks.size(), 1u);
    EXPECT_EQ(bookmarks[0].text, "here");
    const Outcome again = command.run("replay '" + record.string() + "' --fast");
    EXPECT_EQ(again.status, 0) << again.err;
    for (const auto& [name, input] : {std::pair{"closed", "<&-"}, {"empty", "</dev/null"}})
        EXPECT_THAT(play(name, "", input), testing::Not(HasSubstr("instructor")));
}

// HZ-TEACH-07
TEST_F(Run, OutdatedStoredPathsArePlannedAgain) {
    const std::filesystem::path copy = *command_ / "copy";
    std::filesystem::copy(onlyPatientIn(*command_ / "cache"), copy, std::filesystem::copy_options::recursive);
    const std::string again = quick(" --patient '" + copy.string() + "'");
    const std::string unchecked = command_->run(again).err;
    EXPECT_THAT(unchecked, HasSubstr("has not been checked"));
    EXPECT_EQ(std::count(unchecked.begin(), unchecked.end(), '\n'), 1) << unchecked;

    patient::StoredPaths stored = patient::loadPaths(copy / "paths.json");
    const patient::StoredPaths good = stored;
    const auto expectPlannedAnew = [&](const std::string& reason) {
        const Outcome outcome = command_->run(again);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(reason + "; planning again\n"));
        EXPECT_EQ(hashOf(outcome), hashOf(*quick_));
        const patient::StoredPaths kept = patient::loadPaths(copy / "paths.json");
        EXPECT_EQ(kept.patient_digest, good.patient_digest);
        EXPECT_EQ(kept.planner_version, good.planner_version);
    };
    stored.patient_digest ^= 1;
    patient::savePaths(stored, copy / "paths.json");
    expectPlannedAnew("another patient");
    stored = good;
    stored.planner_version += 1;
    patient::savePaths(stored, copy / "paths.json");
    expectPlannedAnew("another version of the planner");
    std::ofstream(copy / "paths.json") << R"({"format": "stylet paths 1", "paths": []})";
    expectPlannedAnew("format: not stylet paths 2");
}

TEST_F(Run, MissingRuntimeIsReportedInOneLine) {
    Command command;
    command.set("XDG_CACHE_HOME", (*command_ / "cache").string());
    command.set("XR_RUNTIME_JSON", "/nonexistent/runtime.json");
    const Outcome outcome = command.run(quick(" --fps 1" + kSmall));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.summary.at("frames"), 0);
    EXPECT_EQ(hashOf(outcome), hashOf(*quick_));
    EXPECT_EQ(lines(outcome.err), 1u) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("continuing without pictures"));
}

TEST_F(Run, ABadScenarioIsRefusedInOneLine) {
    const std::filesystem::path bad = *command_ / "bad.toml";
    std::ofstream(bad) << "name = \"bad\"\nmoments = [\"spleen\"]\n";
    const Outcome outcome = command_->run("run --fast --scenario '" + bad.string() + "'");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(lines(outcome.err), 1u) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("bad.toml: moments: "));
}

TEST_F(Run, AFolderThatCannotBeMadeIsNamedBeforeAnythingElse) {
    Command command(Command::Cache::own);
    const std::filesystem::path file = command / "a-file";
    std::ofstream(file) << "not a folder";
    const auto expectNamed = [&](const Outcome& outcome, const std::string& what) {
        EXPECT_EQ(outcome.status, 2);
        EXPECT_EQ(lines(outcome.err), 1u) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(file.string()));
        EXPECT_THAT(outcome.err, HasSubstr(what));
        EXPECT_THAT(outcome.err, HasSubstr("cannot be made: Not a directory"));
    };
    expectNamed(command.runInto(file, "run --fast"), "--out");
    EXPECT_FALSE(std::filesystem::exists(command / "cache")) << "a patient was made for nothing";
    expectNamed(command.runInto(file / "out", "run --fast"), "--out");
    expectNamed(command.runInto(file / "out", "replay '" + (demo_folder_ / "record").string() + "'"),
                "--out");
    command.set("XDG_CACHE_HOME", file.string());
    expectNamed(command.run("run --fast"), "cache");
}

TEST_F(Run, CommandLineMistakesAreNamed) {
    const auto expectRefused = [&](const std::string& arguments, const std::vector<std::string>& words) {
        const bool stores = arguments.find("--trainee") != std::string::npos;
        const Outcome outcome = stores ? command_->runBare(arguments) : command_->run(arguments);
        EXPECT_NE(outcome.status, 0) << arguments;
        for (const std::string& word : words)
            EXPECT_THAT(outcome.err, HasSubstr(word)) << arguments << ": " << outcome.err;
    };
    expectRefused("run --fast --seed -1", {"--seed", "-1"});
    expectRefused("run --fast --seed 1.5", {"--seed", "1.5"});
    for (const char* option : {"--spacing-mm", "--rate-hz", "--fps", "--seconds", "--budget-ms"})
        expectRefused(std::string("run --headless --fast ") + option + " nan",
                      {std::string(option) + ": nan is not in "});
    const Outcome devices = command_->runBare("devices --device-force-n nan");
    EXPECT_NE(devices.status, 0);
    EXPECT_THAT(devices.err, HasSubstr("--device-force-n: nan is not in 0.1 to 30"));
    expectRefused("run --fast --scenario nope", {"nope", "demo, demo-breathing"});
    expectRefused("run --fast bogus", {"bogus"});
    // Ways to have somebody else's hand take the exam.
    expectRefused("run --fast --difficulty exam --trainee anna", {"--device scripted", "own hand"});
    expectRefused("run --fast --difficulty exam --trainee anna --device replay --trace expert.csv",
                  {"--device replay", "own hand"});
    expectRefused("run --fast --difficulty exam --from '" + demo_folder_.string() + "'",
                  {"--from", "begins at the beginning"});
    expectRefused("bogus", {"bogus"});
}

// The program makes the first patient. The others are made and punctured in this process, which is faster.
TEST_F(Run, HitsTheTargetInNewPatients) {
    std::mt19937_64 random(test::seed());
    const auto nextSeed = [&random] {
        const auto seed = std::uint32_t(random());
        std::printf("seed %u\n", seed);
        return seed;
    };
    const std::uint32_t seed = nextSeed();
    const Outcome outcome = command_->run("run --headless --fast --seed " + std::to_string(seed) + kSmall);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>()) << "seed " << seed << "\n" << outcome.out;
    EXPECT_NE(hashOf(outcome), hashOf(*demo_));

    const Scenario demo = loadScenario(test::assets() / "scenarios" / "demo.toml");
    for (int i = 1; i < kNewPatients; ++i) {
        patient::synth::SynthSettings settings;
        settings.seed = nextSeed();
        settings.spacing_m = 0.0025;
        settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
        const patient::Package package = patient::synth::makeReferencePatient(settings);
        const patient::Patient patient(package);
        const std::vector<patient::PlannedPath> paths = patient::planPaths(patient, {}).paths;
        ASSERT_FALSE(paths.empty()) << "seed " << settings.seed;
        const SessionLog log = test::playScripted(patient, {}, paths.front(), demo, settings.seed);
        EXPECT_TRUE(log.target_hit()) << "seed " << settings.seed;
        EXPECT_NE(hexText(log.state_hash), hashOf(*demo_));
    }
}

}  // namespace
}  // namespace stylet::trainer
