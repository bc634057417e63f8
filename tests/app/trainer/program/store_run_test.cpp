// A trainee's attempts from the command line: store, list, show, export, delete, and kill during an attempt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <future>
#include <random>

#include "app/records/record.h"
#include "app/records/samples.h"
#include "app/records/store.h"
#include "app/training/metric_table.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/support/seed.h"

namespace stylet::trainer {
namespace {

using records::AttemptState;
using records::Store;
using records::StoredAttempt;
using test::Command;
using test::Outcome;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

const std::string kStoreRun = "run --headless --fast --spacing-mm 2.5 --scenario demo --trainee ";

constexpr int kKills = 12, kMaxKills = 100;  // the test continues until a kill has cut an attempt short

class StoreRun : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        command_ = new Command;
        command_->runBare(kStoreRun + "Warm-up --records '" + (*command_ / "other").string() + "'");
        const auto before = std::chrono::steady_clock::now();
        first_ = new Outcome(command_->runBare(kStoreRun + "T-01"));
        whole_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    }
    static void TearDownTestSuite() {
        delete first_;
        delete command_;
    }
    static std::filesystem::path folder() { return *command_ / "data" / "stylet" / "records"; }
    static Outcome killedAfter(double seconds) {
        return command_->runBare(kStoreRun + "T-09", "timeout -s KILL " + std::to_string(seconds) + " env ");
    }
    // Kills the program `seconds` after the first sample file exists.
    static Outcome killedInItsAttempt(double seconds) {
        const std::filesystem::path number = *command_ / "number";
        const std::size_t before = sampleFiles();
        auto outcome = std::async(std::launch::async, [&] {
            return command_->runBare(kStoreRun + "T-09", "echo $$ >'" + number.string() + "'; exec env ");
        });
        while (sampleFiles() == before && outcome.wait_for(1ms) != std::future_status::ready) {
        }
        if (outcome.wait_for(std::chrono::duration<double>(seconds)) != std::future_status::ready)
            kill(std::stoi(test::readText(number)), SIGKILL);
        return outcome.get();
    }
    static std::size_t sampleFiles() {
        std::size_t count = 0;
        for (const auto& attempt : std::filesystem::directory_iterator(folder() / "attempts"))
            count += std::filesystem::exists(attempt.path() / "record" / "samples.bin");
        return count;
    }
    static Outcome records(const std::string& arguments) { return command_->runBare("records " + arguments); }

    static inline Command* command_ = nullptr;
    static inline Outcome* first_ = nullptr;
    static inline double whole_s_ = 0.0;
};

// HZ-TEACH-20
TEST_F(StoreRun, KeepsInputsSamplesEventsAndScore) {
    ASSERT_EQ(first_->status, 0) << first_->err;
    const Store store(folder());
    ASSERT_EQ(store.attempts("T-01").size(), 1u);
    const StoredAttempt attempt = store.attempts("T-01")[0];
    EXPECT_THAT(first_->out, HasSubstr("stored as attempt " + attempt.id + " of T-01"));
    EXPECT_EQ(attempt.state, AttemptState::done);
    EXPECT_EQ(attempt.info.scenario, "demo");
    EXPECT_EQ(attempt.info.device, "scripted");
    EXPECT_EQ(attempt.info.difficulty, "guided") << "his first";
    EXPECT_NE(attempt.info.program_version, "");
    EXPECT_GT(attempt.info.device_gain, 0.0);
    ASSERT_TRUE(attempt.result);
    EXPECT_TRUE(attempt.result->target_hit);
    EXPECT_GT(attempt.result->total, 0.0);
    EXPECT_GT(attempt.result->metrics.size(), 10u);
    double points = 0.0;
    for (const records::MetricRow& metric : attempt.result->metrics)
        points += metric.points;
    EXPECT_NEAR(points, attempt.result->total, 1e-6) << "the visible parts are the total";
    EXPECT_TRUE(std::any_of(attempt.events.begin(), attempt.events.end(), [](const records::EventRow& e) {
        return e.kind == "cut" && e.text.starts_with("duct");
    }));

    const records::Record record = records::loadRecord(attempt.folder / "record");
    const records::Samples samples = records::loadSamples(attempt.folder / "record");
    EXPECT_EQ(attempt.info.patient_digest, record.header.package_digest);
    EXPECT_EQ(samples.header.package_digest, record.header.package_digest);
    ASSERT_EQ(samples.samples.size(), attempt.result->ticks);
    ASSERT_EQ(record.inputs.size(), attempt.result->ticks);
    EXPECT_EQ(samples.samples.back().tick, record.info.end->tick);
    const auto peak = std::max_element(samples.samples.begin(), samples.samples.end(),
                                       [](const auto& a, const auto& b) { return a.force_n < b.force_n; });
    EXPECT_GT(peak->force_n, 2.0);
    EXPECT_TRUE(std::filesystem::exists(attempt.folder / "summary.json"));
    EXPECT_TRUE(std::filesystem::exists(attempt.folder / "force-depth.png"));
    EXPECT_TRUE(store.damage().empty());
}

