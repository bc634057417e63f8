#include "app/trainer/loop/loops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "app/records/replay.h"
#include "app/trainer/stores/platform_linux.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/app/trainer/scripted_display.h"
#include "tests/support/temp_folder.h"
#include "tests/support/virtual_clock.h"

namespace stylet::trainer {
namespace {

using patient::Tissue;
using test::ductPath;
using test::ductPhantom;
using test::playFast;
using test::shortScenario;

const haptics::NeedleEvent* firstInto(const SessionLog& log, Tissue tissue) {
    for (const haptics::EventRecord& record : log.punctures)
        if (record.event.border.to == tissue) return &record.event;
    return nullptr;
}

TEST(FastLoop, HitsTheDuctWithTheClosedFormsOfTheModel) {
    const patient::Package package = ductPhantom();
    const test::Played played = playFast(package, shortScenario(), 1);
    EXPECT_TRUE(played.log.target_hit());
    EXPECT_EQ(played.log.faults, 0u);
    const haptics::NeedleEvent* duct = firstInto(played.log, Tissue::duct);
    ASSERT_NE(duct, nullptr);
    EXPECT_EQ(duct->kind, haptics::NeedleEventKind::puncture);
    EXPECT_NEAR(duct->force_before_n, 1.2, 1e-9);
    EXPECT_NEAR(duct->force_after_n, 0.5, 1e-9);
    EXPECT_NEAR(duct->tenting_m, 0.0003, 1e-4);
    const haptics::NeedleEvent* fascia = firstInto(played.log, Tissue::fascia);
    ASSERT_NE(fascia, nullptr);
    EXPECT_NEAR(fascia->force_before_n, 2.5, 1e-9);
    EXPECT_NEAR(fascia->border.depth_m, 0.020, 1e-4);
}

TEST(FastLoop, FindsEveryCaptureOnceAndInOrder) {
    const test::Played played = playFast(ductPhantom(), shortScenario(), 1);
    std::vector<std::string> names;
    std::uint64_t last = 0;
    for (const Capture& m : played.log.captures) {
        names.push_back(m.name);
        EXPECT_GE(m.state.tick.tick, last);
        last = m.state.tick.tick;
    }
    EXPECT_THAT(names, testing::ElementsAre("approach", "skin", "fascia", "liver", "duct"));
    // Each capture contains the state of its own tick: "approach" at the scenario's distance from the skin,
    // "duct" at the duct's wall.
    EXPECT_NEAR(played.log.captures[0].state.tick.patient_from_needle.position_m.x, -0.005, 1e-3);
    EXPECT_NEAR(played.log.captures[4].state.tick.patient_from_needle.position_m.x, 0.0503, 2e-4);
    EXPECT_TRUE(played.log.captures[4].state.tick.breath_held);
}

// HZ-TEACH-14
TEST(FastLoop, EndsInTheSameHashEveryTime) {
    const patient::Package package = ductPhantom();
    const std::uint64_t first = playFast(package, shortScenario(), 7).log.state_hash;
    EXPECT_EQ(playFast(package, shortScenario(), 7).log.state_hash, first);
}

TEST(FastLoop, SeedTableAndScenarioEachChangeTheHash) {
    const patient::Package package = ductPhantom();
    const std::uint64_t first = playFast(package, shortScenario(), 7).log.state_hash;
    EXPECT_NE(playFast(package, shortScenario(), 8).log.state_hash, first);

    patient::Package other_table = package;
    double& friction = other_table.tissues[std::size_t(Tissue::vessel)].friction_n;
    friction = std::bit_cast<double>(std::bit_cast<std::uint64_t>(friction) ^ 1u);
    EXPECT_NE(playFast(other_table, shortScenario(), 7).log.state_hash, first);

    Scenario other_scenario = shortScenario();
    other_scenario.approach_distance_m += 0.001;  // has no effect on the motion
    EXPECT_NE(playFast(package, other_scenario, 7).log.state_hash, first);
}

// Number of threads that use the clock of runRealTime(): haptics, session and frames.
constexpr std::size_t kLoopThreads = 3;

class RecordedLoop : public testing::Test {
  protected:
    // Plays at most the first `longest_ns` of the scenario's script.
    void play(const haptics::Clock& clock, std::int64_t longest_ns = 3'600'000'000'000) {
        const Scenario scenario = shortScenario();
        Attempt attempt = makeAttempt(patient_, scenario, ductPath(), 3);
        std::erase_if(attempt.hand.samples, [&](const auto& sample) { return sample.t_ns > longest_ns; });
        std::erase_if(attempt.hand.commands, [&](const auto& command) { return command.t_ns > longest_ns; });
        records::RecordInfo info;
        info.path = ductPath();
        records::RecordWriter writer(folder_ / "record", {patient::digest(package_), attempt.simulation},
                                     info);
        Session session(patient_, ductPath(), scenario.moments, scenario.approach_distance_m, &writer);
        totals_ = runRealTime(attempt, session, nullptr, clock);
        writer.finish();
        log_ = session.log();
    }

