// Six scripted trainees, from the expert of procedure.toml to a reckless one. Their scores must rank in
// that order on patients with random seeds.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "app/records/replay.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

constexpr std::array<const char*, 6> kFromExpertToReckless{"procedure",        "trainee-good",
                                                           "trainee-hesitant", "trainee-sloppy",
                                                           "trainee-careless", "trainee-reckless"};

Scenario shipped(const std::string& name) {
    return loadScenario(test::assets() / "scenarios" / (name + ".toml"));
}

SessionLog playedWithSeed(const patient::Patient& patient, const patient::PlannedPath& path,
                          const Scenario& scenario, std::uint64_t seed) {
    const Attempt attempt = makeAttempt(patient, scenario, path, seed);
    Session session(patient, path, scenario.moments, scenario.approach_distance_m, nullptr);
    runFast(attempt, session, nullptr, 0.0, {});
    return session.log();
}

std::string lostBy(const SessionLog& log) {
    std::string text;
    for (std::size_t i = 0; i < training::kMetricCount; ++i)
        if (const double lost = log.score.max_points[i] - log.score.points[i]; lost >= 0.5)
            text +=
                " " + std::string(training::metricTable()[i].id) + " -" + std::to_string(lost).substr(0, 4);
    return text;
}

int seedsToDraw() {
#if defined(STYLET_SANITIZED)
    return 1;  // a tick takes ten times as long with a sanitizer
#elif defined(STYLET_LONG_TESTS)
    return 25;
#else
    return 5;
#endif
}

struct OpenPath {
    patient::PlannedPath path;
    SessionLog expert;  // the expert's attempt on this path
};

// Finds the best path on which no rib hides the duct from the expert's probe. Unlike a person, a script
// cannot turn the probe further. A rib hides the duct on about one path in fifty.
OpenPath openTo(const patient::Patient& patient, const Scenario& expert,
                const std::vector<patient::PlannedPath>& paths, std::uint64_t seed) {
    OpenPath open;
    for (std::size_t i = 0; i < std::min<std::size_t>(paths.size(), 3); ++i) {
        open = {paths[i], playedWithSeed(patient, paths[i], expert, seed)};
        if (open.expert.progress.step != training::Step::findDuct) break;
    }
    return open;
}

// HZ-TEACH-01
TEST(Trainees, RankByErrorOnRandomPatients) {
    std::mt19937_64 random(test::seed());
    for (int n = 0; n < seedsToDraw(); ++n) {
        const std::uint64_t seed = 1 + random() % 1'000'000;
        SCOPED_TRACE("seed " + std::to_string(seed));
        patient::synth::SynthSettings settings;
        settings.seed = seed;
        settings.spacing_m = 0.0025;
        settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
        const patient::Package package = patient::synth::makeReferencePatient(settings);
        const patient::Patient patient(package);
        const patient::PlanResult plan = patient::planPaths(patient, {});
        ASSERT_FALSE(plan.paths.empty());
        const OpenPath open = openTo(patient, shipped(kFromExpertToReckless.front()), plan.paths, seed);
        std::string line = "seed " + std::to_string(seed) + ":";
        double last = 101.0;
        for (const char* name : kFromExpertToReckless) {
            const SessionLog log = name == kFromExpertToReckless.front()
                                       ? open.expert
                                       : playedWithSeed(patient, open.path, shipped(name), seed);
            line += " " + std::to_string(log.score.total).substr(0, 4);
            EXPECT_LT(log.score.total, last) << name << lostBy(log);
            last = log.score.total;
            if (name == kFromExpertToReckless.front()) {
                EXPECT_GT(log.score.total, 85.0) << lostBy(log);
                EXPECT_TRUE(log.target_hit());
                EXPECT_EQ(log.progress.step, training::Step::done);
                EXPECT_EQ(log.progress.out_of_order, 0u);
            }
            if (name == kFromExpertToReckless.back()) {
                EXPECT_LT(log.score.total, 40.0) << lostBy(log);
            }
        }
        std::puts(line.c_str());
    }
}

// The score is computed from the recorded data only, so a replay gives the same score bit for bit.
// HZ-TEACH-01
TEST(Trainees, ReplayGivesTheSameScore) {
    const test::TempFolder folder;
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const Scenario scenario = shipped("procedure");
    const Attempt attempt = makeAttempt(patient, scenario, test::ductPath(), 7);
    records::RecordInfo info;
    info.path = test::ductPath();
    records::RecordWriter writer(folder / "record", {patient::digest(package), attempt.simulation}, info);
    Session session(patient, test::ductPath(), {}, 0.0, &writer);
    runFast(attempt, session, nullptr, 0.0, {});
    writer.finish();
    const SessionLog& log = session.log();
    EXPECT_EQ(log.progress.step, training::Step::done);
    EXPECT_GT(log.score.total, 85.0) << lostBy(log);

    Session again(patient, test::ductPath(), {}, 0.0, nullptr);
    const auto watch = [&](const haptics::TickInput& input, const haptics::TickOutput& output,
                           const haptics::NeedleEvents& events) { again.update(input, output, events); };
    EXPECT_TRUE(records::replay(patient, records::loadRecord(folder / "record"), watch).equal());
    EXPECT_EQ(again.log().score.values, log.score.values);
    EXPECT_EQ(again.log().score.total, log.score.total);
    ASSERT_EQ(again.log().events.size(), log.events.size());
    for (std::size_t i = 0; i < log.events.size(); ++i) {
        EXPECT_EQ(again.log().events[i].tick, log.events[i].tick);
        EXPECT_EQ(again.log().events[i].text, log.events[i].text);
    }
}

}  // namespace
}  // namespace stylet::trainer