// The attempt's record with the score of an older table: the replay scores it with today's and shows both.
// Status 1, because a forged score could name an older table too.
// HZ-RECORD-07
TEST_F(StoreRun, AReplayScoresAnOldAttemptAgain) {
    const StoredAttempt attempt = Store(folder()).attempts("T-01").at(0);
    const std::filesystem::path old = *command_ / "old";
    std::filesystem::create_directories(old);
    std::filesystem::copy(attempt.folder / "record", old / "record");
    nlohmann::json info = nlohmann::json::parse(test::readText(old / "record" / "record.json"));
    nlohmann::json& score = info.at("result").at("score");
    score.erase("version");  // as written before the version was stored
    score.at("total") = 12.5;
    score.at("metrics").at(0).at("most_points") = 20.0;
    std::ofstream(old / "record" / "record.json") << info;
    const Outcome again = command_->run("replay --fast '" + (old / "record").string() + "'");
    EXPECT_EQ(again.status, 1) << again.err;
    EXPECT_THAT(again.out, HasSubstr("score 12.5 of 100 when recorded, with score table 1; "));
    EXPECT_THAT(again.out,
                HasSubstr("its score cannot be checked: score table 1 is older than this program's"));
    EXPECT_THAT(again.out, HasSubstr("Procedure done: "));
    EXPECT_THAT(again.out, HasSubstr("of 20 points when recorded, "));
    EXPECT_NEAR(again.summary.at("score").at("total").get<double>(), attempt.result->total, 1e-9);
}

// record.json with a better score, from the same inputs and the same score table.
// HZ-RECORD-07
TEST_F(StoreRun, AForgedScoreFailsTheReplay) {
    const StoredAttempt attempt = Store(folder()).attempts("T-01").at(0);
    const std::filesystem::path forged = *command_ / "forged score";
    const auto replayWith = [&](const auto& change,
                                const char* reason =
                                    "the recorded result is NOT the result of the recorded inputs") {
        std::filesystem::remove_all(forged);
        std::filesystem::copy(attempt.folder / "record", forged);
        nlohmann::json info = nlohmann::json::parse(test::readText(forged / "record.json"));
        change(info);
        std::ofstream(forged / "record.json") << info;
        const Outcome again = command_->run("replay --fast '" + forged.string() + "'");
        EXPECT_EQ(again.status, 1) << again.out;
        EXPECT_THAT(again.out, HasSubstr("state hash"));
        EXPECT_THAT(again.out, HasSubstr(reason));
    };
    replayWith([](nlohmann::json& info) { info.at("result").at("score").at("total") = 97.5; });
    replayWith(
        [](nlohmann::json& info) { info.at("result").at("score").at("metrics").at(2).at("points") = 9.5; });
    replayWith([](nlohmann::json& info) {
        info.at("events").push_back({{"tick", 5}, {"kind", "critical"}, {"text", "the lung was punctured"}});
    });
    // Lost ticks would explain any score.
    replayWith(
        [](nlohmann::json& info) {
            info["lost_ticks"] = {{"first", 900000}, {"last", 900001}};
            info.at("result").at("score").at("total") = 97.5;
        },
        "its score cannot be checked");
}

