// The hand gets no more energy out of the springs than it has put in.
#include "haptics/output/stored_energy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/haptics/random_column.h"
#include "tests/haptics/simulation_bench.h"

namespace stylet::haptics {
namespace {

using enum Tissue;
using test::below;
using test::Random;
using test::uniform;

ToolForce spring(double k_n_per_m, double e_m, bool event = false) {
    return {.force_n = {-k_n_per_m * e_m, 0.0, 0.0}, .energy_j = 0.5 * k_n_per_m * e_m * e_m, .event = event};
}

// The closed form at the skin: 0.255 mJ of tenting, 0.306 mJ behind the cut.
TEST(StoredEnergy, SkinReturnsWhatItsTentingCost) {
    const double t = 0.7, k = 800.0, d = t / k,
                 tenting_j = k * k / 2.0 / t / 3.0 * d * d * d + k / 4.0 * d * d;
    EXPECT_NEAR(tenting_j, 0.255e-3, 1e-6);
    StoredEnergy s;
    s.springs_j = s.by_hand_j = tenting_j;
    s.force_n.x = -t;
    ToolForce felt = boundByStoredEnergy(s, spring(k, d, true), Vec3(0.0));
    EXPECT_NEAR(felt.energy_j, tenting_j, 1e-15);
    EXPECT_NEAR(felt.force_n.x, -t * std::sqrt(5.0 / 6.0), 1e-9);

    // Drawn back at once, the spring returns just that.
    double returned_j = 0.0, last_n = felt.force_n.x;
    const int steps = 1000;
    for (int i = 1; i <= steps; ++i) {
        felt = boundByStoredEnergy(s, spring(k, d * (1.0 - double(i) / steps)), {-d / steps, 0.0, 0.0});
        returned_j += 0.5 * (last_n + felt.force_n.x) * -d / steps;
        last_n = felt.force_n.x;
    }
    EXPECT_NEAR(returned_j, tenting_j, 1e-9);
}

TEST(StoredEnergy, FrictionRestoresTheWholeForce) {
    StoredEnergy s;
    s.springs_j = 0.306e-3, s.by_hand_j = 0.255e-3;
    s.force_n.x = -0.7;
    double advanced_m = 0.0;
    while (s.share() < 1.0 && advanced_m < 0.001) {
        boundByStoredEnergy(s, spring(800.0, 0.000875), {1e-6, 0.0, 0.0});
        advanced_m += 1e-6;
    }
    EXPECT_LT(advanced_m, 0.0001);
}

// The hand has put nothing into the springs. It still feels the needle again: at once beyond the place where
// the springs are relaxed, and when it works against friction.
TEST(StoredEnergy, ForceReturnsToASpringThatTheHandHasNotStretched) {
    constexpr double k = 1000.0, kStep_m = 1e-5;
    StoredEnergy s;
    boundByStoredEnergy(s, spring(k, 0.0003, true), Vec3(0.0));
    double e_m = 0.0003;
    while (e_m > -0.0006) {
        const ToolForce in = spring(k, e_m -= kStep_m);
        const ToolForce felt = boundByStoredEnergy(s, in, {-kStep_m, 0.0, 0.0});
        EXPECT_NEAR(felt.force_n.x, e_m > 0.0 ? 0.0 : in.force_n.x, k * kStep_m + 1e-9) << e_m;
    }
    StoredEnergy sliding;
    boundByStoredEnergy(sliding, spring(k, 0.0007, true), Vec3(0.0));
    EXPECT_EQ(sliding.share(), 0.0);
    for (int i = 0; i < 71; ++i)
        boundByStoredEnergy(sliding, spring(k, 0.0007), {kStep_m, 0.0, 0.0});
    EXPECT_EQ(sliding.share(), 1.0);
}

// The energy of the guide's rail is negative near its line.
TEST(StoredEnergy, NegativeEnergyIsPassedOn) {
    StoredEnergy s;
    for (const bool event : {false, true}) {
        ToolForce in = spring(1000.0, 0.0003, event);
        in.energy_j -= 0.0045;
        const ToolForce felt = boundByStoredEnergy(s, in, {1e-5, 0.0, 0.0});
        EXPECT_EQ(felt.energy_j, in.energy_j);
        EXPECT_EQ(felt.force_n, in.force_n);
    }
}

TEST(StoredEnergy, ElasticMotionAndPuncturesLeaveTheForceUnchanged) {
    StoredEnergy s;
    for (int i = 1; i <= 200; ++i) {
        const double e_m = 1e-5 * (i <= 100 ? i : 200 - i);
        const ToolForce in = spring(1000.0, e_m);
        const ToolForce felt = boundByStoredEnergy(s, in, {i <= 100 ? 1e-5 : -1e-5, 0.0, 0.0});
        EXPECT_EQ(felt.force_n, in.force_n) << i;
    }
    s.springs_j = s.by_hand_j = 0.003;
    s.force_n.x = -2.5;
    EXPECT_EQ(boundByStoredEnergy(s, spring(1200.0, 0.00075, true), {1e-5, 0.0, 0.0}).force_n.x, -0.9);
}

TEST(StoredEnergy, ValueThatIsNotANumberIsPassedOnAndForgotten) {
    StoredEnergy s;
    s.springs_j = s.by_hand_j = 1e-3;
    ToolForce bad = spring(1000.0, 1e-3);
    bad.force_n.y = std::nan("");
    EXPECT_TRUE(std::isnan(boundByStoredEnergy(s, bad, Vec3(0.0)).force_n.y));
    EXPECT_EQ(s.share(), 1.0);
}

// ---- Loops of a needle through a patient ----

// Draws the needle back from every depth, so that its force passes zero at the border from soft tissue to
// skin, in front of it and behind it. On the way out the hand feels the skin's friction.
TEST(StoredEnergy, ReversalNearABorderKeepsTheForce) {
    const patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.020}});
    for (int turn = 0; turn < 20; ++turn) {
        test::SimulationBench bench(package);
        bench.to(-0.005);
        bench.sweep(0.0027 + 4e-6 * turn);
        double x_m = bench.input.device.device_from_stylus.position_m.x;
        while (x_m > 0.001)
            bench.to(x_m -= 0.00009);
        EXPECT_NEAR(bench.out.force_n, -0.7, 1e-9);
        EXPECT_NEAR(bench.simulation.state().stored.share(), 1.0, 0.05) << turn;
    }
}

