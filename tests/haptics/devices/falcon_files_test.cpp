// Files that a user provides for the Falcon driver: a firmware image and a calibration.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "haptics/devices/falcon/falcon_calibration.h"
#include "haptics/devices/falcon/falcon_firmware.h"
#include "haptics/devices/falcon/sha256.h"
#include "patient/patient.h"
#include "tests/support/temp_folder.h"

namespace stylet::haptics::falcon {
namespace {

using testing::HasSubstr;

// Returns the message of the DataError, or an empty string if none is thrown.
template <typename Call>
std::string refusal(const Call& call) {
    try {
        call();
    } catch (const DataError& e) {
        return e.what();
    }
    return "";
}

struct FalconFiles : testing::Test {
    std::filesystem::path write(const std::string& bytes) {
        const std::filesystem::path file = folder.path() / "file";
        std::ofstream(file, std::ios::binary) << bytes;
        return file;
    }
    test::TempFolder folder;
};

std::string hashOf(const std::string& text) {
    return computeSha256(std::vector<std::uint8_t>(text.begin(), text.end()));
}

// The examples of FIPS 180-4, and lengths around the block size.
TEST(Sha256, MatchesStandardTestVectors) {
    EXPECT_EQ(hashOf(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(hashOf("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(hashOf("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(hashOf(std::string(1'000'000, 'a')),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_F(FalconFiles, FirmwareImageIsLoadedAndIdentifiedByItsHash) {
    const Firmware firmware = loadFirmwareFile(write("abc"));
    EXPECT_EQ(firmware.image, (std::vector<std::uint8_t>{'a', 'b', 'c'}));
    EXPECT_EQ(firmware.sha256, hashOf("abc"));
    EXPECT_THAT(refusal([&] { loadFirmwareFile(write("")); }), HasSubstr("empty"));
    EXPECT_THAT(refusal([&] { loadFirmwareFile(write(std::string(65537, 'x'))); }),
                HasSubstr("larger than 65536 bytes"));
    EXPECT_EQ(loadFirmwareFile(write(std::string(65536, 'x'))).image.size(), 65536u);
    EXPECT_NE(refusal([&] { loadFirmwareFile(folder.path() / "none"); }), "");
    EXPECT_NE(refusal([&] { loadFirmwareFile(folder.path()); }), "");
}

TEST_F(FalconFiles, CalibrationRoundTripsThroughAFile) {
    const Calibration saved{.measured_per_asked = {0.5, 0.625, 1.0 / 3.0},
                            .measured = true,
                            .how = "kitchen scale \"A\", 2 readings"};
    saveCalibration(folder.path() / "c.toml", saved);
    const Calibration loaded = loadCalibration(folder.path() / "c.toml");
    EXPECT_EQ(loaded.measured_per_asked, saved.measured_per_asked);
    EXPECT_TRUE(loaded.measured);
    EXPECT_EQ(loaded.how, saved.how);
    EXPECT_NE(refusal([&] { saveCalibration(folder.path() / "no" / "c.toml", saved); }), "");
}

// HZ-FORCE-22
TEST_F(FalconFiles, ABadCalibrationIsRefusedByFieldAndReason) {
    const std::string good = "device = \"falcon\"\nmeasured_per_asked = [1.0, 2, 0.5]\nhow = \"\"\n";
    EXPECT_EQ(loadCalibration(write(good)).measured_per_asked.y, 2.0);
    const std::pair<const char*, const char*> bad[] = {
        {"", "device"},
        {"device = \"touch\"\nmeasured_per_asked = [1.0, 1.0, 1.0]", "device"},
        {"device = \"falcon\"", "measured_per_asked"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, 1.0]", "not 3 numbers"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, 1.0, 1.0, 1.0]", "not 3 numbers"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, \"1\", 1.0]", "not a number"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, nan, 1.0]", "[0.1, 10]"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, inf, 1.0]", "[0.1, 10]"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, -1.0, 1.0]", "[0.1, 10]"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, 0.01, 1.0]", "[0.1, 10]"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, 1.0, 1.0]\nextra = 1", "extra"},
        {"device = \"falcon\"\nmeasured_per_asked = [1.0, 1.0, 1.0", "line"},
        {"\xff\xfe\x00 not text", "line 1"},
    };
    for (const auto& [text, reason] : bad)
        EXPECT_THAT(refusal([&] { loadCalibration(write(text)); }), HasSubstr(reason)) << text;
    EXPECT_THAT(refusal([&] { loadCalibration(write(good + "#" + std::string(20000, 'x'))); }),
                HasSubstr("larger than 16384 bytes"));
    EXPECT_THAT(refusal([&] {
                    loadCalibration(write("device = \"falcon\"\nmeasured_per_asked = [1, 1, 1]\nhow = \"" +
                                          std::string(401, 'x') + "\""));
                }),
                HasSubstr("400"));
}

TEST(FalconCalibration, FitsALineThroughTheReadings) {
    EXPECT_DOUBLE_EQ(fitCalibration(std::vector<CalibrationReading>{{1.0, 2.0}, {2.0, 4.0}}, "z"), 2.0);
    EXPECT_NEAR(fitCalibration(std::vector<CalibrationReading>{{1.0, 0.52}, {2.0, 0.98}, {-1.0, -0.5}}, "z"),
                0.4967, 1e-4);
    const std::vector<CalibrationReading> bad[] = {
        {{1.0, 1.0}},
        {{1.0, 1.0}, {2.0, std::nan("")}},
        {{1.0, 1.0}, {0.0, 1.0}},
        {{1.0, 1.0}, {2.0, 4.0}},
        {{1.0, -1.0}, {2.0, -2.0}},
        {{1.0, 50.0}, {2.0, 100.0}},
    };
    for (const auto& readings : bad)
        EXPECT_THAT(refusal([&] { fitCalibration(readings, "z"); }), HasSubstr("z"));
}

}  // namespace
}  // namespace stylet::haptics::falcon
