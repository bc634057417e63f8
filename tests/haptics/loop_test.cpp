#include "haptics/loop/loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <thread>
#include <utility>

#include "haptics/devices/replay.h"
#include "tests/haptics/scripted.h"

namespace stylet::haptics {
namespace {

// Time advances only when the test lets it pass.
struct MockClock {
    std::int64_t now = 1000000000;
    std::int64_t call_ns = 5000;  // time that each read of the clock takes
    std::uint64_t sleeps = 0, stop_after = 100, oversleep_at = 0;
    std::int64_t oversleep_ns = 0;
    LoopChannels* channels = nullptr;

    Clock clock() {
        return {this,
                [](void* c) noexcept {
                    MockClock& m = *static_cast<MockClock*>(c);
                    return m.now += m.call_ns;
                },
                [](void* c, std::int64_t t) noexcept {
                    MockClock& m = *static_cast<MockClock*>(c);
                    m.now = std::max(m.now, t);
                    if (++m.sleeps == m.oversleep_at) m.now += m.oversleep_ns;
                    if (m.sleeps == m.stop_after) m.channels->stop.store(true);
                }};
    }
};

// The scripted puncture, with everything that a loop needs.
struct LoopBench {
    void ticks(int count) {
        for (int i = 0; i < count; ++i)
            loopTick(simulation, scripted, channels, stats, std::int64_t(stats.ticks) * 1000000);
    }
    void run() { stats = runLoop(simulation, scripted, channels, mock.clock()); }

