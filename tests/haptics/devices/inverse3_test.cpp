#include "haptics/devices/inverse3/inverse3.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <vector>

#include "haptics/devices/inverse3/inverse3_messages.h"
#include "haptics/devices/polled.h"
#include "tests/support/constants.h"
#include "tests/support/inverse3_emulator.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/wait_until.h"

namespace stylet::haptics {
namespace {

using test::Inverse3Emulator;
using test::Inverse3Fault;
using test::Inverse3Script;
using test::kMs;
using test::SteppedClock;

// Checks the emulator against the examples in RFC 6455.
TEST(Inverse3Emulator, AgreesWithTheExamplesOfRfc6455) {
    EXPECT_EQ(test::webSocketAccept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
    const std::vector<std::uint8_t> hello{0x81, 0x85, 0x37, 0xFA, 0x21, 0x3D, 0x7F, 0x9F, 0x4D, 0x51, 0x58};
    EXPECT_EQ(test::unmask(hello), (std::vector<std::uint8_t>{'H', 'e', 'l', 'l', 'o'}));
}

// The driver runs on a clock that the test advances by one millisecond per exchange. The clock stands still
// while the emulator answers, so a stall of the test machine does not count as silence of the service.
class Inverse3DriverTest : public testing::Test {
  protected:
    // Opens the driver and sends force once per millisecond. Returns why it failed, or "did not fail".
    std::string press(Inverse3Driver& driver, int ticks = 300) {
        std::string why;
        stage = driver.open(why);
        if (stage != DeviceStage::opening) return why;
        for (int i = 0; i < ticks; ++i) {
            why.clear();
            began_ns = time.now_ns += kMs;
            stage = driver.exchange({0.0, 0.0, stage == DeviceStage::ready ? 1.25 : 0.0}, state, why);
            if (stage == DeviceStage::failed) return why;
            fresh += int(state.fresh);
            was_ready = was_ready || stage == DeviceStage::ready;
            last_why = why;
        }
        return "did not fail";
    }
    // The script with its times on the driver's clock.
    Inverse3Script timed(Inverse3Script script) {
        script.time_ns = &time.now_ns;
        return script;
    }
    static Inverse3Settings at(const Inverse3Emulator& emulator) { return {.port = emulator.port()}; }

    SteppedClock time;
    DeviceStage stage = DeviceStage::absent;
    DeviceState state;
    std::int64_t began_ns = 0;  // start of the last exchange
    int fresh = 0;
    bool was_ready = false;
    std::string last_why;
};

TEST_F(Inverse3DriverTest, SpellingFollowsTheServiceVersion) {
    struct Spelling {
        const char* version;
        bool data_envelope;
    };
    for (const auto& [version, data] :
         {Spelling{"3.5.0.0", false}, {"3.5.2", true}, {"3.1.1.0", false}, {"", false}}) {
        Inverse3Emulator emulator(timed({.version = version, .data_envelope = data}));
        Inverse3Driver driver(time.clock(), at(emulator));
        EXPECT_EQ(press(driver, 20), "did not fail") << version;
        EXPECT_EQ(stage, DeviceStage::ready);
        EXPECT_EQ(emulator.complaint(), "") << version;
        EXPECT_EQ(emulator.force_n(), (std::array<double, 3>{0.0, -1.25, 0.0})) << version;
        EXPECT_EQ(state.flags, kDeviceReady | kDeviceHandOn);
        EXPECT_EQ(state.buttons, std::string(version) >= "3.5" ? 5u : 1u);
        EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.01, 0.15, 0.12));
        EXPECT_TRUE(driver.profile().senses_rotation);
        driver.close();
        EXPECT_TRUE(test::waitUntil([&] { return emulator.force_n()[1] == 0.0; }));
    }
}

TEST_F(Inverse3DriverTest, ASpellingCanBeSet) {
    Inverse3Emulator emulator(timed({.version = "3.5.0.0"}));
    Inverse3Settings settings = at(emulator);
    settings.spelling = inverse3::Spelling::values;
    Inverse3Driver driver(time.clock(), settings);
    press(driver, 3);
    EXPECT_NE(emulator.complaint().find("values"), std::string::npos);
}

TEST_F(Inverse3DriverTest, OnlyLoopbackAddressesAreAccepted) {
    for (const char* address : {"192.168.1.7", "0.0.0.0", "::", "8.8.8.8", "localhost", "not an address"}) {
        Inverse3Driver driver(time.clock(), {.address = address});
        std::string why;
        EXPECT_EQ(driver.open(why), DeviceStage::failed);
        EXPECT_EQ(why, std::string(address) + " is not an address of this machine: use 127.0.0.1 or ::1");
    }
}

TEST_F(Inverse3DriverTest, WithoutAServiceOrADeviceItIsAbsent) {
    // A port that is bound, but without a listener.
    const int taken = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* generic = reinterpret_cast<sockaddr*>(&address);
    ASSERT_EQ(::bind(taken, generic, size), 0);
    ASSERT_EQ(::getsockname(taken, generic, &size), 0);
    Inverse3Driver nobody(time.clock(), {.port = ntohs(address.sin_port)});
    std::string why;
    EXPECT_EQ(nobody.open(why), DeviceStage::absent);
    EXPECT_TRUE(why.starts_with("Haply's service does not answer")) << why;
    ::close(taken);

    Inverse3Emulator empty(timed({.device = false}));
    Inverse3Driver driver(time.clock(), at(empty));
    EXPECT_EQ(driver.open(why), DeviceStage::absent);
    EXPECT_EQ(why, "Haply's service runs, but no Inverse3 is plugged in");
}

TEST_F(Inverse3DriverTest, WithoutAGripItSensesNoRotation) {
    Inverse3Emulator emulator(timed({.grip = false}));
    Inverse3Driver driver(time.clock(), at(emulator));
    EXPECT_EQ(press(driver, 10), "did not fail");
    EXPECT_FALSE(driver.profile().senses_rotation);
    EXPECT_EQ(stage, DeviceStage::ready);
}

TEST_F(Inverse3DriverTest, EveryFaultFailsWithItsReason) {
    const std::string json = "a message of the service: ";
    const std::pair<Inverse3Fault, std::string> cases[] = {
        {Inverse3Fault::drop, "nothing from the service for 15 ms"},
        {Inverse3Fault::stall, "nothing from the service for 15 ms"},
        {Inverse3Fault::cut, "the service is gone"},
        {Inverse3Fault::close, "the service closed the connection"},
        {Inverse3Fault::brokenJson, json + "not JSON within the limits"},
        {Inverse3Fault::flipped, json + "not JSON within the limits"},
        {Inverse3Fault::notFinite, json + "not JSON within the limits"},
        {Inverse3Fault::huge, json + "not JSON within the limits"},
        {Inverse3Fault::deep, json + "not JSON within the limits"},
        {Inverse3Fault::farAway, json + "inverse3: state.cursor_position"},
        {Inverse3Fault::wrongType, json + "inverse3: state.cursor_position"},
        {Inverse3Fault::noPosition, json + "inverse3: state.cursor_position"},
        {Inverse3Fault::notAUnit, json + "wireless_verse_grip: state.orientation"},
        {Inverse3Fault::big, "a message of more than 256 KiB"},
        {Inverse3Fault::binary, json + "not text"},
        {Inverse3Fault::masked, "the service is gone"},
        {Inverse3Fault::unplugged, "the Inverse3 was unplugged"},
        {Inverse3Fault::otherDevice, "the Inverse3 was unplugged"},
        {Inverse3Fault::flood, json + "too many messages at once"},
    };
    for (const auto& [fault, name] : cases) {
        Inverse3Emulator emulator(timed({.fault = fault, .from_answer = 15}));
        Inverse3Driver driver(time.clock(), at(emulator));
        was_ready = false;
        const std::string why = press(driver, 100'000);  // a flood may need many exchanges
        EXPECT_TRUE(why.starts_with(name)) << why << " instead of " << name;
        EXPECT_TRUE(was_ready) << name;
        EXPECT_EQ(emulator.complaint(), "") << name;
    }
}

TEST_F(Inverse3DriverTest, HarmlessDisturbancesAreTolerated) {
    for (const Inverse3Fault fault :
         {Inverse3Fault::duplicate, Inverse3Fault::pings, Inverse3Fault::fragments}) {
        Inverse3Emulator emulator(timed({.fault = fault, .from_answer = 5}));
        Inverse3Driver driver(time.clock(), at(emulator));
        fresh = 0;
        EXPECT_EQ(press(driver, 100), "did not fail") << int(fault);
        EXPECT_EQ(stage, DeviceStage::ready);
        EXPECT_EQ(fresh, 100);
    }
    // One answer missing, and one answer 8 ms late.
    for (const Inverse3Fault fault : {Inverse3Fault::drop, Inverse3Fault::stall}) {
        Inverse3Emulator emulator(timed({.fault = fault, .from_answer = 20, .answers = 1, .stall_ms = 8}));
        Inverse3Driver driver(time.clock(), at(emulator));
        EXPECT_EQ(press(driver, 100), "did not fail") << int(fault);
        EXPECT_EQ(stage, DeviceStage::ready);
    }
}

TEST_F(Inverse3DriverTest, UserFixableProblemsKeepTheForceZero) {
    const std::pair<Inverse3Fault, const char*> cases[] = {
        {Inverse3Fault::uncalibrated,
         "calibrate the Inverse3: hold its grip in the holder until the light is steady"},
        {Inverse3Fault::noPower, "the Inverse3 has no power supply"},
        {Inverse3Fault::gripMissing, "the VerseGrip is gone"},
    };
    for (const auto& [fault, why] : cases) {
        Inverse3Emulator emulator(timed({.fault = fault, .from_answer = 10}));
        Inverse3Driver driver(time.clock(), at(emulator));
        EXPECT_EQ(press(driver, 40), "did not fail");
        EXPECT_EQ(last_why, why);
        EXPECT_EQ(stage,
                  fault == Inverse3Fault::uncalibrated ? DeviceStage::needsHoming : DeviceStage::opening);
        EXPECT_EQ(state.flags & kDeviceReady, 0u);
        EXPECT_EQ(emulator.force_n()[1], 0.0);
    }
}

// Measures the driver's time from the first faulty answer to the failure. Only the driver's own waits count.
// HZ-FORCE-07
TEST_F(Inverse3DriverTest, FaultIsDetectedWithin20Ms) {
    for (const Inverse3Fault fault :
         {Inverse3Fault::drop, Inverse3Fault::stall, Inverse3Fault::cut, Inverse3Fault::big}) {
        Inverse3Emulator emulator(timed({.fault = fault, .from_answer = 15}));
        Inverse3Driver driver(time.clock(), at(emulator));
        was_ready = false;
        ASSERT_NE(press(driver), "did not fail");
        EXPECT_TRUE(was_ready);
        ASSERT_NE(emulator.fault_began_ns(), 0);
        const std::int64_t known_ns = began_ns + Inverse3Settings().answer_ns - emulator.fault_began_ns();
        EXPECT_LE(known_ns, 20 * kMs) << int(fault);
        RecordProperty("us_of_fault_" + std::to_string(int(fault)), int(known_ns / 1000));
    }
}

TEST_F(Inverse3DriverTest, ReconnectsAfterTheServiceWasInterrupted) {
    PolledSettings settings;
    settings.absent_retry_ns = settings.backoff_first_ns = 10 * kMs;
    Inverse3Emulator emulator(timed({.fault = Inverse3Fault::cut, .from_answer = 30, .answers = 2}));
    PolledDevice device(std::make_unique<Inverse3Driver>(time.clock(), at(emulator)), time.clock(), settings);
    bool ready = false, lost = false, back = false;
    for (int i = 0; i < 1000 && !back; ++i) {
        const bool now_ready = device.read(time.now_ns).flags & kDeviceReady;
        lost = lost || (ready && !now_ready);
        back = lost && now_ready && emulator.answered() > 40;
        ready = now_ready;
        device.send({0.0, 0.0, now_ready ? 0.5 : 0.0});
        time.advancePeriod(device.poll());
    }
    EXPECT_TRUE(lost);
    EXPECT_TRUE(back) << device.report().why;
    EXPECT_EQ(emulator.connections(), 3);
    EXPECT_EQ(device.report().failures, 2u);
}

}  // namespace
}  // namespace stylet::haptics
