#include "haptics/devices/bridge/link.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/support/bridge_emulator.h"
#include "tests/support/constants.h"

namespace stylet::haptics::bridge {
namespace {

using test::BridgeEmulator;
using test::BridgeFault;
using test::BridgeScript;
using test::kTick_ns;

constexpr std::int64_t kStart_ns = 5'000'000'000;

// Link and emulator on a virtual clock. Behaves like the driver: sends zero force until the link reports
// that the bridge accepts forces, and closes the connection at the first fault.
struct Pair {
    explicit Pair(const BridgeScript& script) : emulator(script), random(script.seed) {
        talk(link.hello().span());
        EXPECT_TRUE(link.hasCapabilities());
    }

    void tick(const Vec3& asked_n) {
        now_ns += kTick_ns;
        fresh = false;
        if (link.fault() != LinkFault::none) return;
        talk(link.force(ready ? asked_n : Vec3(0.0), now_ns).span());
        link.checkTimeout(now_ns);
        State state;
        fresh = link.readState(state);
        if (fresh) {
            last = state;
            ready = state.motors == MotorStage::on && !state.watchdog;
        }
        if (link.fault() == LinkFault::none && !hung_up) return;
        closed_ns = now_ns;
        if (!hung_up) talk(link.force(Vec3(0.0), now_ns).span());
        ready = false;
    }

    void ticks(int count) {
        for (; count > 0; --count)
            tick({0.0, 0.0, 1.0});
    }

    void talk(std::span<const std::uint8_t> bytes) {
        std::vector<std::uint8_t> back;
        emulator.release(now_ns, back);
        hung_up = hung_up || !emulator.receive(bytes, now_ns, back);
        // Deliver in pieces, as a socket may.
        for (std::size_t at = 0; at < back.size();) {
            const std::size_t piece = std::min(back.size() - at, std::size_t(1 + random() % 97));
            link.receive({back.data() + at, piece}, now_ns);
            at += piece;
        }
    }

    double motor_n() {
        const auto f = emulator.motors_n(now_ns);
        return std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    }