#ifdef STYLET_LONG_TESTS
constexpr int kLoops = 10000;
#else
constexpr int kLoops = 2000;
#endif

// Loops of a hand that begin and end with relaxed springs.
struct Loops {
    int count = 0;
    int active = 0;  // gave energy to the hand
    double worst_j = -HUGE_VAL;
};

SimulationSettings ideal(double controller_share) {
    SimulationSettings settings;
    settings.profile.force_peak_n = 100.0;
    settings.profile.stiffness_n_per_m = 1e6;
    settings.profile.mass_kg = 0.1;
    settings.profile.delay_s = 0.0;
    settings.output.controller_share = controller_share;
    return settings;
}

// A hand that turns back where it gains most, just behind a cut, or anywhere.
class GreedyHand {
  public:
    GreedyHand(const patient::Package& package, std::uint64_t seed, double controller_share)
        : bench_(package, ideal(controller_share)), random_(seed), controlled_(controller_share > 0.0) {
        for (int i = 0; i < 2000; ++i)
            bench_.to(x_m_);
        EXPECT_EQ(bench_.out.stage, ForceStage::on);
        EXPECT_EQ(bench_.simulation.gain(), 1.0);
        steepest_n_per_m_ = maxTangent(bench_.patient.package().tissues, NeedleSettings{});
    }

    void play(Loops& loops) {
        for (int i = 0; i < 4000 && x_m_ < 0.030; ++i) {
            move();
            if (bench_.out.force_n != 0.0) {
                loaded_ = true;
            } else if (loaded_) {
                finishLoop(loops);
            }
            turn();
        }
        EXPECT_EQ(bench_.out.faults, 0u);
    }