    test::TempFolder folder_;
    patient::Package package_ = ductPhantom();
    patient::Patient patient_{package_};
    LoopTotals totals_;
    SessionLog log_;
};

// Returns true if memory can be locked. Always false with a sanitizer, which uses its own shadow memory.
bool canLockPages() {
#ifdef STYLET_SANITIZED
    return false;
#else
    return mlockall(MCL_CURRENT) == 0 && munlockall() == 0;
#endif
}

// HZ-TEACH-13
TEST_F(RecordedLoop, ReplaysToItsHashUntilOneBitOfItsInputsChanges) {
    test::VirtualClock clock(kLoopThreads);
    play(clock.clock());
    EXPECT_TRUE(log_.target_hit());
    EXPECT_EQ(log_.faults, 0u);
    EXPECT_EQ(totals_.haptics.late_ticks, 0u);
    records::Record record = records::loadRecord(folder_ / "record");
    EXPECT_EQ(record.inputs.size(), log_.ticks);
    const records::ReplayResult same = records::replay(patient_, record, {});
    EXPECT_TRUE(same.equal());
    EXPECT_EQ(same.state_hash, log_.state_hash);

    double& x = record.inputs[record.inputs.size() / 2].device.device_from_stylus.position_m.x;
    x = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) ^ 1u);
    const records::ReplayResult other = records::replay(patient_, record, {});
    EXPECT_FALSE(other.equal());
    EXPECT_NE(other.state_hash, log_.state_hash);
    ASSERT_TRUE(other.first_mismatch);
    // The difference is found in the frame that contains the changed tick.
    EXPECT_EQ(other.first_mismatch->ticks / records::kFrameTicks,
              record.inputs.size() / 2 / records::kFrameTicks + 1);
}

// Runs this test program again, in a new process, with one test only. Returns true if it passes.
bool passesInNewProcess(const std::string& test) {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command = "STYLET_REPEATED_TEST=1 '" + program + "' --gtest_filter=" + test + " >&2";
    return std::system(command.c_str()) == 0;
}

// Needs real time: with the machine's own scheduler, the loop's thread must not cause page faults after its
// warm-up.
class RecordedLoopRealTime : public RecordedLoop {};

TEST_F(RecordedLoopRealTime, WarmLoopHasNoPageFaults) {
    play(monotonicClock(), 3'000'000'000);
    EXPECT_GT(log_.ticks, 500u + 400u) << "half a second is the warm-up";
    EXPECT_GE(totals_.elapsed_s, 0.001 * double(log_.ticks - 1)) << "never faster than its rate";
    if (canLockPages()) {
        // A page that the loop touches for the first time after its warm-up is a fault in every process. The
        // kernel can also move a locked page at any time, but hardly in four processes.
        bool without_faults = totals_.haptics.page_faults == 0;
        for (int process = 0; process < 3 && std::getenv("STYLET_REPEATED_TEST") == nullptr; ++process)
            without_faults =
                without_faults || passesInNewProcess("RecordedLoopRealTime.WarmLoopHasNoPageFaults");
        EXPECT_TRUE(without_faults) << totals_.haptics.page_faults << " page faults";
        RecordProperty("page_faults", std::to_string(totals_.haptics.page_faults));
    }
    EXPECT_TRUE(records::replay(patient_, records::loadRecord(folder_ / "record"), {}).equal());
    RecordProperty("late_ticks", std::to_string(totals_.haptics.late_ticks));
}

// More commands than the ring and a tick can contain, then one more at the very end.
Attempt commandedAttempt(const patient::Patient& patient) {
    Attempt attempt = makeAttempt(patient, shortScenario(), ductPath(), 3);
    const std::int64_t end_ns = attempt.hand.samples.back().t_ns;
    attempt.hand.commands.clear();
    for (std::uint32_t i = 0; i < 200; ++i)
        attempt.hand.commands.push_back({end_ns - 1'000'000, {haptics::CommandKind::marker, i}});
    attempt.hand.commands.push_back({end_ns + 1'000'000, {haptics::CommandKind::breathe, 200}});
    return attempt;
}

template <typename Play>
std::vector<std::uint32_t> commandsRecorded(Play play) {
    const test::TempFolder folder;
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const Attempt attempt = commandedAttempt(patient);
    records::RecordWriter writer(folder / "record", {patient::digest(package), attempt.simulation}, {});
    Session session(patient, ductPath(), {}, 0.0, &writer);
    play(attempt, session);
    writer.finish();
    std::vector<std::uint32_t> values;
    for (const haptics::TickInput& input : records::loadRecord(folder / "record").inputs)
        for (std::uint32_t i = 0; i < input.command_count; ++i)
            values.push_back(input.commands[i].value);
    return values;
}

std::vector<std::uint32_t> everyCommand() {
    std::vector<std::uint32_t> values(201);
    std::iota(values.begin(), values.end(), 0u);
    return values;
}

TEST(FastLoop, SendsEveryCommandIncludingTheLast) {
    EXPECT_EQ(commandsRecorded([](const Attempt& attempt, Session& session) {
                  runFast(attempt, session, nullptr, 0.0, {});
              }),
              everyCommand());
}

TEST(RealTimeLoop, SendsEveryCommandIncludingTheLast) {
    EXPECT_EQ(commandsRecorded([](const Attempt& attempt, Session& session) {
                  test::VirtualClock clock(kLoopThreads);
                  runRealTime(attempt, session, nullptr, clock.clock());
              }),
              everyCommand());
}

TEST(RealTimeLoop, DisplayErrorEndsTheLoopAndIsRethrown) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const Attempt attempt = makeAttempt(patient, shortScenario(), ductPath(), 3);
    Session session(patient, ductPath(), {}, 0.0, nullptr);
    test::VirtualClock clock(kLoopThreads);
    // The frame advances the clock only after every thread has started. Otherwise the clock would wait
    // forever for a thread that is stopped before it starts.
    auto broken =
        std::make_unique<test::ScriptedDisplay>([&clock](const FrameState&, const std::string&) -> bool {
            clock.sleepUntil_ns(clock.now_ns() + 11'000'000);
            throw std::logic_error("not of the GPU");
        });
    EXPECT_THROW(runRealTime(attempt, session, std::move(broken), clock.clock()), std::logic_error);
    EXPECT_LT(session.log().last_tick, 500u) << "went on to the hand's end";
}