    std::int64_t now_ns = kStart_ns, closed_ns = 0;
    Link link;
    BridgeEmulator emulator;
    std::minstd_rand random;
    State last;
    bool fresh = false, ready = false, hung_up = false;
};

TEST(BridgeLink, HealthyBridgeDeliversAFreshStateEveryTick) {
    Pair pair({});
    EXPECT_STREQ(pair.link.capabilities().name.data(), "emulated Touch");
    EXPECT_EQ(pair.link.capabilities().profile.force_peak_n, 3.3);
    for (int i = 0; i < 5000; ++i) {
        pair.tick({0.0, 0.0, 1.5});
        ASSERT_TRUE(pair.fresh) << i;
        if (i > 1) {
            ASSERT_EQ(pair.motor_n(), 1.5);
        }
    }
    EXPECT_EQ(pair.link.counts().states, 5000u);
    EXPECT_EQ(pair.link.counts().lost + pair.link.counts().repeated, 0u);
    EXPECT_EQ(pair.emulator.complaint(), "");
    EXPECT_EQ(pair.last.device_from_stylus.position_m, Vec3(0.0, 0.0, 0.1));
}

// HZ-FORCE-02
TEST(BridgeLink, ForceIsAppliedOnlyAfterAZeroCommand) {
    Pair pair({});
    pair.ready = true;  // a driver that does not wait for readiness
    for (int i = 0; i < 50; ++i) {
        pair.tick({0.0, 0.0, 1.5});
        pair.ready = true;
        ASSERT_EQ(pair.motor_n(), 0.0);
        ASSERT_TRUE(pair.last.watchdog);
    }
    pair.ready = false;
    pair.tick({0.0, 0.0, 1.5});
    pair.tick({0.0, 0.0, 1.5});
    EXPECT_EQ(pair.motor_n(), 1.5);
}

TEST(BridgeLink, ShortGapsAreCountedAndTolerated) {
    for (const BridgeFault fault : {BridgeFault::drop, BridgeFault::duplicate, BridgeFault::stall}) {
        Pair pair({.fault = fault, .from_answer = 20, .answers = 12, .stall_ns = 12 * kTick_ns});
        pair.ticks(100);
        EXPECT_EQ(pair.link.fault(), LinkFault::none) << describe(pair.link.fault());
        EXPECT_TRUE(pair.fresh);
        EXPECT_EQ(pair.link.counts().lost, fault == BridgeFault::drop ? 12u : 0u);
        EXPECT_EQ(pair.link.counts().repeated, fault == BridgeFault::duplicate ? 12u : 0u);
        EXPECT_EQ(pair.emulator.complaint(), "");
    }
}

TEST(BridgeLink, EachFaultIsIdentified) {
    const std::pair<BridgeFault, LinkFault> cases[] = {
        {BridgeFault::drop, LinkFault::silent},        {BridgeFault::stall, LinkFault::silent},
        {BridgeFault::notFinite, LinkFault::value},    {BridgeFault::farAway, LinkFault::value},
        {BridgeFault::notAUnit, LinkFault::value},     {BridgeFault::future, LinkFault::clock},
        {BridgeFault::past, LinkFault::clock},         {BridgeFault::frozen, LinkFault::frozen},
        {BridgeFault::tooLong, LinkFault::size},       {BridgeFault::version, LinkFault::version},
        {BridgeFault::unasked, LinkFault::unexpected},
    };
    for (const auto& [fault, name] : cases) {
        Pair pair({.fault = fault, .from_answer = 30, .answers = 1000, .stall_ns = 1'000 * kTick_ns});
        pair.ticks(100);
        EXPECT_EQ(pair.link.fault(), name) << describe(pair.link.fault()) << " instead of " << describe(name);
    }
}

TEST(BridgeLink, OwnPauseIsNotCountedAsBridgeSilence) {
    Pair pair({});
    pair.ticks(20);
    pair.now_ns += 500 * kTick_ns;  // thread not scheduled; the bridge released the force
    EXPECT_EQ(pair.motor_n(), 0.0);
    pair.tick({0.0, 0.0, 1.0});
    EXPECT_EQ(pair.motor_n(), 0.0);
    EXPECT_TRUE(pair.last.watchdog);
    pair.ticks(3);
    EXPECT_EQ(pair.link.fault(), LinkFault::none);
    EXPECT_EQ(pair.motor_n(), 1.0);
}

// HZ-FORCE-15
TEST(BridgeLink, OurClockGoingBackIsAFault) {
    Pair pair({});
    pair.ticks(20);
    pair.now_ns -= 5'000 * kTick_ns;
    pair.tick({0.0, 0.0, 1.0});
    EXPECT_EQ(pair.link.fault(), LinkFault::clock);
}

TEST(BridgeLink, SequenceNumbersWrap) {
    Link link;
    link.hello();
    Frame frame;
    EXPECT_EQ(readFrame(link.force({}, 0).span(), frame), LinkFault::none);
    EXPECT_EQ(frame.sequence, 2u);
    const auto reach = [&link](std::uint32_t sequence) {
        Capabilities capabilities;
        capabilities.profile.force_peak_n = 3.3;
        putText(capabilities.name, "x");
        const FrameBytes bytes = encode(sequence, capabilities);
        link.receive(bytes.span(), 0);
    };
    reach(0x7FFFFFFFu);
    ASSERT_TRUE(link.hasCapabilities());
    const auto answer = [&link](std::uint32_t sequence, std::int64_t now_ns) {
        State state;
        state.answers = 2;
        state.sampled_ns = now_ns;
        link.receive(encode(sequence, state).span(), now_ns);
    };
    answer(0xFFFFFFFEu, 1);
    answer(3, 2);  // five sequence numbers later
    EXPECT_EQ(link.fault(), LinkFault::none) << describe(link.fault());
    EXPECT_EQ(link.counts().states, 2u);
    answer(0xFFFFFFFFu, 3);
    EXPECT_EQ(link.counts().repeated, 1u);
}

// Injects every kind of fault at a random time, for a random duration. Every state must be finite. A fault
// must have a name and end in zero motor force within 20 ms of the last good answer.
// HZ-FORCE-21
TEST(BridgeLink, TwentyThousandFaultsEndInZeroForceWithin20Ms) {
    std::minstd_rand random(4);
    std::uint64_t faults = 0, survived = 0;
    for (std::uint32_t n = 0; n < 20'000; ++n) {
        BridgeScript script;
        script.fault = BridgeFault(1 + n % (test::kBridgeFaultCount - 1));
        script.from_answer = 5 + random() % 20;
        script.answers = 1 + random() % 40;
        script.stall_ns = std::int64_t(script.answers) * kTick_ns;
        script.seed = n;
        Pair pair(script);
        std::int64_t last_fresh_ns = 0, zero_ns = 0;
        for (int i = 0; i < 70; ++i) {
            pair.tick({0.0, 0.0, 1.0});
            const Pose& pose = pair.last.device_from_stylus;
            ASSERT_TRUE(std::isfinite(pose.position_m.x + pose.position_m.y + pose.position_m.z));
            if (pair.fresh) last_fresh_ns = pair.now_ns;
            if (pair.closed_ns != 0 && zero_ns == 0 && pair.motor_n() == 0.0) zero_ns = pair.now_ns;
        }
        if (pair.closed_ns == 0) {
            ++survived;
            EXPECT_LE(pair.now_ns - last_fresh_ns, kTick_ns) << int(script.fault);
            continue;
        }
        ++faults;
        // The link must notice in the first tick after 20 ms at the latest, and must report it to the
        // bridge in that tick.
        const std::int64_t began_ns = pair.emulator.fault_began_ns();
        ASSERT_LE(pair.closed_ns - began_ns, kSilenceTimeout_ns + kTick_ns) << int(script.fault);
        if (pair.link.fault() != LinkFault::none) {
            ASSERT_NE(describe(pair.link.fault()), "nothing wrong");
        }
        if (pair.hung_up) continue;  // a bridge that hung up controls its motors itself
        ASSERT_NE(zero_ns, 0) << int(script.fault);
        ASSERT_LE(zero_ns - pair.closed_ns, 0) << int(script.fault);
    }
    EXPECT_GT(faults, 14'000u);
    EXPECT_GT(survived, 1'500u);
}

}  // namespace
}  // namespace stylet::haptics::bridge
