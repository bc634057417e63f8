// Six scripted trainees of each course, from the expert to a reckless one. Their scores must rank in that
// order on patients with random seeds.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <optional>
#include <random>

#include "app/records/replay.h"
#include "app/trainer/attempt/reference_path.h"
#include "app/training/score.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/attempt/cheats.h"
#include "tests/app/trainer/attempt/trainees.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/app/trainer/scripted_attempt.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using patient::PlannedPath;
using training::Course;

constexpr std::size_t kMaxTried = 5;  // paths on which the expert's script is played
constexpr std::size_t kEnough = 10;   // totals to estimate a spread from: with STYLET_LONG_TESTS

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

int patientsToDraw([[maybe_unused]] Course course) {
#if defined(STYLET_SANITIZED)
    return 1;  // a tick takes ten times as long with a sanitizer
#elif defined(STYLET_LONG_TESTS)
    return 50;
#else
    return course == Course::puncture ? 3 : 2;
#endif
}

// The paths from which the wire goes down the duct even if the needle's tip lies beside the target. Unlike a
// person, a script cannot turn the needle when the wire stops.
std::vector<PlannedPath> pathsOpenToWire(const patient::Patient& patient,
                                         const std::vector<PlannedPath>& paths) {
    constexpr std::size_t kMaxChecked = 100;
    const patient::DuctSpace ducts = patient::makeDuctSpace(patient);
    std::vector<PlannedPath> open;
    for (std::size_t i = 0; i < std::min(paths.size(), kMaxChecked) && open.size() < kMaxTried; ++i)
        if (sureWireReach_m(ducts, paths[i]) >= kSureReach_m) open.push_back(paths[i]);
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

bool didAll(const SessionLog& log) {
    return log.progress.steps_done == training::stepsOf(log.progress);
}

bool touchedNoRisk(const SessionLog& log) {
    for (std::size_t i = 0; i < training::kMetricCount; ++i)
        if (training::metricTable()[i].id == "no_go_touches") return log.score.values[i] == 0.0;
    ADD_FAILURE() << "there is no such metric";
    return false;
}

// Bodies of the patients, in turn: variants of the reference patient, or none. The seed chooses the first
// one. The drainages begin with the fourth, so that three punctures and a drainage have all bodies.
constexpr std::array<std::string_view, 4> kBodies{"", "thin", "obese", "ascites"};

// A patient with a drawn seed, a path, and the expert's attempt on it.
struct DrawnPatient {
    DrawnPatient(std::uint64_t drawn, std::string_view its_body, Course course)
        : seed(drawn), body(its_body), package(makePackage(drawn, its_body)), scripted(choosePath(course)) {}
    std::string name() const { return fmt::format("seed {} {}", seed, body); }
    SessionLog play(const Scenario& scenario) const {
        return test::playScripted(patient, touch, path, scenario, seed);
    }
    // The attempt of one of the course's trainees. Each is played once.
    const SessionLog& trainee(const Scenario& scenario) const {
        const auto found = trainees_.find(scenario.name);
        return found != trainees_.end() ? found->second
                                        : trainees_.emplace(scenario.name, play(scenario)).first->second;
    }

    std::uint64_t seed;
    std::string_view body;
    patient::Package package;
    patient::Patient patient{package};
    haptics::TouchMap touch = haptics::makeTouchMap(patient);
    PlannedPath path;
    SessionLog expert;
    // The expert's script touches no risk structure and does every step on the path, also with a lighter
    // probe.
    bool scripted;

  private:
    mutable std::map<std::string, SessionLog> trainees_;  // by the scenario's name

    static patient::Package makePackage(std::uint64_t drawn, std::string_view body) {
        patient::synth::SynthSettings settings;
        settings.seed = drawn;
        if (!body.empty()) settings.variants = {std::string(body)};
        settings.spacing_m = 0.0025;
        settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
        return patient::synth::makeReferencePatient(settings);
    }
    // Finds the best path on which the expert's script touches no risk structure and does every step, also
    // with less pressure on the probe. Unlike a person, a script cannot turn the probe further when a rib
    // hides the duct, cannot search for a rib that its finger slides past, cannot press harder where the
    // probe hardly touches the skin, and cannot aim again before its needle enters a vessel. Each happens on
    // a few paths in a hundred. With less pressure, because the other trainees' hands are less steady.
    bool choosePath(Course course) {
        const Scenario script = test::makeTrainees(course).front(), lighter = test::withLighterProbe(script);
        std::vector<PlannedPath> paths = patient::planPaths(patient, {}).paths;
        if (course == Course::drainage) paths = pathsOpenToWire(patient, paths);
        for (std::size_t i = 0; i < std::min(paths.size(), kMaxTried); ++i) {
            path = paths[i];
            expert = play(script);
            if (didAll(expert) && touchedNoRisk(expert) && didAll(play(lighter))) return true;
        }
        return false;
    }
};

// Draws a patient on which the expert's script touches no risk structure and does every step.
// `number` counts the patients of the course: each has its own random numbers, so that no test changes those
// of another.
std::unique_ptr<const DrawnPatient> drawPatient(Course course, std::uint64_t number) {
    constexpr int kMaxDrawn = 6;
    const std::uint64_t seed = test::seed();
    std::seed_seq parts{seed, seed >> 32, std::uint64_t(course), number};
    std::mt19937_64 random(parts);
    const std::uint64_t begin = seed + (course == Course::drainage ? 3 : 0);
    const std::string_view body = kBodies[(begin + number) % kBodies.size()];
    std::unique_ptr<const DrawnPatient> drawn;
    for (int i = 0; i < kMaxDrawn; ++i) {
        drawn = std::make_unique<const DrawnPatient>(1 + random() % 1'000'000, body, course);
        if (drawn->scripted) break;
        std::puts(fmt::format("{}: on {} paths the script of the expert touches a risk structure or does not "
                              "do every step, also with a lighter probe{}",
                              drawn->name(), kMaxTried, describe(drawn->expert))
                      .c_str());
    }
    return drawn;
}

// The patients on which trainees and cheats are compared. The tests of a course share the first ones, because
// making a patient takes longer than most attempts.
class Patients {
  public:
    Patients(int count, Course course) : left_(count), course_(course) {}
    // Moves on to the next patient. Returns false after the last one.
    bool next() {
        if (left_-- == 0) return false;
        std::vector<std::unique_ptr<const DrawnPatient>>& shared = shared_[course_];
        const std::size_t number = next_++;
        if (number >= shared.size()) {
            own_.reset();
            own_ = drawPatient(course_, number);
            current_ = own_.get();
            if (shared.size() < kMaxShared) shared.push_back(std::move(own_));
        } else {
            current_ = shared[number].get();
        }
        return true;
    }
    std::string name() const { return current_->name(); }
    std::uint64_t seed() const { return current_->seed; }
    const SessionLog& expert() const { return current_->expert; }  // the expert's attempt
    const SessionLog& trainee(const Scenario& scenario) const { return current_->trainee(scenario); }
    SessionLog play(const Scenario& scenario) const { return current_->play(scenario); }

  private:
    static constexpr std::size_t kMaxShared = 4;
    static inline std::map<Course, std::vector<std::unique_ptr<const DrawnPatient>>> shared_;

    int left_;
    Course course_;
    std::size_t next_ = 0;
    std::unique_ptr<const DrawnPatient> own_;
    const DrawnPatient* current_ = nullptr;
};

void expectRanks(Course course) {
    const std::vector<Scenario> trainees = test::makeTrainees(course);
    std::vector<std::vector<double>> totals(trainees.size());
    // Totals of each trainee and of the one before, on the patients on which the two are compared.
    std::vector<std::vector<double>> better_totals(trainees.size());
    for (Patients patients(patientsToDraw(course), course); patients.next();) {
        SCOPED_TRACE(patients.name());
        std::string line = patients.name() + ":";
        double last = 101.0;
        bool last_placed = true;
        std::string better;
        for (std::size_t who = 0; who < trainees.size(); ++who) {
            const SessionLog& log = who == 0 ? patients.expert() : patients.trainee(trainees[who]);
            line += fmt::format(" {:.1f}{}", log.score.total, training::passesExam(log.progress) ? "+" : "");
            // On one patient in 66, the sloppy trainee's drain missed the duct and the careless one's hit it.
            // Then the careless one has done more of the procedure, and the two are not compared.
            const bool placed = training::contains(log.progress.steps_done, training::Step::drain);
            if (!placed || last_placed) {
                EXPECT_LT(log.score.total, last)
                    << trainees[who].name << describe(log) << "\nwho should be better:" << better;
                totals[who].push_back(log.score.total);
                better_totals[who].push_back(last);
            } else {
                EXPECT_FALSE(training::passesExam(log.progress)) << trainees[who].name << describe(log);
            }
            last = log.score.total, last_placed = placed, better = describe(log);
            if (who == 0) {
                EXPECT_GT(log.score.total, 90.0) << describe(log);
                EXPECT_TRUE(training::passesExam(log.progress)) << describe(log);
                EXPECT_TRUE(log.target_hit());
                EXPECT_EQ(log.progress.step, training::Step::done);
                EXPECT_EQ(log.progress.out_of_order, 0u);
            }
            if (who + 1 == trainees.size()) {
                EXPECT_LT(log.score.total, 40.0) << describe(log);
                EXPECT_FALSE(training::passesExam(log.progress));
            }
        }
        std::puts(line.c_str());
    }
    for (std::size_t who = 1; who < totals.size(); ++who) {
        if (totals[who].size() < kEnough) continue;
        const double d = separation(better_totals[who], totals[who]);
        std::puts(
            fmt::format("d' of {} to {}: {:.1f}", trainees[who - 1].name, trainees[who].name, d).c_str());
        EXPECT_GT(d, 1.0) << trainees[who].name;
    }
}

void expectEveryCheatFails(const Patients& patients, Course course) {
    std::string line = patients.name() + ":";
    for (const test::Cheat& cheat : test::makeCheats(course)) {
        const SessionLog log = patients.play(cheat.scenario);
        line += fmt::format(" {:.1f}", log.score.total);
        EXPECT_LT(log.score.total, 40.0) << cheat.name << describe(log);
        EXPECT_FALSE(training::passesExam(log.progress)) << cheat.name;
    }
    std::puts(line.c_str());
}

// Leaving a part out never pays, and an exam without a part that the patient needs is failed.
void expectOmissionsCost(Course course) {
    Patients patients(1, course);
    ASSERT_TRUE(patients.next());
    ASSERT_TRUE(training::passesExam(patients.expert().progress))
        << "seed " << patients.seed() << describe(patients.expert());
    for (const test::Omission& omission : test::makeOmissions(course)) {
        const SessionLog log = patients.play(omission.scenario);
        std::puts(fmt::format("without {}: {:.1f} of the expert's {:.1f}", omission.left_out, log.score.total,
                              patients.expert().score.total)
                      .c_str());
        EXPECT_LT(log.score.total, patients.expert().score.total - 4.0)
            << "without " << omission.left_out << ", seed " << patients.seed();
        if (omission.fails_exam) {
            EXPECT_FALSE(training::passesExam(log.progress))
                << "without " << omission.left_out << ", seed " << patients.seed() << describe(log);
        }
    }
}

// HZ-TEACH-25
TEST(Trainees, OmissionsInAPunctureCost) {
    expectOmissionsCost(Course::puncture);
}

// HZ-TEACH-01
TEST(Trainees, RankByErrorOnRandomPatients) {
    expectRanks(Course::puncture);
}

// HZ-TEACH-01
TEST(Trainees, EveryCheatFailsOnRandomPatients) {
    for (Patients patients(patientsToDraw(Course::puncture), Course::puncture); patients.next();) {
        SCOPED_TRACE(patients.name());
        expectEveryCheatFails(patients, Course::puncture);
    }
}

// With a sanitizer, drainage_test runs the code of the drainage.
#if !defined(STYLET_SANITIZED)

// HZ-TEACH-25
TEST(Trainees, OmissionsInADrainageCost) {
    expectOmissionsCost(Course::drainage);
}

// HZ-TEACH-01
TEST(Trainees, RankByErrorInADrainage) {
    expectRanks(Course::drainage);
}

bool isNumb(const Stage& stage) {
    return stage.kind == StageKind::numb;
}

// The whole drainage, but the needle is drawn back into the body wall before the wire is taken. In the liver
// it might lie in another duct.
Scenario withoutADuctForTheWire(Scenario expert) {
    const auto wire = std::ranges::find_if(expert.stages, [](const Stage& s) {
        return s.kind == StageKind::changeTool && s.tool == haptics::Tool::wire;
    });
    expert.stages.insert(wire, Stage{.kind = StageKind::move,
                                     .to = {.share = 1.0, .deeper_m = -0.003, .to_capsule = true},
                                     .speed_m_s = 0.02});
    return expert;
}

// The whole drainage with `ml` of local anaesthetic. What is more than the expert's lies at the capsule.
Scenario withAnaesthetic(Scenario expert, double ml) {
    for (const Stage& stage : expert.stages)
        if (isNumb(stage)) ml -= training::kMlPerM3 * stage.injected_m3_per_s * stage.seconds;
    const double m3_per_s = training::kMaxAnaestheticRate_m3_per_s;
    const auto after_last = std::find_if(expert.stages.rbegin(), expert.stages.rend(), isNumb).base();
    expert.stages.insert(after_last, Stage{.kind = StageKind::numb,
                                           .seconds = ml / (training::kMlPerM3 * m3_per_s),
                                           .injected_m3_per_s = m3_per_s});
    return expert;
}

// The whole drainage with another review of the case, or without one.
Scenario withReview(Scenario expert, std::optional<ReviewAnswers> answers) {
    const auto review = std::ranges::find(expert.stages, StageKind::review, &Stage::kind);
    if (answers)
        review->answers = *answers;
    else
        expert.stages.erase(review);
    return expert;
}

// HZ-TEACH-01, HZ-TEACH-23, HZ-TEACH-25, HZ-TEACH-26
TEST(Trainees, EveryCheatOfADrainageFails) {
    const Scenario expert = test::makeTrainees(Course::drainage).front();
    bool first = true;
    for (Patients patients(patientsToDraw(Course::drainage), Course::drainage); patients.next();
         first = false) {
        SCOPED_TRACE(patients.name());
        expectEveryCheatFails(patients, Course::drainage);
        if (!first) continue;  // the rest depends on no body
        const auto passes = [&](const Scenario& scenario) {
            return training::passesExam(patients.play(scenario).progress);
        };
        EXPECT_FALSE(passes(withoutADuctForTheWire(expert))) << "a good puncture is no drainage";
        EXPECT_TRUE(passes(withAnaesthetic(expert, 29.5)));
        EXPECT_FALSE(passes(withAnaesthetic(expert, 30.5))) << "an overdose";
        EXPECT_FALSE(passes(withReview(expert, std::nullopt))) << "no review";
        EXPECT_FALSE(passes(withReview(expert, ReviewAnswers::yes)));
        EXPECT_FALSE(passes(withReview(expert, ReviewAnswers::wrong)));
        EXPECT_LT(patients.play(withReview(expert, ReviewAnswers::no)).score.total,
                  patients.expert().score.total - 1.0);
    }
}

#endif

// Waiting at the end of an attempt, or without any attempt, earns nothing.
// HZ-TEACH-01
TEST(Trainees, WaitingNeverRaisesAScore) {
    Patients patients(1, Course::puncture);
    ASSERT_TRUE(patients.next());
    for (const Scenario& trainee : test::makeTrainees(Course::puncture)) {
        const double before = patients.trainee(trainee).score.total;
        Scenario longer = trainee;
        longer.stages.push_back({.kind = StageKind::wait, .seconds = 30.0});
        EXPECT_LE(patients.play(longer).score.total, before) << trainee.name;
    }
}

// The score is computed from the recorded data only, so a replay gives the same score bit for bit.
// HZ-TEACH-01
TEST(Trainees, ReplayGivesTheSameScore) {
    const test::TempFolder folder;
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const Scenario scenario = test::makeTrainees(Course::puncture).front();
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
