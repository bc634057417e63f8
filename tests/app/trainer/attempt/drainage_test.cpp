// The whole drainage on synthetic patients: needle, wire, dilator, drain (assets/scenarios/drainage.toml).
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "app/records/replay.h"
#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/attempt/retry.h"
#include "app/training/pain.h"
#include "app/training/score.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/app/trainer/scripted_attempt.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using haptics::AccessOutput;
using haptics::DrainState;
using haptics::Tool;

Scenario drainage() {
    return loadScenario(test::assets() / "scenarios" / "drainage.toml");
}

patient::Package synthPackage(std::uint64_t seed) {
    patient::synth::SynthSettings settings;
    settings.spacing_m = 0.002;
    settings.seed = seed;
    settings.defaults = test::tissueDefaults();
    return patient::synth::makeReferencePatient(settings);
}

struct SynthPatient {
    explicit SynthPatient(std::uint64_t seed) : package(synthPackage(seed)) {}

    patient::Package package;
    patient::Patient patient{package};
    std::vector<patient::PlannedPath> paths = patient::planPaths(patient, {}).paths;
    patient::DuctSpace ducts = patient::makeDuctSpace(patient);
    patient::PlannedPath path = paths.empty() ? patient::PlannedPath{} : pathForWire(ducts, paths);
    haptics::TouchMap touch = haptics::makeTouchMap(patient);
};

// The patient of most tests.
const SynthPatient& firstPatient() {
    static const SynthPatient patient(1);
    return patient;
}

bool refused(const std::vector<training::SessionEvent>& events, training::Refusal why) {
    return std::ranges::any_of(events, [&](const training::SessionEvent& e) {
        return e.kind == "refused" && e.text == training::refusalText(why);
    });
}

// What the wire, dilator and drain did during an attempt.
struct Played {
    AccessOutput last;
    double wire_m = 0.0, in_duct_m = 0.0, dilated_m = 0.0;  // furthest
    double wire_n = 0.0, dilator_n = 0.0;                   // largest force
    bool buckled = false, pierced = false;
    bool equal = false;  // the record's replay gave the same hash and the same score
    std::uint32_t faults = 0;
    training::Progress progress;
    double torn_mm = 0.0;  // of the track, by the drain
    std::vector<training::SessionEvent> events;
    bool refused(training::Refusal why) const { return trainer::refused(events, why); }
    bool done(training::Step step) const { return training::contains(progress.steps_done, step); }
};

Played play(const SynthPatient& p, const patient::PlannedPath& path, const Scenario& scenario) {
    const patient::Patient& patient = p.patient;
    const auto touch = [&p](const patient::Patient&) { return p.touch; };
    const test::TempFolder folder;
    const Attempt attempt = makeAttempt(patient, scenario, path, 1, 1000.0, touch);
    records::RecordInfo info;
    info.path = path;
    if (scenario.patient_case) info.patient_case = scenario.patient_case->toml;
    records::RecordWriter writer(folder / "record", {patient::digest(patient.package()), attempt.simulation},
                                 info);
    Session session(patient, path, scenario.moments, scenario.approach_distance_m, &writer);
    session.setCourse(scenario.course);
    session.setCase(scenario.patient_case);
    runFast(attempt, session, nullptr, 0.0, {});
    writer.finish();
    Played played;
    played.faults = session.log().faults;
    played.progress = session.log().progress;
    played.torn_mm = session.log().score.values[std::size_t(training::MetricId::tornTrack)];
    played.events = session.log().events;
    const records::Record record = records::loadRecord(folder / "record");
    Session replayed(patient, path, {}, 0.0, nullptr);
    replayed.setCourse(scenario.course);
    replayed.setCase(recordedCase(record.info));
    const records::ReplayResult again = records::replay(
        patient, record,
        [&](const haptics::TickInput& input, const haptics::TickOutput& out,
            const haptics::NeedleEvents& events) {
            replayed.update(input, out, events);
            const AccessOutput& now = played.last = out.access;
            played.wire_m = std::max(played.wire_m, now.wire_m);
            played.in_duct_m = std::max(played.in_duct_m, now.in_duct_m);
            played.dilated_m = std::max(played.dilated_m, now.dilated_m);
            played.buckled = played.buckled || now.buckled;
            played.pierced = played.pierced || now.pierced;
            const double force_n = glm::length(out.tool_force.force_n);
            if (out.tool == Tool::wire) played.wire_n = std::max(played.wire_n, force_n);
            if (out.tool == Tool::dilator) played.dilator_n = std::max(played.dilator_n, force_n);
        },
        touch);
    played.equal = again.equal() && again.state_hash == session.log().state_hash &&
                   replayed.log().score.total == session.log().score.total;
    return played;
}