    patient::Package package = test::scriptedPackage();
    patient::Patient patient{package};
    Trace trace = test::scriptedTrace();
    Simulation simulation{patient, {}};
    ReplayDevice scripted{trace, 0};
    LoopChannels channels;
    LoopStats stats;
    MockClock mock{.channels = &channels};
};

TEST(Loop, TicksOnTimeAndTimesItsStep) {
    LoopBench b;
    b.run();
    EXPECT_EQ(b.stats.ticks, 100u);
    EXPECT_EQ(b.stats.late_ticks, 0u);
    EXPECT_EQ(b.stats.faults, 0u);
    // A step itself takes no time on the mock clock, but each read of that clock advances it by 5 us.
    EXPECT_NEAR(b.stats.max_step_us, 5.0, 1e-9);
    TickRecord record;
    for (std::uint64_t i = 1; i <= 100; ++i) {
        ASSERT_TRUE(b.channels.records.pop(record));
        EXPECT_EQ(record.output.tick, i);
        std::size_t cursor = 0;
        EXPECT_EQ(record.input.device.device_from_stylus.position_m,
                  sampleAt(b.trace, std::int64_t(i - 1) * 1000000, cursor).device_from_stylus.position_m);
    }
    TickOutput latest;
    EXPECT_TRUE(b.channels.latest.read(latest));
    EXPECT_EQ(latest.tick, 100u);
    EXPECT_EQ(latest.state_hash, record.output.state_hash);
}

// HZ-FORCE-18
TEST(Loop, LateTicksAreCountedButNotStretchedOrMadeUp) {
    std::uint64_t hash = 0;
    for (const std::int64_t oversleep_ns : {std::int64_t(0), std::int64_t(900000), std::int64_t(7300000)}) {
        LoopBench b;
        b.mock.oversleep_at = 40;
        b.mock.oversleep_ns = oversleep_ns;
        const std::int64_t began = b.mock.now;
        b.run();
        EXPECT_EQ(b.stats.ticks, 100u);
        EXPECT_EQ(b.stats.late_ticks, oversleep_ns > 1000000 ? 1u : 0u);
        // Seven periods are lost. The following ticks stay on the grid of the old deadlines.
        EXPECT_NEAR(double(b.mock.now - began), 100e6 + (oversleep_ns > 1000000 ? 7e6 : 0.0), 1e5);
        if (oversleep_ns == 0) hash = b.simulation.state().hash.value();
        EXPECT_EQ(b.simulation.state().hash.value(), hash);
    }
}

// Every tenth send() lasts `most_ns`. A tick that starts on time is still late if its force is sent after the
// next tick is due. The period is 1 ms, so a send of 0.9 ms is in time and a send of 1.1 ms is late.
TEST(Loop, LatenessIsMeasuredWhenTheForceIsSent) {
    class Slow final : public HapticDevice {
      public:
        Slow(MockClock& clock, std::int64_t most_ns) : clock_(clock), most_ns_(most_ns) {}
        const DeviceProfile& profile() const noexcept override { return profile_; }
        DeviceState read(std::int64_t) noexcept STYLET_NONBLOCKING override { return {}; }
        void send(const Vec3&) noexcept STYLET_NONBLOCKING override {
            if (++sent_ % 10 == 0) clock_.now += most_ns_;
        }

      private:
        MockClock& clock_;
        std::int64_t most_ns_;
        int sent_ = 0;
        DeviceProfile profile_;
    };
    for (const std::int64_t most_ns : {std::int64_t(900'000), std::int64_t(1'100'000)}) {
        LoopBench b;
        Slow device(b.mock, most_ns);
        const LoopStats stats = runLoop(b.simulation, device, b.channels, b.mock.clock());
        EXPECT_EQ(stats.ticks, 100u);
        EXPECT_EQ(stats.late_ticks, most_ns > 1'000'000 ? 10u : 0u);
    }
}

TEST(Loop, AtMostEightCommandsPerTickAreAppliedAndLogged) {
    LoopBench b;
    for (std::uint32_t i = 0; i < 10; ++i)
        ASSERT_TRUE(b.channels.commands.push({CommandKind::marker, i}));
    b.ticks(2);
    TickRecord first, second;
    ASSERT_TRUE(b.channels.records.pop(first) && b.channels.records.pop(second));
    EXPECT_EQ(first.input.command_count, 8u);
    EXPECT_EQ(second.input.command_count, 2u);
    EXPECT_EQ(second.input.commands[1].value, 9u);
}

TEST(Loop, FullRingIsALoopFaultAndDoesNotChangeTheState) {
    LoopBench b;
    b.ticks(4096);
    EXPECT_EQ(b.stats.faults, 0u);
    b.ticks(1);
    EXPECT_EQ(b.stats.faults, kFaultRingFull);
    EXPECT_EQ(b.channels.records.dropped(), 1u);
    EXPECT_EQ(b.simulation.state().output.safety.faults, 0u);
    TickOutput latest;
    b.channels.latest.read(latest);
    EXPECT_EQ(latest.faults, kFaultRingFull);
}

// A slow session must not affect the user: the force sent stays bit-identical.
// HZ-FORCE-18
TEST(Loop, FullRingDoesNotRemoveTheForce) {
    LoopBench drained, full;
    TickRecord record;
    TickOutput sent, expected;
    double most_n = 0.0;
    for (int i = 0; i < test::kScriptedTicks; ++i) {
        drained.ticks(1), full.ticks(1);
        ASSERT_TRUE(drained.channels.records.pop(record));
        ASSERT_TRUE(drained.channels.latest.read(expected) && full.channels.latest.read(sent));
        ASSERT_EQ(sent.sent_device_n, expected.sent_device_n) << i;
        ASSERT_EQ(sent.state_hash, expected.state_hash) << i;
        if (full.stats.faults != 0) most_n = std::max(most_n, glm::length(sent.sent_device_n));
    }
    EXPECT_EQ(drained.stats.faults, 0u);
    EXPECT_EQ(full.stats.faults, kFaultRingFull);
    EXPECT_GT(most_n, 0.2);
}

// HZ-TEACH-13
TEST(Loop, AReplayOfItsRecordsEndsInItsHash) {
    LoopBench b;
    LoopChannels& channels = b.channels;
    std::vector<TickRecord> records;
    std::atomic<std::uint64_t> taken{0};
    std::thread loop([&] {
        for (int i = 0; i < test::kScriptedTicks; ++i) {
            while (std::uint64_t(i) > taken.load() + 4000)
                std::this_thread::yield();
            b.ticks(1);
        }
        channels.stop.store(true);
    });
    int events = 0, commands = 0;
    const auto drain = [&] {
        TickRecord record;
        while (channels.records.pop(record))
            records.push_back(record);
        EventRecord event;
        while (channels.events.pop(event))
            ++events;
        taken.store(records.size());
    };
    while (!channels.stop.load()) {
        if (commands < 2)
            commands +=
                channels.commands.push({commands == 0 ? CommandKind::holdBreath : CommandKind::breathe, 0});
        drain();
        std::this_thread::yield();
    }
    loop.join();
    drain();
    EXPECT_GE(events, 3);

    EXPECT_EQ(b.stats.faults, 0u);
    Simulation replay(b.patient, {});
    TickOutput out;
    NeedleEvents again;
    for (const TickRecord& r : records) {
        replay.step(r.input, out, again);
        ASSERT_EQ(out.state_hash, r.output.state_hash) << "tick " << out.tick;
    }
    EXPECT_EQ(out.state_hash, b.simulation.state().hash.value());
}

TEST(Loop, PublishesTipPosesWithTimes) {
    LoopBench b;
    const std::int64_t began = b.mock.now;
    b.run();
    TipSample tip;
    TickRecord record;
    for (std::uint64_t i = 1; i <= 100; ++i) {
        ASSERT_TRUE(b.channels.tips.pop(tip) && b.channels.records.pop(record));
        EXPECT_EQ(tip.tick, i);
        EXPECT_EQ(tip.tool, Tool::needle);
        EXPECT_TRUE(tip.fresh);
        EXPECT_NEAR(double(tip.t_ns - began), double(i - 1) * 1e6, 2e4);
        EXPECT_EQ(tip.patient_from_tip.position_m, record.output.patient_from_needle.position_m);
    }
    EXPECT_FALSE(b.channels.tips.pop(tip));
}

TEST(Loop, AFullRingOfTipsIsNoFault) {
    LoopBench b;
    TickRecord record;
    for (int i = 0; i < 5000; ++i) {
        b.ticks(1);
        b.channels.records.pop(record);
    }
    EXPECT_GT(b.channels.tips.dropped(), 0u);
    EXPECT_EQ(b.stats.faults, 0u);
}

// A device at a position that the test sets, with fresh readings as often as the test wants.
class FixedPoseDevice final : public HapticDevice {
  public:
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceState read(std::int64_t) noexcept STYLET_NONBLOCKING override {
        DeviceState state{.device_from_stylus = {test::kAlongX, {x_m, 0.0, 0.0}}};
        state.fresh = std::exchange(fresh, fresh_always ? 1u : 0u);
        return state;
    }
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override {
        ++sent;
        sent_n = force_n;
    }
    double x_m = -0.006;
    std::uint32_t fresh = 1;
    bool fresh_always = true;
    int sent = 0;
    Vec3 sent_n{1.0};

  private:
    DeviceProfile profile_;
};

struct PauseBench : LoopBench {
    FixedPoseDevice device;
    std::vector<TickRecord> records;

    // Runs periods like runLoop(), moving at `m_s` along the needle.
    void periods(int count, double m_s = 0.0) {
        for (int i = 0; i < count; ++i) {
            device.x_m += m_s * 0.001;
            const std::int64_t t_ns = std::int64_t(stats.ticks) * 1000000;
            if (!loopPausedPeriod(simulation, device, channels, stats, t_ns))
                loopTick(simulation, device, channels, stats, t_ns);
            TickRecord record;
            while (channels.records.pop(record))
                records.push_back(record);
        }
    }
    void command(CommandKind kind, std::uint32_t value = 0) { channels.commands.push({kind, value}); }
    const TickOutput& last() const { return records.back().output; }
    std::uint64_t replayedHash() const {
        Simulation replay(patient, {});
        TickOutput out;
        NeedleEvents events;
        for (const TickRecord& record : records)
            replay.step(record.input, out, events);
        return out.state_hash;
    }
};

// HZ-FORCE-23
TEST(LoopPause, BeginsAtZeroForceAndSendsZeroEveryPeriod) {
    PauseBench p;
    p.periods(1700);
    p.periods(400, 0.02);
    ASSERT_EQ(p.last().stage, ForceStage::on);
    ASSERT_GT(glm::length(p.last().sent_device_n), 0.01);
    p.channels.pause.store(true);
    p.periods(5);
    EXPECT_EQ(p.records.size(), 2105u);  // force is still active, so ticks continue
    EXPECT_FALSE(p.channels.paused.load());
    p.command(CommandKind::focus, 0);
    p.periods(30);
    EXPECT_TRUE(p.channels.paused.load());
    EXPECT_EQ(p.last().stage, ForceStage::off);
    const std::size_t ticks = p.records.size();
    const double breath_v = p.last().breath.v;
    EXPECT_LE(ticks, 2105u + 20u);
    const int sent = p.device.sent;
    p.device.sent_n = Vec3(1.0);
    p.periods(500);
    EXPECT_EQ(p.records.size(), ticks);
    EXPECT_EQ(p.device.sent, sent + 500);
    EXPECT_EQ(p.device.sent_n, Vec3(0.0));
    p.channels.pause.store(false);
    p.periods(1);
    EXPECT_FALSE(p.channels.paused.load());
    ASSERT_EQ(p.records.size(), ticks + 1);
    // Tick count and breathing continue from the values they had when the loop paused.
    EXPECT_EQ(p.last().tick, ticks + 1);
    EXPECT_NEAR(p.last().breath.v, breath_v, 0.005);
    EXPECT_EQ(p.replayedHash(), p.simulation.state().hash.value());
}

// The stylus moves through skin and fascia while the loop is paused. This motion must puncture nothing, and
// it must not keep the force off after the pause. Tested with two devices: one has a fresh reading at every
// poll, the other has fresh readings less often.
// HZ-FORCE-23
TEST(LoopPause, MotionDuringThePauseNeitherCutsNorBlocks) {
    for (const bool fresh_always : {true, false}) {
        PauseBench p;
        p.periods(1700);
        p.channels.pause.store(true);
        p.command(CommandKind::focus, 0);
        p.periods(40);
        ASSERT_TRUE(p.channels.paused.load());
        p.device.fresh_always = fresh_always;
        p.device.x_m = 0.020;  // through skin and fascia
        p.device.fresh = 1;
        p.periods(10);
        p.channels.pause.store(false);
        p.periods(3);
        // The needle appears at its new position without a puncture, as if the user had picked it up there.
        EXPECT_EQ(p.last().phase, Phase::outside);
        EventRecord event;
        EXPECT_FALSE(p.channels.events.pop(event));
        p.device.fresh_always = true;
        p.device.fresh = 1;
        p.device.x_m = -0.006;
        p.command(CommandKind::focus, 1);
        p.periods(30);
        p.command(CommandKind::rearm);
        p.periods(1600);
        EXPECT_EQ(p.last().stage, ForceStage::on);
        EXPECT_EQ(p.last().faults, 0u);
        p.periods(900, 0.02);
        EXPECT_TRUE(p.channels.events.pop(event));
        EXPECT_EQ(p.replayedHash(), p.simulation.state().hash.value());
    }
}

// HZ-FORCE-23
TEST(LoopPause, NeedleInTheBodyStaysUntilTheHandReturns) {
    PauseBench p;
    p.periods(1700);
    p.periods(900, 0.02);
    ASSERT_NE(p.last().phase, Phase::outside);
    EventRecord event;
    while (p.channels.events.pop(event)) {
    }
    const double x_m = p.device.x_m;
    p.channels.pause.store(true);
    p.command(CommandKind::focus, 0);
    p.periods(40);
    ASSERT_TRUE(p.channels.paused.load());
    const std::size_t ticks = p.records.size();
    p.device.x_m = x_m + 0.015;
    p.channels.pause.store(false);
    p.periods(200);
    EXPECT_EQ(p.records.size(), ticks);
    EXPECT_TRUE(p.channels.paused.load());
    EXPECT_NEAR(p.channels.return_distance_m.load(), 0.015, 1e-9);
    p.device.x_m = x_m + 0.001;
    p.periods(50);
    EXPECT_EQ(p.records.size(), ticks + 50);
    EXPECT_EQ(p.channels.return_distance_m.load(), 0.0);
    EXPECT_NE(p.last().phase, Phase::outside);
    EXPECT_FALSE(p.channels.events.pop(event));
    EXPECT_EQ(p.replayedHash(), p.simulation.state().hash.value());
}

}  // namespace
}  // namespace stylet::haptics
