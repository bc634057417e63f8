#include "haptics/devices/replay.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "patient/patient.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::haptics {
namespace {

TEST(ReplayDevice, FollowsItsTraceFromItsStart) {
    Trace trace;
    trace.samples = {{0, {{}, {0.0, 0.0, 0.0}}, 0}, {1000, {{}, {1.0, 0.0, 0.0}}, 5}};
    ReplayDevice device(trace, 500, {"weak", 1.0, 100.0, ""});
    EXPECT_EQ(device.read(1000).device_from_stylus.position_m.x, 0.5);
    const DeviceState last = device.read(9000);
    EXPECT_EQ(last.device_from_stylus.position_m.x, 1.0);
    EXPECT_EQ(last.buttons, 5u);
    EXPECT_EQ(last.fresh, 1u);
    EXPECT_EQ(device.profile().force_peak_n, 1.0);
    device.send({0.0, 2.0, 0.0});
    EXPECT_EQ(device.force().y, 2.0);
}

// A random trace in which every bit of every pose matters.
Trace randomTrace(int count) {
    std::mt19937_64 random(3);
    const auto uniform = [&] { return double(random() >> 11) * 0x1p-52 - 1.0; };
    Trace trace;
    for (int i = 0; i < count; ++i) {
        const Quat q(uniform(), uniform(), uniform(), uniform());
        const double norm = std::sqrt(glm::dot(q, q));
        trace.samples.push_back({std::int64_t(i) * 999983,
                                 {{q.w / norm, q.x / norm, q.y / norm, q.z / norm},
                                  {uniform(), 1e-9 * uniform(), 9.0 * uniform()}},
                                 std::uint32_t(random())});
    }
    return trace;
}

TEST(ReplayDevice, FileReplaysTheRecordedPosesBitForBit) {
    const test::TempFolder folder;
    const Trace recorded = randomTrace(500);
    saveTrace(recorded, folder.path() / "hand.csv");
    const Trace loaded = loadTrace(folder.path() / "hand.csv");
    ASSERT_EQ(loaded.samples.size(), recorded.samples.size());
    ReplayDevice device(loaded, 7);
    for (const TraceSample& s : recorded.samples) {
        const DeviceState state = device.read(s.t_ns + 7);
        ASSERT_EQ(state.device_from_stylus.position_m, s.device_from_stylus.position_m);
        ASSERT_EQ(state.device_from_stylus.rotation, s.device_from_stylus.rotation);
        ASSERT_EQ(state.buttons, s.buttons);
    }
}

TEST(ReplayDevice, HostileFilesAreRefusedByLine) {
    const std::string head = "t_ns,x_m,y_m,z_m,qw,qx,qy,qz,buttons\n", good = "0,0,0,0,1,0,0,0,0\n";
    EXPECT_EQ(parseTrace("hand.csv", head + good + "5,0.25,0,0,1,0,0,0,4294967295\r\n").samples.size(), 2u);
    const auto refused = [&](const std::string& text, const char* field) {
        test::expectRefused([&] { parseTrace("hand.csv", text); }, "hand.csv", field);
    };
    refused("", "line 1");
    refused("t,x,y,z\n" + good, "line 1");
    refused(head, "line 1");                           // no samples
    refused(head + "0,0,0,0,1,0,0,0\n", "line 2");     // a column too few
    refused(head + "0,0,0,0,1,0,0,0,0,\n", "line 2");  // a column too many
    refused(head + good + "\n", "line 3");             // an empty line
    refused(head + good + good, "line 3");             // time does not advance
    refused(head + "-1,0,0,0,1,0,0,0,0\n", "line 2");  // negative time
    refused(head + "99999999999999999999,0,0,0,1,0,0,0,0\n", "line 2");
    refused(head + "0,nan,0,0,1,0,0,0,0\n", "line 2");
    refused(head + "0,inf,0,0,1,0,0,0,0\n", "line 2");
    refused(head + "0,1e300,0,0,1,0,0,0,0\n", "line 2");
    refused(head + "0,0,0,0,0,0,0,0,0\n", "line 2");  // not a rotation
    refused(head + "0,0,0,0,nan,0,0,0,0\n", "line 2");
    refused(head + "0,0,0,0,1,0,0,0,4294967296\n", "line 2");
    refused(head + "0,0,0,0,1,0,0,0,-1\n", "line 2");
    refused(head + "0, 0,0,0,1,0,0,0,0\n", "line 2");  // spaces are not allowed in numbers
    refused(head + "0,0,0,0,1,0,0,0,0" + std::string(1, '\0') + "\n", "line 2");
    test::expectRefused([] { loadTrace("no-such-folder/hand.csv"); }, "hand.csv", "file");
}

}  // namespace
}  // namespace stylet::haptics
