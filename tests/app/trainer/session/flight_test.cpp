#include "app/trainer/session/flight.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "app/trainer/stores/platform_linux.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/app/trainer/scripted_display.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using test::ductPath;
using test::ductPhantom;
using test::shortScenario;

// The first seconds of the short attempt. The device jumps at each of `leaps_s`, which switches the force
// off. A button press at each of `presses_s` re-arms it.
Attempt leapingAttempt(const patient::Patient& patient, double seconds, const std::vector<double>& leaps_s,
                       const std::vector<double>& presses_s) {
    Attempt attempt = makeAttempt(patient, shortScenario(), ductPath(), 3);
    attempt.hand.samples.resize(std::size_t(seconds * 1000.0));
    for (const double t_s : leaps_s)
        attempt.hand.samples[std::size_t(t_s * 1000.0)].device_from_stylus.position_m.x += 0.1;
    for (const double t_s : presses_s)
        for (std::size_t i = 0; i < 100; ++i)
            attempt.hand.samples[std::size_t(t_s * 1000.0) + i].buttons = 1;
    return attempt;
}

SessionLog play(const patient::Patient& patient, const Attempt& attempt) {
    Session session(patient, ductPath(), {}, 0.0, nullptr);
    runFast(attempt, session, nullptr, 0.0, {});
    return session.log();
}

TEST(Flight, ButtonRearmsAndEveryFaultIsRecorded) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const SessionLog once = play(patient, leapingAttempt(patient, 4.0, {1.0, 3.0}, {}));
    EXPECT_EQ(once.faults, haptics::kFaultOverSpeed);
    EXPECT_EQ(once.flights.size(), 1u);  // the force is already off at the second jump
    const SessionLog twice = play(patient, leapingAttempt(patient, 4.0, {1.0, 3.0}, {2.0}));
    EXPECT_EQ(twice.flights.size(), 2u);
    const SessionLog never = play(patient, leapingAttempt(patient, 4.0, {}, {2.0}));
    EXPECT_EQ(never.faults, 0u);
    EXPECT_TRUE(never.flights.empty());
}

// One fault can cause the next: a lost device soon also gives stale input.
TEST(Flight, TimeZeroIsTheFirstFault) {
    std::vector<haptics::TickRecord> flight(10);
    for (std::size_t i = 0; i < flight.size(); ++i) {
        flight[i].output.tick = 100 + i;
        if (i >= 4) flight[i].output.faults |= haptics::kFaultDeviceLost;
        if (i >= 7) flight[i].output.faults |= haptics::kFaultStaleInput;
    }
    test::TempFolder folder;
    writeFlight(flight, 0.001, folder / "flight.csv");
    std::ifstream stream(folder / "flight.csv");
    std::string line;
    while (std::getline(stream, line) && line.find(",104,") == std::string::npos) {
    }
    EXPECT_EQ(line.substr(0, line.find(',')), "0");
}

TEST(Flight, FileListsEveryTickOfTheFault) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const SessionLog log = play(patient, leapingAttempt(patient, 3.0, {2.5}, {}));
    ASSERT_EQ(log.flights.size(), 1u);
    test::TempFolder folder;
    const std::filesystem::path csv = folder / "flight.csv";
    writeFlight(log.flights.front(), 0.001, csv);
    std::ifstream stream(csv);
    std::string line, fault_line;
    std::size_t lines = 0, commas = 0;
    while (std::getline(stream, line)) {
        const std::size_t here = std::size_t(std::count(line.begin(), line.end(), ','));
        if (lines++ == 0) commas = here;
        EXPECT_EQ(here, commas);
        if (line.starts_with("0,")) fault_line = line;
    }
    EXPECT_EQ(lines, 2101u);
    EXPECT_TRUE(fault_line.starts_with("0,2501,fading,")) << fault_line;
    EXPECT_NE(fault_line.find(",over-speed"), std::string::npos) << fault_line;
    EXPECT_TRUE(line.empty() || line.find(",off,0,over-speed") != std::string::npos) << line;
}

TEST(Flight, BitsHaveNames) {
    EXPECT_EQ(faultNames(0), "none");
    EXPECT_EQ(faultNames(haptics::kFaultBadPose | haptics::kFaultStaleInput), "stale-input+bad-pose");
}

// The headset is put on, taken off and put on again.
// HZ-FORCE-12
TEST(Focus, ForceFollowsFocusAndTheAttemptPauses) {
    const patient::Package package = ductPhantom();
    const patient::Patient patient(package);
    const Attempt attempt = leapingAttempt(patient, 2.5, {}, {});
    std::uint64_t shown_tick = 0, worn_since = 0, stood_at = 0;
    int frames_off = 0, stood_still = 0;
    const haptics::Clock clock = monotonicClock();
    auto headset = std::make_unique<test::ScriptedDisplay>([&](const FrameState& seen, const std::string&) {
        shown_tick = seen.tick.tick;
        if (worn_since == 0 && shown_tick > 300) worn_since = shown_tick;
        clock.sleepUntil_ns(clock.context, clock.now_ns(clock.context) + 5'000'000);
        return true;
    });
    headset->watch = [&] {
        if (worn_since == 0) return Attention::absent;
        if (shown_tick < worn_since + 600 || frames_off > 60) return Attention::focused;
        ++frames_off;
        stood_still += shown_tick == stood_at;
        stood_at = shown_tick;
        return Attention::away;
    };
    Session session(patient, ductPath(), {}, 0.0, nullptr);
    runRealTime(attempt, session, std::move(headset), clock);
    const SessionLog& log = session.log();
    EXPECT_EQ(log.faults & ~std::uint32_t(haptics::kFaultRingFull), haptics::kFaultNotFocused);
    ASSERT_EQ(log.flights.size(), 1u);
    for (const haptics::TickRecord& record : log.flights.front()) {
        if (record.output.tick >= 100 && record.output.tick <= 300) {
            EXPECT_EQ(record.output.stage, haptics::ForceStage::waiting);
            EXPECT_EQ(record.output.awaited, haptics::kFaultNotFocused);
        }
    }
    EXPECT_EQ(log.flights.front().back().output.stage, haptics::ForceStage::off);
    EXPECT_EQ(log.flights.front().back().output.sent_device_n, Vec3(0.0));
    // The headset is off for 60 frames of 5 ms. During the first of them the force still ramps down.
    EXPECT_GT(stood_still, 40);
    EXPECT_EQ(log.ticks, log.last_tick) << "no tick is missing from the record";
}

}  // namespace
}  // namespace stylet::trainer