// The frame thread hangs in the runtime for 3.5 seconds. The attempt continues, and the frames after it
// learn why the picture stood still.
TEST(RealTimeLoop, AStalledPictureIsReportedAndTheAttemptContinues) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const Attempt attempt = makeAttempt(patient, shortScenario(), ductPath(), 3);
    Session session(patient, ductPath(), {}, 0.0, nullptr);
    test::VirtualClock clock(kLoopThreads);
    int frames = 0;
    auto hanging = std::make_unique<test::ScriptedDisplay>([&](const FrameState&, const std::string&) {
        clock.sleepUntil_ns(clock.now_ns() + (++frames == 20 ? 3'500'000'000 : 11'000'000));
        return true;
    });
    double stall_s = 0.0;
    testing::internal::CaptureStderr();
    const LoopTotals totals = runRealTime(
        attempt, session, std::move(hanging), clock.clock(),
        {.on_state = [&](const FrameState& s) { stall_s = std::max(stall_s, s.picture_stall_s); }});
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_EQ(totals.haptics.paused, 0u);
    EXPECT_FALSE(totals.input_only) << "a script";
    EXPECT_NEAR(stall_s, 3.5, 0.1);
    EXPECT_NE(said.find("the picture has stopped for 3 s; the attempt continues"), said.npos) << said;
    EXPECT_NE(said.find("the picture moves again"), said.npos) << said;
}

// The frame thread never returns from its 20th frame. The frames before it are counted.
TEST(RealTimeLoop, AHungRuntimeStillHasItsFrames) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const Attempt attempt = makeAttempt(patient, shortScenario(), ductPath(), 3);
    Session session(patient, ductPath(), {}, 0.0, nullptr);
    test::VirtualClock clock(kLoopThreads);
    static test::VirtualClock elsewhere(2);
    auto hung = std::make_unique<test::ScriptedDisplay>(
        [&clock, frames = 0](const FrameState&, const std::string&) mutable {
            if (++frames < 20) {
                clock.sleepUntil_ns(clock.now_ns() + 11'000'000);
                return true;
            }
            elsewhere.now_ns();  // the attempt's clock waits for this thread no longer
            while (true)
                std::this_thread::sleep_for(std::chrono::hours(1));
        });
    const LoopTotals totals =
        runRealTime(attempt, session, std::move(hung), clock.clock(), {.frame_patience_s = 0.1});
    EXPECT_TRUE(totals.frames_stuck);
    EXPECT_EQ(totals.pictures.frames, 19u);
}

