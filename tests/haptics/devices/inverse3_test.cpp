#include "haptics/devices/inverse3.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "haptics/devices/polled.h"
#include "tests/support/inverse3_emulator.h"
#include "tests/support/wall_clock.h"

namespace stylet::haptics {
namespace {

using test::Inverse3Emulator;
using test::Inverse3Fault;
using test::Inverse3Script;

// The emulator is held against the examples in the text of RFC 6455.
TEST(Inverse3Emulator, AgreesWithTheExamplesOfRfc6455) {
    EXPECT_EQ(test::webSocketAccept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
    const std::vector<std::uint8_t> hello{0x81, 0x85, 0x37, 0xFA, 0x21, 0x3D, 0x7F, 0x9F, 0x4D, 0x51, 0x58};
    EXPECT_EQ(test::unmask(hello), (std::vector<std::uint8_t>{'H', 'e', 'l', 'l', 'o'}));
}

class Inverse3DriverTest : public testing::Test {
  protected:
    // Opens and presses once a millisecond. Returns why it failed, or "did not fail".
    std::string press(Inverse3Driver& driver, int ticks = 300) {
        std::string why;
        stage = driver.open(why);
        if (stage != DeviceStage::opening) return why;
        for (int i = 0; i < ticks; ++i) {
            why.clear();
            stage = driver.exchange({0.0, 0.0, stage == DeviceStage::ready ? 1.25 : 0.0}, state, why);
            failed_ns = test::wallNow_ns();
            if (stage == DeviceStage::failed) return why;
            fresh += state.fresh;
            was_ready = was_ready || stage == DeviceStage::ready;
            last_why = why;
            usleep(1000);
        }
        return "did not fail";
    }
    // With patience: the machine that runs this test may be busy. The clock is looked at in one test only.
    static Inverse3Settings at(const Inverse3Emulator& emulator) {
        return {.port = emulator.port(), .silent_ns = 150'000'000, .greeting_ns = 500'000'000};
    }

    DeviceStage stage = DeviceStage::absent;
    DeviceState state;
    std::int64_t failed_ns = 0;
    int fresh = 0;
    bool was_ready = false;
    std::string last_why;
};

TEST_F(Inverse3DriverTest, BothSpellingsByVersion) {
    struct Case {
        const char* version;
        bool data_envelope;
    };
    for (const auto& [version, data] :
         {Case{"3.5.0.0", false}, {"3.5.2", true}, {"3.1.1.0", false}, {"", false}}) {
        Inverse3Emulator emulator({.version = version, .data_envelope = data});
        Inverse3Driver driver(test::kWallClock, at(emulator));
        EXPECT_EQ(press(driver, 20), "did not fail") << version;
        EXPECT_EQ(stage, DeviceStage::ready);
        EXPECT_EQ(emulator.complaint(), "") << version;
        EXPECT_EQ(emulator.force_n(), (std::array<double, 3>{0.0, -1.25, 0.0})) << version;
        EXPECT_EQ(state.flags, kDeviceReady | kDeviceHandOn);
        EXPECT_EQ(state.buttons, std::string(version) >= "3.5" ? 5u : 1u);
        EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.01, 0.15, 0.12));
        EXPECT_TRUE(driver.profile().senses_rotation);
        driver.close();
        for (int i = 0; i < 1000 && emulator.force_n()[1] != 0.0; ++i)
            usleep(1000);
        EXPECT_EQ(emulator.force_n()[1], 0.0);
    }
}

TEST_F(Inverse3DriverTest, ASpellingCanBeSet) {
    Inverse3Emulator emulator({.version = "3.5.0.0"});
    Inverse3Settings settings = at(emulator);
    settings.spelling = Inverse3Settings::Spelling::values;
    Inverse3Driver driver(test::kWallClock, settings);
    press(driver, 3);
    EXPECT_NE(emulator.complaint().find("values"), std::string::npos);
}

TEST_F(Inverse3DriverTest, OnlyThisMachineIsAsked) {
    for (const char* address : {"192.168.1.7", "0.0.0.0", "::", "8.8.8.8", "localhost", "not an address"}) {
        Inverse3Driver driver(test::kWallClock, {.address = address});
        std::string why;
        EXPECT_EQ(driver.open(why), DeviceStage::failed);
        EXPECT_EQ(why, std::string(address) + " is no address of this machine itself");
    }
}

TEST_F(Inverse3DriverTest, WithoutAServiceOrADeviceItIsAbsent) {
    unsigned short port = 0;
    {
        Inverse3Emulator gone({});
        port = gone.port();
    }
    Inverse3Driver nobody(test::kWallClock, {.port = port});
    std::string why;
    EXPECT_EQ(nobody.open(why), DeviceStage::absent);
    EXPECT_TRUE(why.starts_with("Haply's service does not answer")) << why;

    Inverse3Emulator empty({.device = false});
    Inverse3Driver driver(test::kWallClock, at(empty));
    EXPECT_EQ(driver.open(why), DeviceStage::absent);
    EXPECT_EQ(why, "Haply's service runs, no Inverse3 is plugged in");
}

TEST_F(Inverse3DriverTest, WithoutAGripItSensesNoRotation) {
    Inverse3Emulator emulator({.grip = false});
    Inverse3Driver driver(test::kWallClock, at(emulator));
    EXPECT_EQ(press(driver, 10), "did not fail");
    EXPECT_FALSE(driver.profile().senses_rotation);
    EXPECT_EQ(stage, DeviceStage::ready);
}

TEST_F(Inverse3DriverTest, EveryFaultIsAFailureWithItsName) {
    const std::string json = "a message of the service: ";
    const std::pair<Inverse3Fault, std::string> cases[] = {
        {Inverse3Fault::drop, "nothing from the service for 150 ms"},
        {Inverse3Fault::stall, "nothing from the service for 150 ms"},
        {Inverse3Fault::cut, "the service is gone"},
        {Inverse3Fault::close, "the service closed the connection"},
        {Inverse3Fault::brokenJson, json + "no JSON within the bounds"},
        {Inverse3Fault::flipped, json + "no JSON within the bounds"},
        {Inverse3Fault::notFinite, json + "no JSON within the bounds"},
        {Inverse3Fault::huge, json + "no JSON within the bounds"},
        {Inverse3Fault::deep, json + "no JSON within the bounds"},
        {Inverse3Fault::farAway, json + "inverse3: state.cursor_position"},
        {Inverse3Fault::wrongType, json + "inverse3: state.cursor_position"},
        {Inverse3Fault::noPosition, json + "inverse3: state.cursor_position"},
        {Inverse3Fault::notAUnit, json + "wireless_verse_grip: state.orientation"},
        {Inverse3Fault::big, "a message of more than 256 KiB"},
        {Inverse3Fault::binary, json + "not text"},
        {Inverse3Fault::masked, "the service is gone"},
        {Inverse3Fault::unplugged, "the Inverse3 was unplugged"},
        {Inverse3Fault::otherDevice, "the Inverse3 was unplugged"},
        {Inverse3Fault::flood, json + "one too many at once: a flood"},
    };
    for (const auto& [fault, name] : cases) {
        Inverse3Emulator emulator({.fault = fault, .from_answer = 15});
        Inverse3Driver driver(test::kWallClock, at(emulator));
        was_ready = false;
        const std::string why = press(driver);
        EXPECT_TRUE(why.starts_with(name)) << why << " instead of " << name;
        EXPECT_TRUE(was_ready) << name;
        EXPECT_EQ(emulator.complaint(), "") << name;
    }
}

TEST_F(Inverse3DriverTest, WhatIsNoFaultIsSurvived) {
    for (const Inverse3Fault fault :
         {Inverse3Fault::duplicate, Inverse3Fault::pings, Inverse3Fault::fragments}) {
        Inverse3Emulator emulator({.fault = fault, .from_answer = 5});
        Inverse3Driver driver(test::kWallClock, at(emulator));
        fresh = 0;
        EXPECT_EQ(press(driver, 100), "did not fail") << int(fault);
        EXPECT_EQ(stage, DeviceStage::ready);
        EXPECT_GE(fresh, 90);
    }
    // One answer left out, and one that comes 8 ms late.
    for (const Inverse3Fault fault : {Inverse3Fault::drop, Inverse3Fault::stall}) {
        Inverse3Emulator emulator({.fault = fault, .from_answer = 20, .answers = 1, .stall_ms = 8});
        Inverse3Driver driver(test::kWallClock, at(emulator));
        EXPECT_EQ(press(driver, 100), "did not fail") << int(fault);
        EXPECT_EQ(stage, DeviceStage::ready);
    }
}

TEST_F(Inverse3DriverTest, WhatTheUserCanMendHoldsTheForceBack) {
    const std::pair<Inverse3Fault, const char*> cases[] = {
        {Inverse3Fault::uncalibrated,
         "calibrate the Inverse3: hold its grip in the holder until the light is steady"},
        {Inverse3Fault::noPower, "the Inverse3 has no power supply"},
        {Inverse3Fault::gripGone, "the VerseGrip is gone"},
    };
    for (const auto& [fault, why] : cases) {
        Inverse3Emulator emulator({.fault = fault, .from_answer = 10});
        Inverse3Driver driver(test::kWallClock, at(emulator));
        EXPECT_EQ(press(driver, 40), "did not fail");
        EXPECT_EQ(last_why, why);
        EXPECT_EQ(stage,
                  fault == Inverse3Fault::uncalibrated ? DeviceStage::needsHoming : DeviceStage::opening);
        EXPECT_EQ(state.flags & kDeviceReady, 0u);
        EXPECT_EQ(emulator.force_n()[1], 0.0);
    }
}

// How long from the first faulty answer to the failure. The machine may be busy: the median of some runs.
// HZ-FORCE-07
TEST_F(Inverse3DriverTest, AFaultIsKnownWithin20Ms) {
    for (const Inverse3Fault fault :
         {Inverse3Fault::drop, Inverse3Fault::stall, Inverse3Fault::cut, Inverse3Fault::big}) {
        std::vector<double> times_ms;
        for (int run = 0; run < 7; ++run) {
            Inverse3Emulator emulator({.fault = fault, .from_answer = 15});
            Inverse3Driver driver(test::kWallClock, {.port = emulator.port()});
            ASSERT_NE(press(driver), "did not fail");
            times_ms.push_back(1e-6 * double(failed_ns - emulator.fault_began_ns()));
        }
        std::sort(times_ms.begin(), times_ms.end());
        EXPECT_LE(times_ms[times_ms.size() / 2], 20.0) << int(fault);
        RecordProperty("median_us_of_fault_" + std::to_string(int(fault)),
                       int(1e3 * times_ms[times_ms.size() / 2]));
    }
}

TEST(Inverse3Polled, ComesBackAfterTheServiceWasCutOff) {
    PolledSettings settings;
    settings.look_again_ns = settings.backoff_first_ns = 10'000'000;
    Inverse3Emulator emulator({.fault = Inverse3Fault::cut, .from_answer = 30, .answers = 2});
    PolledDevice device(
        std::make_unique<Inverse3Driver>(test::kWallClock, Inverse3Settings{.port = emulator.port()}),
        test::kWallClock, settings);
    device.start();
    bool ready = false, lost = false, back = false;
    for (int i = 0; i < 10'000 && !back; ++i) {
        const bool now_ready = device.read(test::wallNow_ns()).flags & kDeviceReady;
        lost = lost || (ready && !now_ready);
        back = lost && now_ready && emulator.answered() > 40;
        ready = now_ready;
        device.send({0.0, 0.0, now_ready ? 0.5 : 0.0});
        usleep(1000);
    }
    EXPECT_TRUE(lost);
    EXPECT_TRUE(back) << device.report().why;
    EXPECT_GE(emulator.connections(), 3);
    EXPECT_GE(device.report().failures, 2u);
}

}  // namespace
}  // namespace stylet::haptics
