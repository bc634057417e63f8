#include "patient/contrast/anaesthetic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/constants.h"

namespace stylet::patient {
namespace {

using test::kDt_s;

constexpr double kMillilitre = 1e-6;

void inject(Anaesthetic& to, const Vec3& at_m, double ml, Tissue tissue = Tissue::soft) {
    for (int i = 0; i < int(std::lround(1000.0 * ml)); ++i)
        to.step({at_m, 1e-6, tissue}, kDt_s);
}

TEST(Anaesthetic, ADepotIsABallOfItsVolume) {
    EXPECT_NEAR(depotRadius_m(4.0 / 3.0 * std::numbers::pi * 1e-6), 0.010, 1e-12);
    EXPECT_EQ(depotRadius_m(-1.0), 0.0);
    Anaesthetic state;
    EXPECT_FALSE(state.begun());
    inject(state, {0.01, 0.0, 0.0}, 2.0);
    ASSERT_EQ(state.depots().size(), 1u);
    EXPECT_NEAR(state.depots()[0].volume_m3, 2.0 * kMillilitre, 1e-12);
    EXPECT_EQ(state.depots()[0].centre_m, Vec3(0.01, 0.0, 0.0));
}

// Within the ball that the volume can soak, tissue is numb. Beyond it the effect falls linearly.
TEST(Anaesthetic, NumbnessFollowsTheSoakedBall) {
    const AnaestheticSettings settings;
    Anaesthetic state;
    EXPECT_EQ(state.numbness(Vec3(0.0)), 0.0);
    inject(state, Vec3(0.0), 1.0);
    const double numb_m = std::cbrt(3.0 * kMillilitre / settings.soaked_share / (4.0 * std::numbers::pi));
    const auto at = [&](double share) { return state.numbness({share * numb_m, 0.0, 0.0}); };
    EXPECT_EQ(at(0.0), 1.0);
    EXPECT_EQ(at(0.99), 1.0);
    EXPECT_NEAR(at(1.0 + 0.25 * settings.fade_share), 0.75, 1e-6);
    EXPECT_NEAR(at(1.0 + 0.5 * settings.fade_share), 0.5, 1e-6);
    EXPECT_EQ(at(1.01 + settings.fade_share), 0.0);
}

TEST(Anaesthetic, ADropDoesNotNumb) {
    Anaesthetic state;
    inject(state, Vec3(0.0), 0.001);
    EXPECT_NEAR(state.numbness(Vec3(0.0)), 1.0 / 300.0, 1e-6);
    inject(state, Vec3(0.0), 0.149);
    EXPECT_NEAR(state.numbness(Vec3(0.0)), 0.5, 1e-6);
}

TEST(Anaesthetic, EveryDropIsAccountedFor) {
    Anaesthetic state;
    inject(state, Vec3(0.0), 1.0);
    inject(state, Vec3(0.0), 0.4, Tissue::vessel);
    inject(state, Vec3(0.0), 0.3, Tissue::duct);
    inject(state, Vec3(0.0), 0.2, Tissue::air);
    inject(state, {0.1, 0.0, 0.0}, 0.5, Tissue::liver);
    const AnaestheticVolumes& v = state.volumes();
    EXPECT_NEAR(v.tissue_m3, 1.5 * kMillilitre, 1e-12);
    EXPECT_NEAR(v.vessels_m3, 0.4 * kMillilitre, 1e-12);
    EXPECT_NEAR(v.lost_m3, 0.5 * kMillilitre, 1e-12);
    EXPECT_NEAR(v.injected_m3, v.tissue_m3 + v.vessels_m3 + v.lost_m3, 1e-15);
    EXPECT_EQ(state.depots().size(), 2u);
    EXPECT_EQ(state.numbness({0.1, 0.0, 0.0}), 1.0);
}

TEST(Anaesthetic, AFullDepotGrowsAndAFarPlaceBeginsAnother) {
    Anaesthetic state;
    inject(state, Vec3(0.0), 1.0);
    inject(state, {0.9 * depotRadius_m(kMillilitre), 0.0, 0.0}, 0.5);
    EXPECT_EQ(state.depots().size(), 1u) << "within the pool";
    inject(state, {0.012, 0.0, 0.0}, 0.5);
    EXPECT_EQ(state.depots().size(), 2u);
}

TEST(Anaesthetic, OnlyAnInjectionChangesTheState) {
    Anaesthetic state, other;
    const std::uint64_t empty = state.hash();
    for (const double rate : {0.0, -1.0, test::kNaN})
        state.step({Vec3(0.0), rate, Tissue::soft}, kDt_s);
    EXPECT_EQ(state.hash(), empty);
    EXPECT_FALSE(state.begun());
    state.step({Vec3(0.0), 1.0, Tissue::soft}, kDt_s);
    EXPECT_NEAR(state.volumes().injected_m3, AnaestheticSettings{}.max_m3_per_s * kDt_s, 1e-15);
    other.step({Vec3(0.0), 1.0, Tissue::vessel}, kDt_s);
    EXPECT_NE(state.hash(), other.hash());
}

}  // namespace
}  // namespace stylet::patient