// An attempt that begins with another person's ticks is training only.
TEST_F(StoreRun, ARestartedAttemptEntersNoStatistics) {
    const StoredAttempt source = Store(folder()).attempts("T-01").at(0);
    const std::filesystem::path begun = *command_ / "marked";
    std::filesystem::create_directories(begun);
    std::filesystem::copy(source.folder / "record", begun / "record");
    nlohmann::json info = nlohmann::json::parse(test::readText(begun / "record" / "record.json"));
    info["bookmarks"] = nlohmann::json::array({{{"tick", source.result->ticks - 1}, {"text", ""}}});
    std::ofstream(begun / "record" / "record.json") << info;
    const Outcome cheat = command_->runBare("run --headless --fast --spacing-mm 2.5 --from '" +
                                            begun.string() + "@1' --trainee cheat");
    ASSERT_EQ(cheat.status, 0) << cheat.err;
    EXPECT_THAT(cheat.out, HasSubstr(" of cheat, restarted: it enters no statistics"));
    const StoredAttempt again = Store(folder()).attempts("cheat").at(0);
    EXPECT_EQ(again.result->total, source.result->total) << "the other person's score";
    EXPECT_FALSE(records::countsInStatistics(again));
    EXPECT_EQ(records::stateText(again), "restarted");
    EXPECT_TRUE(std::ranges::any_of(again.events, [&](const records::EventRow& e) {
        return e.kind == "retry" && e.text.starts_with((begun / "record").string() + " until bookmark 1");
    })) << "its record names its source";
    EXPECT_THAT(records("list --trainee cheat").out, HasSubstr("  restarted  "));
}

TEST_F(StoreRun, DiscardRefusesAnAttemptThatCounts) {
    const std::string id = Store(folder()).attempts("T-01").at(0).id;
    const Outcome refused = command_->runBare("records discard " + id);
    EXPECT_NE(refused.status, 0);
    EXPECT_THAT(refused.err, HasSubstr("it counts and cannot be discarded"));
    EXPECT_EQ(Store(folder()).attempts("T-01").size(), 1u);
    const Outcome log = command_->runBare("records log");
    EXPECT_EQ(log.status, 0) << log.err;
    EXPECT_THAT(log.out, HasSubstr("0 attempts discarded"));
}

// HZ-TEACH-13
TEST_F(StoreRun, StoredAttemptReplaysToTheUnstoredHash) {
    const StoredAttempt attempt = Store(folder()).attempts("T-01").at(0);
    const Outcome again = command_->run("replay --fast '" + (attempt.folder / "record").string() + "'");
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_THAT(again.out,
                HasSubstr(std::to_string(attempt.result->ticks) + " stored samples, each as recomputed"));
    char both[160];
    std::snprintf(both, sizeof both,
                  "score %.1f of 100 when recorded, with score table %d; %.1f with today's table %d\n",
                  attempt.result->total, training::kScoreVersion, attempt.result->total,
                  training::kScoreVersion);
    EXPECT_THAT(again.out, HasSubstr(both));
    EXPECT_EQ(again.summary.at("score").at("version"), training::kScoreVersion);
    const auto summary = nlohmann::json::parse(test::readText(attempt.folder / "summary.json"));
    EXPECT_EQ(again.summary.at("state_hash"), summary.at("state_hash"));
    const Outcome bare = command_->run("run --headless --fast --spacing-mm 2.5 --scenario demo");
    EXPECT_EQ(bare.summary.at("state_hash"), summary.at("state_hash"));
}