// Simulates a runtime that starts a frame every 11 ms, and records what each frame shows.
struct WatchedFrame {
    std::uint64_t given = 0, tick = 0;
    bool through_skin = false, hole = false;
};
std::unique_ptr<Display> watching(test::VirtualClock& clock, std::vector<WatchedFrame>& frames,
                                  std::size_t& tips) {
    const auto live = std::make_shared<LiveUpdates>();
    auto display = std::make_unique<test::ScriptedDisplay>([live, &clock, &frames, &tips](
                                                               const FrameState& given,
                                                               const std::string& moment) {
        clock.sleepUntil_ns(clock.now_ns() + 11'000'000);
        FrameState seen = given;
        live->refresh(seen);
        for (haptics::TipSample tip; live->tips->pop(tip);)
            ++tips;
        const bool on_skin = seen.tick.phase == haptics::Phase::tenting && seen.tick.tissue == Tissue::air;
        // At the end, several frames show the last tick.
        const bool is_new = frames.empty() || seen.tick.tick != frames.back().tick;
        if (moment.empty() && is_new)
            frames.push_back({given.tick.tick, seen.tick.tick,
                              seen.tick.phase != haptics::Phase::outside && !on_skin, !seen.wounds.empty()});
        return true;
    });
    display->followed = [live](LiveUpdates from) { *live = std::move(from); };
    return display;
}

// Also checks the hole in the skin, which the session thread finds.
TEST(RealTimeLoop, ACutIsShownWithTheFirstFrameAfterIt) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const Attempt attempt = makeAttempt(patient, shortScenario(), ductPath(), 3);
    Session session(patient, ductPath(), {}, 0.0, nullptr);
    std::vector<WatchedFrame> frames;
    std::size_t tips = 0;
    test::VirtualClock clock(kLoopThreads);
    const LoopTotals totals = runRealTime(attempt, session, watching(clock, frames, tips), clock.clock());
    ASSERT_FALSE(session.log().punctures.empty());
    const std::uint64_t cut = session.log().punctures.front().tick;
    const auto first =
        std::find_if(frames.begin(), frames.end(), [&](const WatchedFrame& f) { return f.tick >= cut; });
    ASSERT_NE(first, frames.end());
    EXPECT_TRUE(first->through_skin);
    EXPECT_TRUE(first->hole);
    std::size_t newer = 0;
    for (const WatchedFrame& f : frames) {
        EXPECT_TRUE(f.hole || !f.through_skin) << "at tick " << f.tick;
        newer += f.tick > f.given + 5;
    }
    EXPECT_GT(newer, frames.size() / 2) << "frames show what there was before they waited";
    EXPECT_GT(double(tips), 0.9 * double(totals.haptics.ticks));
}

// Console commands: a new difficulty is visible immediately, and "new attempt" ends this attempt.
// HZ-TEACH-12
TEST(RealTimeLoop, ExecutesInstructorCommands) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const Attempt attempt = makeAttempt(patient, shortScenario(), ductPath(), 3);
    Session session(patient, ductPath(), {}, 0.0, nullptr);
    session.setDifficulty(training::Difficulty::guided);
    std::string words = "difficulty exam\n";
    bool exam = false;
    test::VirtualClock clock(kLoopThreads);
    const auto on_state = [&](const FrameState& seen) {
        exam = exam || seen.difficulty == training::Difficulty::exam;
        if (exam) words = "new seed 7\nnew attempt\n";
    };
    const auto console = [&] { return session.newest() ? std::exchange(words, {}) : std::string(); };
    const LoopTotals totals =
        runRealTime(attempt, session, nullptr, clock.clock(), {.on_state = on_state, .console = console});
    EXPECT_TRUE(exam);
    ASSERT_TRUE(totals.next);
    EXPECT_EQ(totals.next->seed, 7u);
    const std::vector<training::SessionEvent>& events = session.log().events;
    EXPECT_TRUE(std::any_of(events.begin(), events.end(), [](const training::SessionEvent& e) {
        return e.kind == "difficulty" && e.text == "exam";
    }));
}

TEST(LiveAttempt, ADeviceSlowerThanItsControllerAccountsForIsRefused) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    haptics::DeviceProfile profile;
    const auto make = [&](double delay_s, double rate_hz) {
        profile.delay_s = delay_s;
        (void)makeLiveAttempt(patient, shortScenario(), ductPath(), {}, {.rate_hz = rate_hz}, {},
                              {.profile = profile});
    };
    EXPECT_NO_THROW(make(0.0159, 1000.0));
    EXPECT_NO_THROW(make(0.0039, 4000.0));
    EXPECT_NO_THROW(make(haptics::kUnknown, 1000.0));
    EXPECT_THROW(make(0.0161, 1000.0), std::runtime_error);
    EXPECT_THROW(make(0.0041, 4000.0), std::runtime_error);
}

}  // namespace
}  // namespace stylet::trainer