// The expert's drainage of the first patient.
const Played& expertsDrainage() {
    static const Played played = play(firstPatient(), firstPatient().path, drainage());
    return played;
}

// Sanitizers look for faults of the code, and one patient suffices for that. In random patients,
// trainees_test plays the expert too.
#if defined(STYLET_SANITIZED)
constexpr std::uint64_t kSeeds = 1;
#else
constexpr std::uint64_t kSeeds = 2;
#endif

// HZ-TEACH-12
TEST(Drainage, TheExpertDoesEveryStepInPatientsOfSeveralSeeds) {
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
        Scenario scenario = drainage();
        drawCase(scenario, seed);
        std::optional<SynthPatient> other;
        const SynthPatient& p = seed == 1 ? firstPatient() : other.emplace(seed);
        ASSERT_FALSE(p.paths.empty()) << seed;
        const double reach_m = wireReach_m(p.ducts, p.path);
        EXPECT_GE(reach_m, wireReach_m(p.ducts, p.paths.front())) << seed;
        EXPECT_GE(sureWireReach_m(p.ducts, p.path), kSureReach_m) << seed;
        // The script holds the probe in the same way for every path: on some of them a rib hides the duct.
        Played played;
        int tried = 0;
        for (const patient::PlannedPath& path : p.paths) {
            if (played.progress.steps_done == training::kAllSteps || tried == 4) break;
            if (wireReach_m(p.ducts, path) < 0.8 * reach_m) continue;
            ++tried;
            played = play(p, path, scenario);
            EXPECT_TRUE(played.equal) << seed;
        }
        EXPECT_EQ(played.faults, 0u) << seed;
        EXPECT_EQ(played.progress.steps_done, training::kAllSteps)
            << seed << ": " << stepName(played.progress.step);
        EXPECT_EQ(played.progress.out_of_order, 0u) << seed;
        EXPECT_GT(played.progress.total, 90.0) << seed;
        EXPECT_TRUE(training::passesExam(played.progress)) << seed;
        EXPECT_FALSE(played.pierced) << seed;
        EXPECT_EQ(played.last.holes_in_duct, 1.0) << seed;
        EXPECT_EQ(played.torn_mm, 0.0) << seed;
        EXPECT_GT(played.dilator_n, 1.0) << seed;
    }
}

// Places of the scenario that are at the duct, moved along the path.
Scenario shortOfTheDuct(double by_m) {
    Scenario scenario = drainage();
    for (Stage& stage : scenario.stages)
        if (stage.kind == StageKind::move && stage.to.share == 1.0) stage.to.deeper_m -= by_m;
    return scenario;
}

// The expert's pain is that of the first prick. Without local anaesthesia everything hurts, and it costs
// points. HZ-TEACH-23
TEST(Drainage, WithoutLocalAnaesthesiaItHurts) {
    const SynthPatient& p = firstPatient();
    Scenario painful = drainage();
    std::erase_if(painful.stages, [](const Stage& s) { return s.kind == StageKind::numb; });
    const Played &with = expertsDrainage(), without = play(p, p.path, painful);
    EXPECT_LE(with.progress.worst_pain, training::kSkinPrick);
    EXPECT_TRUE(with.done(training::Step::anaesthetise));
    EXPECT_GE(without.progress.worst_pain, training::kDilatationPain);
    EXPECT_FALSE(without.done(training::Step::anaesthetise));
    EXPECT_LT(without.progress.total, with.progress.total - 5.0);
    EXPECT_TRUE(without.equal);
}

TEST(Drainage, InParenchymaTheWireStays) {
    const SynthPatient& p = firstPatient();
    ASSERT_FALSE(p.paths.empty());
    const Played played = play(p, p.paths.front(), shortOfTheDuct(0.015));
    EXPECT_LT(played.wire_m, training::SafetyWatch::kBlindWire_m);
    EXPECT_EQ(played.in_duct_m, 0.0);
    EXPECT_GT(played.wire_n, 1.5);
    EXPECT_TRUE(played.buckled);
    EXPECT_NE(played.last.drain, DrainState::in_place);
    EXPECT_TRUE(played.equal);
    EXPECT_TRUE(played.refused(training::Refusal::noBile));
    EXPECT_TRUE(played.refused(training::Refusal::wireNotInDuct));
    for (const auto step : {training::Step::aspirate, training::Step::wire, training::Step::dilate,
                            training::Step::drain, training::Step::finalPicture})
        EXPECT_FALSE(played.done(step)) << stepName(step);
    EXPECT_FALSE(training::passesExam(played.progress));
}

