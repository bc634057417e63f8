// What an attempt was, tick by tick: samples.bin, beside the inputs that computed it. A film of the attempt,
// its curves and its measures play these; that they are what the inputs give is checked by replay.h.
// README.md has the layout byte by byte; examples/read_attempt.py reads it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "app/records/frames.h"
#include "haptics/simulation.h"

namespace stylet::records {

inline constexpr std::uint32_t kSamplesVersion = 1;

// Patient frame but for sent_n. Numbers are kept as 32-bit floats: a position to some nanometres.
struct Sample {
    std::uint64_t tick = 0;
    haptics::Tool tool = haptics::Tool::needle;  // in hand
    patient::Pose patient_from_tool;             // of it
    patient::Vec3 tip_m{0.0};                    // of the needle
    patient::Vec3 axis{0.0};                     // of the needle, unit, into the body
    patient::Pose patient_from_probe;            // of the parked one
    bool needle_in_guide = false, probe_parked = false, breath_held = false;
    haptics::Phase phase = haptics::Phase::outside;
    haptics::Tissue tissue = haptics::Tissue::air;
    std::uint8_t label = 0;
    double depth_m = 0.0, force_n = 0.0;  // axial, model
    patient::Vec3 tool_force_n{0.0};      // of the model on the tool in hand
    patient::Vec3 sent_n{0.0};            // after the output stage, device frame
    double extension_m = 0.0;             // proxy behind tip
    double breath_v = 0.0;
    double clearance_m = 0.0;  // needle to the nearest risk structure; infinity outside the body
    std::uint32_t faults = 0;  // haptics fault bits
};

Sample sampleOf(const haptics::TickOutput&, double clearance_m);
// To the bit that a file keeps.
bool sameInFile(const Sample&, const Sample&);

struct SamplesHeader {
    std::uint64_t package_digest = 0;
    double dt_s = 0.001;
};

// Session thread. As RecordWriter: after a kill the file is whole up to the last frame, after a power loss up
// to the last second. Throws patient::DataError when the disk refuses.
class SampleWriter {
  public:
    SampleWriter(const std::filesystem::path& folder, const SamplesHeader&);  // folder: the attempt's record/
    void add(const Sample&);  // ticks ascend; where one is missing a new frame begins
    void finish();            // writes the frame in progress; all of it is on the disk then

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
    std::uint64_t torn_bytes = 0;  // behind the last whole frame: left out
};

// Refuses a bad header or version with a DataError; a torn tail is cut at the last whole frame.
Samples loadSamples(const std::filesystem::path& folder);
// The same from the file's contents; `file` is named when they are refused.
Samples parseSamples(std::span<const unsigned char> bytes, const std::filesystem::path& file);

}  // namespace stylet::records