// The file is valid, but one sample does not result from the inputs.
// HZ-RECORD-07
TEST_F(StoreRun, AForgedSampleIsNamed) {
    const StoredAttempt attempt = Store(folder()).attempts("T-01").at(0);
    const std::filesystem::path forged = *command_ / "forged";
    std::filesystem::copy(attempt.folder / "record", forged);
    records::Samples samples = records::loadSamples(forged);
    samples.samples[9999].force_n += 1e-3;
    records::SampleWriter writer(forged, samples.header);
    for (const records::Sample& sample : samples.samples)
        writer.add(sample);
    writer.finish();
    const Outcome again = command_->run("replay --fast '" + forged.string() + "'");
    EXPECT_EQ(again.status, 1);
    EXPECT_THAT(again.out, HasSubstr("its stored samples differ from tick 10000"));
}

// HZ-RECORD-04
TEST_F(StoreRun, IsListedShownCheckedAndRead) {
    const std::string id = Store(folder()).attempts("T-01").at(0).id;
    const Outcome list = records("list");
    EXPECT_EQ(list.status, 0);
    EXPECT_THAT(list.out, HasSubstr(id));
    EXPECT_EQ(records("list --trainee nobody").out, "0 attempts\n");
    const Outcome shown = records("show " + id);
    EXPECT_THAT(shown.out, HasSubstr("attempt " + id + " of T-01, done"));
    EXPECT_THAT(shown.out, HasSubstr("Peak force"));
    EXPECT_EQ(records("show nobody").status, 2);
    const Outcome checked = records("recover");
    EXPECT_EQ(checked.status, 0);
    EXPECT_THAT(checked.out, HasSubstr("0 damaged"));
    EXPECT_EQ(records("list --records /nonexistent").status, 2);

    // The Python example is based on the documented file format only.
    const std::filesystem::path said = *command_ / "python";
    const std::filesystem::path example =
        test::assets().parent_path() / "app" / "records" / "examples" / "read_attempt.py";
    const std::string line =
        "python3 '" + example.string() + "' '" + folder().string() + "' " + id + " >'" + said.string() + "'";
    EXPECT_EQ(std::system(line.c_str()), 0);
    const std::string text = test::readText(said);
    const records::Samples samples = records::loadSamples(folder() / "attempts" / id / "record");
    double peak_n = 0.0;
    for (const records::Sample& sample : samples.samples)
        peak_n = std::max(peak_n, std::fabs(sample.force_n));
    std::array<char, 64> expected{};
    std::snprintf(expected.data(), expected.size(), "peak force %.3f N", peak_n);
    EXPECT_THAT(text, HasSubstr(expected.data()));
    EXPECT_THAT(text, HasSubstr("cut: duct"));
}

// HZ-RECORD-01
TEST_F(StoreRun, ALostIndexIsRebuiltByTheNextCommand) {
    const StoredAttempt attempt = Store(folder()).attempts("T-01").at(0);
    const std::filesystem::path copy = *command_ / "without index";
    std::filesystem::create_directories(copy / "attempts");
    std::filesystem::copy(attempt.folder, copy / "attempts" / attempt.id,
                          std::filesystem::copy_options::recursive);
    const Outcome list = records("list --records '" + copy.string() + "'");
    EXPECT_EQ(list.status, 0) << list.err;
    EXPECT_THAT(list.out, HasSubstr(attempt.id));
    EXPECT_THAT(list.out, HasSubstr("done"));
    EXPECT_EQ(Store(copy).attempt(attempt.id).events.size(), attempt.events.size());
    EXPECT_EQ(records("list --records '" + copy.string() + "/attempts'").status, 2) << "that is no store";
}