// The drain's tip ends this much deeper than the expert's, relative to the wire's way.
Scenario withDrainDeeper(double by_m) {
    Scenario scenario = drainage();
    const auto drain = std::ranges::find_if(scenario.stages, [](const Stage& s) {
        return s.kind == StageKind::changeTool && s.tool == Tool::drain;
    });
    (drain + 1)->to.deeper_m += by_m;
    return scenario;
}

Stage takeTool(Tool tool) {
    return {.kind = StageKind::changeTool, .seconds = 0.5, .tool = tool};
}
// From the script's last place, the drain's wire outside the body.
Stage moveTo(double deeper_m) {
    return {.kind = StageKind::move, .to = {.deeper_m = deeper_m}, .speed_m_s = 0.040};
}

// The stage after the wire was drawn out of the drain.
auto afterTheWire(Scenario& scenario) {
    const auto wire = std::find_if(scenario.stages.rbegin(), scenario.stages.rend(), [](const Stage& s) {
        return s.kind == StageKind::changeTool && s.tool == Tool::wire;
    });
    return wire.base() + 1;
}

// Passes the wire through the drain again, moves the drain, and draws the wire out.
std::vector<Stage> mend(double drain_m) {
    return {takeTool(Tool::wire),     moveTo(-0.050),       takeTool(Tool::drain),
            moveTo(-0.050 + drain_m), takeTool(Tool::wire), moveTo(-0.250)};
}

// The drain's tip lies in the duct, and its side holes do not.
struct LeakingDrain {
    double deeper_m;  // than the expert's
    Played played;
};
const LeakingDrain& leakingDrain() {
    static const LeakingDrain found = [] {
        const SynthPatient& p = firstPatient();
        double by_m = -0.045;
        const auto leaks = [&] {
            const SessionLog log = test::playScripted(p.patient, p.touch, p.path, withDrainDeeper(by_m), 1);
            return refused(log.events, training::Refusal::drainLeaks);
        };
        while (by_m > -0.060 && !leaks())
            by_m -= 0.005;
        return LeakingDrain{by_m, play(p, p.path, withDrainDeeper(by_m))};
    }();
    return found;
}

// The expert's drain is pushed 55 mm further than the path is long, that is to the wire's end. HZ-TEACH-25
TEST(Drainage, OnlyADrainWithAllItsHolesInTheDuctDrains) {
    const SynthPatient& p = firstPatient();
    const Played& leaks = leakingDrain().played;
    EXPECT_EQ(leaks.last.drain, DrainState::in_place) << "its tip lies in the duct";
    EXPECT_GT(leaks.last.holes_in_duct, 0.0);
    EXPECT_LT(leaks.last.holes_in_duct, 1.0);
    EXPECT_TRUE(leaks.refused(training::Refusal::drainLeaks));
    const Played short_of = play(p, p.path, withDrainDeeper(-0.070));
    EXPECT_EQ(short_of.last.drain, DrainState::misplaced);
    EXPECT_TRUE(short_of.refused(training::Refusal::drainMisplaced));
    for (const Played* played : std::initializer_list<const Played*>{&leaks, &short_of}) {
        EXPECT_FALSE(played->done(training::Step::drain));
        EXPECT_FALSE(training::passesExam(played->progress));
        EXPECT_TRUE(played->equal);
    }
}

// HZ-TEACH-25
TEST(Drainage, ALeakingDrainIsMendedOverTheWire) {
    const SynthPatient& p = firstPatient();
    const Played& expert = expertsDrainage();
    ASSERT_TRUE(expert.done(training::Step::drain));
    const double leaking_m = leakingDrain().deeper_m;
    Scenario leaks = withDrainDeeper(leaking_m);
    const std::vector<Stage> mending = mend(-leaking_m);
    leaks.stages.insert(afterTheWire(leaks), mending.begin(), mending.end());
    const Played mended = play(p, p.path, leaks);
    EXPECT_TRUE(mended.refused(training::Refusal::drainLeaks));
    EXPECT_EQ(mended.last.drain, DrainState::in_place);
    EXPECT_EQ(mended.progress.steps_done, expert.progress.steps_done);
    EXPECT_EQ(mended.progress.out_of_order, 0u);
    EXPECT_EQ(mended.progress.critical_errors, 0u) << "the wire needs no new proof";
    EXPECT_TRUE(training::passesExam(expert.progress));
    EXPECT_TRUE(training::passesExam(mended.progress));
    EXPECT_EQ(mended.torn_mm, 0.0);
    EXPECT_LT(mended.progress.total, expert.progress.total) << "it took time";
    EXPECT_TRUE(mended.equal);
}

