#include "app/records/samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <random>

#include "app/records/bytes.h"
#include "patient/package/package.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using std::filesystem::path;

constexpr std::uint64_t kSampleTicks = 2 * kFrameTicks + 17;

// Each field has a different value that a 32-bit float represents exactly.
Sample someSample(std::uint64_t tick) {
    std::mt19937 random{std::uint32_t(tick)};
    const auto number = [&] { return double(float(random()) / 1e9f); };
    const auto vector = [&] { return Vec3(number(), number(), number()); };
    Sample s;
    s.tick = tick;
    s.tool = haptics::Tool(tick % haptics::kToolCount);
    s.patient_from_tool.rotation = {number(), number(), number(), number()};
    s.patient_from_tool.position_m = vector();
    s.tip_m = vector(), s.axis = vector();
    s.patient_from_probe.rotation = {number(), number(), number(), number()};
    s.patient_from_probe.position_m = vector();
    s.needle_in_guide = tick % 2 != 0, s.probe_parked = tick % 3 != 0, s.breath_held = tick % 5 != 0;
    s.phase = haptics::Phase(tick % 3);
    s.tissue = haptics::Tissue(tick % std::uint64_t(patient::kTissueCount));
    s.label = std::uint8_t(tick);
    s.depth_m = number(), s.force_n = -number();
    s.tool_force_n = vector(), s.sent_n = vector();
    s.extension_m = number(), s.breath_v = number();
    s.clearance_m = tick % 7 == 0 ? std::numeric_limits<double>::infinity() : number();
    s.faults = std::uint32_t(random());
    return s;
}

void expectSame(const Sample& a, const Sample& b) {
    EXPECT_EQ(a.tick, b.tick);
    EXPECT_EQ(a.tool, b.tool);
    EXPECT_EQ(a.patient_from_tool.rotation, b.patient_from_tool.rotation);
    EXPECT_EQ(a.patient_from_tool.position_m, b.patient_from_tool.position_m);
    EXPECT_EQ(a.tip_m, b.tip_m);
    EXPECT_EQ(a.axis, b.axis);
    EXPECT_EQ(a.patient_from_probe.rotation, b.patient_from_probe.rotation);
    EXPECT_EQ(a.patient_from_probe.position_m, b.patient_from_probe.position_m);
    EXPECT_EQ(a.needle_in_guide, b.needle_in_guide);
    EXPECT_EQ(a.probe_parked, b.probe_parked);
    EXPECT_EQ(a.breath_held, b.breath_held);
    EXPECT_EQ(a.phase, b.phase);
    EXPECT_EQ(a.tissue, b.tissue);
    EXPECT_EQ(a.label, b.label);
    EXPECT_EQ(a.depth_m, b.depth_m);
    EXPECT_EQ(a.force_n, b.force_n);
    EXPECT_EQ(a.tool_force_n, b.tool_force_n);
    EXPECT_EQ(a.sent_n, b.sent_n);
    EXPECT_EQ(a.extension_m, b.extension_m);
    EXPECT_EQ(a.breath_v, b.breath_v);
    EXPECT_EQ(a.clearance_m, b.clearance_m);
    EXPECT_EQ(a.faults, b.faults);
}

class SamplesFile : public ::testing::Test {
  protected:
    void SetUp() override {
        write([](std::uint64_t tick) { return tick; });
    }
    void write(const std::function<std::uint64_t(std::uint64_t)>& tickOf) {
        SampleWriter writer(folder_.path(), {0xabcdef0123456789ull, 0.0005});
        for (std::uint64_t i = 1; i <= kSampleTicks; ++i)
            writer.add(someSample(tickOf(i)));
        writer.finish();
        bytes_ = readAll(file());
    }
    path file() const { return folder_ / "samples.bin"; }
    test::TempFolder folder_;
    std::vector<unsigned char> bytes_;
};

TEST_F(SamplesFile, EverySampleIsRestored) {
    const Samples samples = loadSamples(folder_.path());
    EXPECT_EQ(samples.header.package_digest, 0xabcdef0123456789ull);
    EXPECT_EQ(samples.header.dt_s, 0.0005);
    EXPECT_EQ(samples.torn_bytes, 0u);
    ASSERT_EQ(samples.samples.size(), kSampleTicks);
    for (std::uint64_t i = 0; i < kSampleTicks; ++i)
        expectSame(samples.samples[i], someSample(i + 1));
}

TEST_F(SamplesFile, AMissingTickBeginsANewFrame) {
    write([](std::uint64_t i) { return i < 100 ? i : i + 5; });
    const Samples samples = loadSamples(folder_.path());
    ASSERT_EQ(samples.samples.size(), kSampleTicks);
    EXPECT_EQ(samples.samples[98].tick, 99u);
    EXPECT_EQ(samples.samples[99].tick, 105u);
    expectSame(samples.samples.back(), someSample(kSampleTicks + 5));
}

// Frames with a correct checksum and invalid contents.
TEST_F(SamplesFile, ReadingStopsAtInvalidFrames) {
    const ParsedHeader head =
        parseFileHeader(bytes_, "s.bin", {{'S', 'T', 'Y', 'L', 'S', 'M', 'P', '\n'}, kSamplesVersion, ""});
    const Frame good = *parseFrame(std::span(bytes_).subspan(head.size));
    std::vector<unsigned char> bad_tool(good.body.begin(), good.body.end());
    bad_tool[0] = haptics::kToolCount;
    const auto samplesWith = [&](const Frame& frame) {
        const path at = folder_ / "made.bin";
        {
            FrameWriter writer(at, std::span(bytes_).first(head.size));
            writer.add(good);
            writer.add(frame);
        }
        return parseSamples(readAll(at), at).samples.size();
    };
    const std::uint64_t n = kFrameTicks;
    EXPECT_EQ(samplesWith({kFrameTicks, n + 1, 2 * n, good.body, 0}), 2 * kFrameTicks);
    EXPECT_EQ(samplesWith({kFrameTicks, n + 1, 2 * n, bad_tool, 0}), kFrameTicks) << "no such tool";
    EXPECT_EQ(samplesWith({kFrameTicks, n, 2 * n - 1, good.body, 0}), kFrameTicks) << "a tick twice";
    EXPECT_EQ(samplesWith({kFrameTicks, n + 1, 3 * n, good.body, 0}), kFrameTicks)
        << "more ticks than samples";
    EXPECT_EQ(samplesWith({kFrameTicks, n + 1, 2 * n, good.body.first(40), 0}), kFrameTicks);
}

TEST(Samples, SampleIsMadeFromATick) {
    haptics::TickOutput now;
    now.tick = 7;
    now.depth_m = 0.03;
    now.patient_from_needle.position_m = {1, 2, 3};
    now.sent_device_n = {0, 0, 4};
    now.breath.v = 0.5;
    const Sample s = makeSample(now, 0.002);
    EXPECT_EQ(s.tick, 7u);
    EXPECT_EQ(s.tip_m, Vec3(1, 2, 3));
    EXPECT_EQ(s.axis, Vec3(0, 0, -1)) << "into the body: away from the hand";
    EXPECT_EQ(s.sent_n, Vec3(0, 0, 4));
    EXPECT_EQ(s.clearance_m, 0.002);
    EXPECT_EQ(s.breath_v, 0.5);
}

}  // namespace
}  // namespace stylet::records