TEST_F(StoreRun, IsExportedWithItsChecksumsAndDeleted) {
    ASSERT_EQ(command_->runBare(kStoreRun + "Zebra-77").status, 0);
    const std::filesystem::path taken = *command_ / "taken";
    const Outcome exported = records("export --trainee Zebra-77 '" + taken.string() + "'");
    EXPECT_EQ(exported.status, 0) << exported.err;
    EXPECT_THAT(exported.out, HasSubstr("1 attempt in"));
    const std::string id = Store(folder()).attempts("Zebra-77").at(0).id;
    const auto told = nlohmann::json::parse(test::readText(taken / "attempts" / id / "attempt.json"));
    EXPECT_EQ(told.at("trainee"), "Zebra-77");
    EXPECT_GT(told.at("metrics").size(), 10u);
    EXPECT_EQ(records::loadSamples(taken / "attempts" / id / "record").torn_bytes, 0u);
    const std::string sums = test::readText(taken / "checksums.csv");
    for (const char* name :
         {"attempts.csv", "metrics.csv", "events.csv", "record/samples.bin", "summary.json"})
        EXPECT_THAT(sums, HasSubstr(name)) << name;
    EXPECT_THAT(test::readText(taken / "attempts.csv"), HasSubstr(id + ",Zebra-77,"));
    EXPECT_THAT(test::readText(taken / "attempts.csv"), Not(HasSubstr("T-01"))) << "nobody else's";
    EXPECT_EQ(records("export '" + taken.string() + "'").status, 2) << "not empty";

    EXPECT_EQ(records("delete --trainee Zebra-77").status, 0);
    EXPECT_FALSE(std::filesystem::exists(folder() / "attempts" / id));
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder()))
        if (entry.is_regular_file()) {
            EXPECT_THAT(test::readText(entry.path()), Not(HasSubstr("Zebra-77"))) << entry.path();
        }
}

TEST_F(StoreRun, RefusesConflictingOptions) {
    const Outcome name = command_->runBare(kStoreRun + "'Ann Example'");
    EXPECT_EQ(name.status, 2);
    EXPECT_THAT(name.err, HasSubstr("pseudonym"));
    EXPECT_GE(command_->runBare("run --fast --headless").status, 100) << "neither --out nor --trainee";
    EXPECT_GE(command_->runBare(kStoreRun + "T-01 --out /tmp/x").status, 100);
    EXPECT_GE(command_->runBare("run --fast --out /tmp/x --records /tmp/y").status, 100);
    EXPECT_GE(records("").status, 100);
    EXPECT_GE(records("sync").status, 100) << "no database is named";
}

TEST_F(StoreRun, AttemptWithoutTicksIsNotStored) {
    const Outcome none =
        command_->runBare("run --spacing-mm 2.5 --no-mirror --mute --device controllers --trainee T-11",
                          "XR_RUNTIME_JSON=/nonexistent.json ");
    EXPECT_EQ(none.status, 3) << none.err;
    EXPECT_THAT(none.err, HasSubstr("--device controllers needs a headset, and none is available"));
    EXPECT_THAT(none.err, Not(HasSubstr("continuing without pictures")));
    const Store store(folder());
    EXPECT_TRUE(store.attempts("T-11").empty());
    EXPECT_TRUE(store.recovered().empty());
    EXPECT_TRUE(store.unknownFolders().empty());
}

// Damage of a finished attempt fails the replay, even if every sample before it is as recomputed.
// HZ-RECORD-07
TEST_F(StoreRun, DamagedTruncatedOrMissingSamplesFailTheReplay) {
    const StoredAttempt attempt = Store(folder()).attempts("T-01").at(0);
    const std::filesystem::path damaged = *command_ / "damaged";
    const auto expectFails = [&](const std::string& problem, const auto& damage) {
        std::filesystem::remove_all(damaged);
        std::filesystem::copy(attempt.folder / "record", damaged);
        damage(damaged / "samples.bin");
        const Outcome again = command_->run("replay --fast '" + damaged.string() + "'");
        EXPECT_EQ(again.status, 1) << problem;
        EXPECT_THAT(again.out, HasSubstr(problem + " of " + std::to_string(attempt.result->ticks) +
                                         " samples could be compared\n"));
    };
    using Path = std::filesystem::path;
    expectFails("samples.bin: damaged from byte 40, 0", [](const Path& file) {
        std::string bytes = test::readText(file);
        bytes[5000] ^= 1;
        std::ofstream(file, std::ios::binary) << bytes;
    });
    expectFails("samples.bin: damaged from byte 40, 0",
                [](const Path& file) { std::filesystem::resize_file(file, 41); });
    expectFails("samples.bin: 0", [](const Path& file) { std::filesystem::resize_file(file, 40); });
    expectFails("samples.bin: missing, 0", [](const Path& file) { std::filesystem::remove(file); });
}