// A drain that drained, and was drawn out over the wire, drains no longer. A picture of a drain that was
// moved afterwards is no final picture. HZ-TEACH-25
TEST(Drainage, AMovedDrainCountsOnlyWhereItLiesAtTheEnd) {
    const SynthPatient& p = firstPatient();
    Scenario drawn_out = drainage();
    for (const Stage& stage : {takeTool(Tool::wire), moveTo(-0.050), takeTool(Tool::drain), moveTo(-0.250)})
        drawn_out.stages.push_back(stage);
    const Played without = play(p, p.path, drawn_out);
    EXPECT_EQ(without.last.drain, DrainState::none);
    EXPECT_FALSE(without.done(training::Step::drain) || without.done(training::Step::finalPicture));
    EXPECT_FALSE(training::passesExam(without.progress));

    const double leaking_m = leakingDrain().deeper_m;
    Scenario pictured = withDrainDeeper(leaking_m);
    for (const Stage& stage : mend(-leaking_m))
        pictured.stages.push_back(stage);
    const Played moved = play(p, p.path, pictured);
    EXPECT_TRUE(moved.done(training::Step::drain));
    EXPECT_FALSE(moved.done(training::Step::finalPicture));
    EXPECT_FALSE(training::passesExam(moved.progress));
    EXPECT_TRUE(without.equal && moved.equal);
}

// Passing the wire again and again earns nothing. HZ-TEACH-25
TEST(Drainage, MendingRepeatedlyEarnsNothing) {
    const SynthPatient& p = firstPatient();
    Scenario often = drainage();
    for (int i = 0; i < 3; ++i) {
        const std::vector<Stage> mending = mend(0.0);
        often.stages.insert(afterTheWire(often), mending.begin(), mending.end());
    }
    const Played &expert = expertsDrainage(), again = play(p, p.path, often);
    EXPECT_EQ(again.progress.steps_done, expert.progress.steps_done);
    EXPECT_LT(again.progress.total, expert.progress.total);
    EXPECT_EQ(again.torn_mm, 0.0);
    EXPECT_TRUE(again.equal);
}

// HZ-TEACH-25
TEST(Drainage, ADrainForcedWithoutADilatorTearsTheTrackAndHurts) {
    Scenario scenario = drainage();
    const auto takes = [](Tool tool) {
        return [tool](const Stage& s) { return s.kind == StageKind::changeTool && s.tool == tool; };
    };
    const auto dilator = std::ranges::find_if(scenario.stages, takes(Tool::dilator));
    const auto drain = std::find_if(dilator, scenario.stages.end(), takes(Tool::drain));
    scenario.stages.erase(dilator, drain - 1);  // the drain begins where it would have begun
    std::erase_if(scenario.stages, [](const Stage& s) { return s.kind == StageKind::numb; });
    const std::vector<Stage> mending = mend(0.0);
    scenario.stages.insert(afterTheWire(scenario), mending.begin(), mending.end());
    const SynthPatient& p = firstPatient();
    const patient::PlannedPath& path = p.path;
    const Played played = play(p, path, scenario);
    EXPECT_GT(played.torn_mm, 1e3 * path.length_m - 10.0) << "all of the track";
    EXPECT_LT(played.torn_mm, 1e3 * path.length_m + 10.0) << "once, although the drain was moved again";
    EXPECT_EQ(played.progress.worst_pain, training::kTearPain);
    EXPECT_TRUE(played.refused(training::Refusal::trackTorn));
    EXPECT_FALSE(played.done(training::Step::dilate));
    EXPECT_TRUE(played.equal);
}

TEST(Drainage, WithoutAWireTheAccessIsLost) {
    Scenario scenario = drainage();
    std::erase_if(scenario.stages,
                  [](const Stage& s) { return s.kind == StageKind::changeTool && s.tool == Tool::wire; });
    const SynthPatient& p = firstPatient();
    const Played played = play(p, p.paths.front(), scenario);
    EXPECT_FALSE(played.last.open);
    EXPECT_EQ(played.dilated_m, 0.0);
    EXPECT_EQ(played.last.drain, DrainState::none);
    EXPECT_FALSE(played.done(training::Step::wire) || played.done(training::Step::drain));
    EXPECT_FALSE(training::passesExam(played.progress)) << "a puncture is not a drainage";
}

TEST(Drainage, BruteForceBucklesOrPierces) {
    Scenario scenario = drainage();
    for (Stage& stage : scenario.stages)
        if (stage.kind == StageKind::move) stage.speed_m_s = 0.4;
    const SynthPatient& p = firstPatient();
    const Played played = play(p, p.paths.front(), shortOfTheDuct(0.010));
    EXPECT_TRUE(played.buckled || played.pierced);
    EXPECT_LE(played.wire_n, 10.0);
    EXPECT_TRUE(play(p, p.paths.front(), scenario).equal);
}

}  // namespace
}  // namespace stylet::trainer
