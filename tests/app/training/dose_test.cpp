#include "app/training/dose.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/constants.h"

namespace stylet::training {
namespace {

using test::kDt_s;

// Steps `ticks` times with the pedal unchanged.
void expose(Dose& dose, XrayState& xray, int ticks, std::uint64_t& tick) {
    for (int i = 0; i < ticks; ++i)
        dose.step(xray, 0.0, ++tick);
}

// HZ-TEACH-16
TEST(Dose, CountsPulsesFromTheFirstTickOfThePedal) {
    Dose dose({}, kDt_s);
    XrayState xray;
    xray.pulses_per_s = 10.0;
    std::uint64_t tick = 0;
    expose(dose, xray, 500, tick);
    EXPECT_EQ(dose.ledger().pulses, 0u);
    xray.pedal = true;
    expose(dose, xray, 1, tick);
    EXPECT_EQ(dose.ledger().pulses, 1u);
    EXPECT_EQ(xray.last_pulse_tick, 501u);
    expose(dose, xray, 99, tick);
    EXPECT_EQ(dose.ledger().pulses, 1u);
    expose(dose, xray, 1, tick);
    EXPECT_EQ(dose.ledger().pulses, 2u);
    expose(dose, xray, 1899, tick);
    EXPECT_EQ(dose.ledger().pulses, 20u);
    EXPECT_EQ(xray.pulses, 20u);
    EXPECT_NEAR(dose.ledger().fluoroscopy_s, 2.0, 1e-9);
    // If the pedal is pressed when a pulse is due, the pulse comes at once.
    xray.pedal = false;
    expose(dose, xray, 5, tick);
    xray.pedal = true;
    expose(dose, xray, 1, tick);
    EXPECT_EQ(dose.ledger().pulses, 21u);
}

// HZ-TEACH-16
TEST(Dose, TappingThePedalGivesNoMorePulses) {
    Dose dose({}, kDt_s);
    XrayState xray;
    xray.pulses_per_s = 10.0;
    std::uint64_t tick = 0;
    for (int i = 0; i < 200; ++i) {
        xray.pedal = !xray.pedal;
        expose(dose, xray, 5, tick);
    }
    EXPECT_LE(dose.ledger().pulses, 11u);
    EXPECT_GE(dose.ledger().pulses, 9u);
}

TEST(Dose, FasterRateAppliesAtOnce) {
    Dose dose({}, kDt_s);
    XrayState xray;
    xray.pedal = true;
    xray.pulses_per_s = 0.5;
    std::uint64_t tick = 0;
    expose(dose, xray, 10, tick);
    xray.pulses_per_s = 20.0;
    expose(dose, xray, 51, tick);
    EXPECT_EQ(dose.ledger().pulses, 2u);
}

// HZ-TEACH-16
TEST(Dose, IsAirKermaTimesTheFieldAtTheReferencePoint) {
    const DoseSettings settings;
    Dose dose(settings, kDt_s);
    XrayState xray;
    xray.pedal = true;
    xray.field_m = 0.22;
    xray.pulses_per_s = 15.0;
    std::uint64_t tick = 0;
    expose(dose, xray, 60'000, tick);
    const auto pulses = double(dose.ledger().pulses);
    EXPECT_NEAR(pulses, 60.0 * 15.0, 10.0);
    EXPECT_NEAR(dose.ledger().air_kerma_gy, 0.020, 0.0005) << "20 mGy a minute";
    const double edge_m = 0.22 * (0.72 - 0.15) / 1.1;
    EXPECT_NEAR(dose.ledger().dose_area_gy_m2, pulses * settings.air_kerma_per_pulse_gy * edge_m * edge_m,
                1e-12);
}

TEST(Dose, AQuarterOfTheFieldIsAQuarterOfTheProduct) {
    double products[2] = {};
    for (const int half : {0, 1}) {
        Dose dose({}, kDt_s);
        XrayState xray;
        xray.pedal = true;
        xray.field_m = half ? 0.15 : 0.30;
        std::uint64_t tick = 0;
        expose(dose, xray, 3000, tick);
        products[half] = dose.ledger().dose_area_gy_m2;
    }
    EXPECT_NEAR(products[1] / products[0], 0.25, 1e-12);
}

TEST(Dose, PulseRateIsLimitedToTheTickRate) {
    Dose dose({}, kDt_s);
    XrayState xray;
    xray.pedal = true;
    xray.pulses_per_s = 1e9;
    std::uint64_t tick = 0;
    expose(dose, xray, 100, tick);
    EXPECT_EQ(dose.ledger().pulses, 100u);
}

}  // namespace
}  // namespace stylet::training