// The state after a kill shortly after samples.bin was created, and a longer attempt that was damaged later.
TEST_F(StoreRun, TruncatedSamplesOfAnAttemptThatWasCutShort) {
    constexpr std::uintmax_t kShort = 60'000;  // fewer ticks than a power failure can cost
    const StoredAttempt attempt = Store(folder()).attempts("T-01").at(0);
    const std::filesystem::path cut = *command_ / "headless";
    std::filesystem::copy(attempt.folder / "record", cut);
    std::filesystem::resize_file(cut / "samples.bin", 10);
    const std::string line = "replay --fast '" + cut.string() + "'";
    EXPECT_EQ(command_->run(line).status, 2) << "of an attempt that ended it is damage";
    auto info = nlohmann::json::parse(test::readText(cut / "record.json"));
    info.erase("final_tick"), info.erase("state_hash"), info.erase("result");
    std::ofstream(cut / "record.json") << info;
    EXPECT_EQ(command_->run(line).status, 1) << "too many samples are missing";
    std::filesystem::resize_file(cut / "inputs.bin", kShort);
    for (const char* problem : {"damaged from byte 0", "missing"}) {
        const Outcome again = command_->run(line);
        EXPECT_EQ(again.status, 0) << again.err;
        EXPECT_THAT(again.out, HasSubstr(std::string("samples.bin: ") + problem + ", 0 of "));
        std::filesystem::remove(cut / "samples.bin");
    }
}

// Kills the whole program. Every other kill happens at any time between start and end, the others during the
// attempt.
// HZ-RECORD-01
TEST_F(StoreRun, KilledRunLeavesOnlyWholeFrames) {
    std::mt19937_64 random(test::seed());
    std::size_t acknowledged = Store(folder()).attempts("T-09").size(), cut = 0;
    for (int i = 0; i < kKills || (cut == 0 && i < kMaxKills); ++i) {
        const double share = std::uniform_real_distribution<double>(0.0, 1.0)(random);
        const Outcome killed = i % 2 == 0 ? killedAfter(share * whole_s_) : killedInItsAttempt(0.05 * share);
        const bool said = killed.out.find("stored as attempt") != std::string::npos;
        acknowledged += said;
        const Store store(folder());
        for (const records::RecoveredAttempt& found : store.recovered()) {
            ++cut;
            const StoredAttempt attempt = store.attempt(found.id);
            EXPECT_EQ(attempt.state, AttemptState::cut_short);
            // A run may die before it has made the file, or before the first byte.
            const std::filesystem::path file = attempt.folder / "record" / "samples.bin";
            if (!std::filesystem::exists(file) || std::filesystem::file_size(file) == 0) continue;
            const records::Samples samples = records::loadSamples(attempt.folder / "record");
            const records::Record record = records::loadRecord(attempt.folder / "record");
            EXPECT_EQ(samples.torn_bytes, 0u);
            EXPECT_EQ(record.torn_bytes, 0u);
            EXPECT_LE(record.inputs.size() > samples.samples.size()
                          ? record.inputs.size() - samples.samples.size()
                          : samples.samples.size() - record.inputs.size(),
                      records::kFrameTicks);
        }
        std::size_t done = 0;
        for (const StoredAttempt& attempt : store.attempts("T-09"))
            done += attempt.state == AttemptState::done;
        EXPECT_GE(done, acknowledged);
        EXPECT_TRUE(store.damage().empty());
    }
    EXPECT_GT(cut, 0u);
    const std::vector<StoredAttempt> all = Store(folder()).attempts("T-09");
    for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_EQ(all[i].info.difficulty, "guided") << "a script teaches nobody";
}

}  // namespace
}  // namespace stylet::trainer
