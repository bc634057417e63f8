// The tick-by-tick results of an attempt: samples.bin, stored beside the inputs that produced it. Films,
// curves and measures use these samples; replay.h checks that the inputs reproduce them. README.md
// documents the layout byte by byte; examples/read_attempt.py reads it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "app/records/frames.h"
#include "haptics/loop/simulation.h"
#include "haptics/tools/force_sample.h"

namespace stylet::records {

inline constexpr std::uint32_t kSamplesVersion = 1;

// One tick inside the body.
using haptics::ForceSample;

// In the patient frame, except sent_n. Numbers are stored as 32-bit floats, so positions are accurate to tens
// of nm.
struct Sample {
    std::uint64_t tick = 0;
    haptics::Tool tool = haptics::Tool::needle;  // the active tool
    Pose patient_from_tool;                      // pose of the active tool
    Vec3 tip_m{0.0};                             // needle tip
    Vec3 axis{0.0};                              // needle axis, unit vector into the body
    Pose patient_from_probe;                     // pose of the parked probe
    bool needle_in_guide = false, probe_parked = false, breath_held = false;
    haptics::Phase phase = haptics::Phase::outside;
    haptics::Tissue tissue = haptics::Tissue::air;
    std::uint8_t label = 0;
    double depth_m = 0.0, force_n = 0.0;  // axial, from the model
    Vec3 tool_force_n{0.0};               // from the model, on the active tool
    Vec3 sent_n{0.0};                     // after the output stage, device frame
    double extension_m = 0.0;             // distance of the proxy behind the tip
    double breath_v = 0.0;
    double clearance_m = 0.0;  // needle to the nearest risk structure; infinity outside the body
    std::uint32_t faults = 0;  // haptics fault bits
};

Sample makeSample(const haptics::TickOutput&, double clearance_m);
// Returns true if both samples are stored as the same bits.
bool equalWhenEncoded(const Sample&, const Sample&);

struct SamplesHeader {
    std::uint64_t package_digest = 0;
    double dt_s = 0.001;
};

// Session thread. Like RecordWriter: after a crash the file is complete up to the last frame, after a power
// failure up to the last second. Throws DataError if the disk refuses.
class SampleWriter {
  public:
    SampleWriter(const std::filesystem::path& folder, const SamplesHeader&);  // folder: the attempt's record/
    void add(const Sample&);  // ticks ascend; a missing tick starts a new frame
    void finish();            // writes the current frame; returns when all is on the disk

  private:
    void writeFrame();

    FrameWriter file_;
    std::vector<unsigned char> body_;
    std::uint32_t count_ = 0;
    std::uint64_t first_ = 0, last_ = 0;
};

struct Samples {
    SamplesHeader header;
    std::vector<Sample> samples;   // ticks ascend
    std::uint64_t torn_bytes = 0;  // bytes behind the last whole frame; ignored
};

// Throws DataError for a bad header or version. Ignores a torn tail behind the last whole frame.
Samples loadSamples(const std::filesystem::path& folder);
// Parses the file's contents. `file` is used in error messages.
Samples parseSamples(std::span<const unsigned char> bytes, const std::filesystem::path& file);

}  // namespace stylet::records