  private:
    // One tick. The last step back ends where the spring is relaxed.
    void move() {
        double step_m = advancing_ ? step_m_ : -step_m_;
        const double e_m = bench_.out.extension_m;
        const bool relaxes = bench_.out.phase == Phase::pass && e_m * step_m < 0.0;
        if (relaxes && std::fabs(e_m) < step_m_) step_m = -e_m;
        returned_j_ += bench_.out.sent_device_n.x * step_m;
        bench_.to(x_m_ += step_m);
    }

    // At the cut, at the turn and at the end, a held force returns up to K dx^2 / 2 more than a spring would,
    // before the controller can have measured it. What it has measured and still owes is not the hand's to
    // keep.
    void finishLoop(Loops& loops) {
        const double owed_j = controlled_ ? bench_.simulation.state().output.passivity.excess_energy_j : 0.0;
        EXPECT_LT(owed_j, 0.05e-3);
        ++loops.count;
        loops.active += returned_j_ - owed_j > 1.5 * steepest_n_per_m_ * step_m_ * step_m_;
        loops.worst_j = std::max(loops.worst_j, returned_j_ - owed_j);
        returned_j_ = 0.0;
        loaded_ = false;
        advancing_ = bench_.out.depth_m <= 0.0 || below(random_, 2) == 0;
        step_m_ = 1e-6 * std::exp(uniform(random_, std::log(3.0), std::log(50.0)));
        turn_m_ = x_m_ + uniform(random_, 0.0, 0.003);
    }

    void turn() {
        bool cut = false;
        for (const NeedleEvent& e : bench_.events.all())
            cut = cut || e.kind != NeedleEventKind::border;
        if (advancing_) {
            advancing_ = x_m_ <= turn_m_ && !(cut && below(random_, 3) != 0);
        } else if (x_m_ < -0.001 || (cut && below(random_, 3) == 0)) {
            advancing_ = true;
            turn_m_ = x_m_ + 0.003;
        }
    }

    test::SimulationBench bench_;
    Random random_;
    bool controlled_;
    double steepest_n_per_m_ = 0.0;
    double x_m_ = -0.001, step_m_ = 2e-5, turn_m_ = 0.002;
    bool advancing_ = true, loaded_ = false;
    double returned_j_ = 0.0;  // to the hand, since the last loop ended
};

Loops playPaper(int count, double controller_share) {
    const patient::Package torso = test::makeColumn({{skin, 0.002},
                                                     {soft, 0.004},
                                                     {fascia, 0.001},
                                                     {liver, 0.004},
                                                     {duct, 0.002},
                                                     {liver, 0.002},
                                                     {vessel, 0.002},
                                                     {liver, 0.02}});
    Loops loops;
    for (std::uint64_t seed = 1; loops.count < count; ++seed)
        GreedyHand(torso, seed, controller_share).play(loops);
    return loops;
}

Loops playRandomTables(int count, double controller_share) {
    Loops loops;
    for (std::uint64_t seed = 1; loops.count < count; ++seed)
        GreedyHand(test::RandomColumn(seed).package, seed, controller_share).play(loops);
    return loops;
}

TEST(StoredEnergy, NoLoopGivesEnergyToTheHand) {
    for (const auto play : {playPaper, playRandomTables}) {
        const Loops loops = play(kLoops, 1.0);
        EXPECT_EQ(loops.active, 0) << "worst " << loops.worst_j << " J";
        EXPECT_GE(loops.count, kLoops);
    }
}

// The same hand gains energy from an uncontrolled needle.
TEST(StoredEnergy, ManyLoopsWithoutControlGiveEnergyToTheHand) {
    for (const auto play : {playPaper, playRandomTables}) {
        const Loops loops = play(200, 0.0);
        EXPECT_GT(loops.active, 10);
        EXPECT_GT(loops.worst_j, 0.04e-3);
    }
}

}  // namespace
}  // namespace stylet::haptics
