// Six scripted trainees, from the expert of procedure.toml to a reckless one. Their scores must rank in
// that order on patients with random seeds.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "app/records/replay.h"
#include "app/training/score.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/attempt/cheats.h"
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

// Lost points and what was refused, for messages of failed tests.
std::string describe(const SessionLog& log) {
    std::string text;
    for (const training::SessionEvent& event : log.events)
        if (event.kind == "refused" || event.kind == "critical")
            text += "\n  " + event.kind + ": " + event.text;
    text += "\n  lost:";
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
    return 50;
#else
    return 4;
#endif
}

struct OpenPath {
    patient::PlannedPath path;
    SessionLog expert;  // the expert's attempt on this path
};

// Finds the best path on which the expert's script does every step. Unlike a person, a script cannot turn the
// probe further when a rib hides the duct, and cannot search for a rib that its finger slides past. Both
// happen on a few paths in a hundred.
OpenPath openTo(const patient::Patient& patient, const Scenario& expert,
                const std::vector<patient::PlannedPath>& paths, std::uint64_t seed) {
    OpenPath open;
    for (std::size_t i = 0; i < std::min<std::size_t>(paths.size(), 5); ++i) {
        open = {paths[i], playedWithSeed(patient, paths[i], expert, seed)};
        if (open.expert.progress.step == training::Step::done) break;
    }
    return open;
}

// The distance of two groups of totals in units of their pooled standard deviation.
double separation(const std::vector<double>& better, const std::vector<double>& worse) {
    const auto moments = [](const std::vector<double>& x) {
        double mean = 0.0, square = 0.0;
        for (const double v : x)
            mean += v / double(x.size());
        for (const double v : x)
            square += (v - mean) * (v - mean) / std::max(1.0, double(x.size()) - 1.0);
        return std::pair(mean, square);
    };
    const auto [high, high2] = moments(better);
    const auto [low, low2] = moments(worse);
    return (high - low) / std::sqrt(std::max(1e-6, 0.5 * (high2 + low2)));
}

// The patients on which trainees and cheats are compared. Their seeds are drawn.
class Patients {
  public:
    explicit Patients(int count) : left_(count) {}
    // Makes the next patient. Returns false after the last one.
    bool next() {
        if (left_-- == 0) return false;
        seed_ = 1 + random_() % 1'000'000;
        patient::synth::SynthSettings settings;
        settings.seed = seed_;
        settings.spacing_m = 0.0025;
        settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
        patient_.reset();
        package_ = patient::synth::makeReferencePatient(settings);
        patient_.emplace(package_);
        open_ = openTo(*patient_, shipped(kFromExpertToReckless.front()),
                       patient::planPaths(*patient_, {}).paths, seed_);
        return true;
    }
    std::uint64_t seed() const { return seed_; }
    const SessionLog& expert() const { return open_.expert; }
    SessionLog play(const Scenario& scenario) const {
        return playedWithSeed(*patient_, open_.path, scenario, seed_);
    }

  private:
    std::mt19937_64 random_{test::seed()};
    int left_;
    std::uint64_t seed_ = 0;
    patient::Package package_;
    std::optional<patient::Patient> patient_;
    OpenPath open_;
};

// HZ-TEACH-01
TEST(Trainees, RankByErrorOnRandomPatients) {
    std::array<std::vector<double>, kFromExpertToReckless.size()> totals;
    for (Patients patients(seedsToDraw()); patients.next();) {
        SCOPED_TRACE("seed " + std::to_string(patients.seed()));
        std::string line = "seed " + std::to_string(patients.seed()) + ":";
        double last = 101.0;
        for (std::size_t who = 0; who < kFromExpertToReckless.size(); ++who) {
            const char* name = kFromExpertToReckless[who];
            const SessionLog log = who == 0 ? patients.expert() : patients.play(shipped(name));
            line += fmt::format(" {:.1f}{}", log.score.total, training::passesExam(log.progress) ? "+" : "");
            totals[who].push_back(log.score.total);
            EXPECT_LT(log.score.total, last) << name << describe(log);
            last = log.score.total;
            if (who == 0) {
                EXPECT_GT(log.score.total, 90.0) << describe(log);
                EXPECT_TRUE(training::passesExam(log.progress)) << describe(log);
                EXPECT_TRUE(log.target_hit());
                EXPECT_EQ(log.progress.step, training::Step::done);
                EXPECT_EQ(log.progress.out_of_order, 0u);
            }
            if (who + 1 == kFromExpertToReckless.size()) {
                EXPECT_LT(log.score.total, 40.0) << describe(log);
                EXPECT_FALSE(training::passesExam(log.progress));
            }
        }
        std::puts(line.c_str());
    }
    for (std::size_t who = 1; who < totals.size(); ++who) {
        const double d = separation(totals[who - 1], totals[who]);
        std::puts(fmt::format("d' of {} to {}: {:.1f}", kFromExpertToReckless[who - 1],
                              kFromExpertToReckless[who], d)
                      .c_str());
        EXPECT_GT(d, 1.0) << kFromExpertToReckless[who];
    }
}

// HZ-TEACH-01
TEST(Trainees, EveryCheatFailsOnRandomPatients) {
    for (Patients patients(seedsToDraw()); patients.next();) {
        SCOPED_TRACE("seed " + std::to_string(patients.seed()));
        std::string line = "seed " + std::to_string(patients.seed()) + ":";
        for (const test::Cheat& cheat : test::cheats()) {
            const SessionLog log = patients.play(cheat.scenario);
            line += fmt::format(" {:.1f}", log.score.total);
            EXPECT_LT(log.score.total, 40.0) << cheat.name << describe(log);
            EXPECT_FALSE(training::passesExam(log.progress)) << cheat.name;
        }
        std::puts(line.c_str());
    }
}

// Waiting at the end of an attempt, or without any attempt, earns nothing.
// HZ-TEACH-01
TEST(Trainees, WaitingNeverRaisesAScore) {
    Patients patients(1);
    ASSERT_TRUE(patients.next());
    for (const char* name : kFromExpertToReckless) {
        Scenario longer = shipped(name);
        const double before = patients.play(longer).score.total;
        longer.stages.push_back({.kind = StageKind::wait, .seconds = 30.0});
        EXPECT_LE(patients.play(longer).score.total, before) << name;
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
    EXPECT_GT(log.score.total, 85.0) << describe(log);

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
