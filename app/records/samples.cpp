#include "app/records/samples.h"

#include <cmath>

#include "app/records/bytes.h"
#include "app/records/record.h"
#include "patient/package/package.h"

namespace stylet::records {

using haptics::TickOutput;

namespace {

constexpr FileKind kSamplesFile{
    {'S', 'T', 'Y', 'L', 'S', 'M', 'P', '\n'}, kSamplesVersion, "a Stylet file of samples"};
constexpr std::uint32_t kFloats = 2 * 7 + 4 * 3 + 5;
constexpr std::uint32_t kSampleBytes = kFloats * 4 + 3 * 4;
enum Flag : std::uint32_t { kHeld = 1, kGuided = 2, kParked = 4 };

// Visits every number of a sample in a fixed order, for writing and reading.
template <typename AnySample, typename Visit>
void eachSampleNumber(AnySample& s, Visit visit) {
    const auto vector = [&](auto& v) { visit(v.x), visit(v.y), visit(v.z); };
    eachPoseNumber(s.patient_from_tool, visit);
    vector(s.tip_m), vector(s.axis);
    eachPoseNumber(s.patient_from_probe, visit);
    visit(s.depth_m), visit(s.force_n);
    vector(s.tool_force_n), vector(s.sent_n);
    visit(s.extension_m), visit(s.breath_v), visit(s.clearance_m);
}

void writeSample(ByteWriter& sink, const Sample& s) {
    sink.u32(std::uint32_t(s.tool) | std::uint32_t(s.phase) << 8 | std::uint32_t(s.tissue) << 16 |
             std::uint32_t(s.label) << 24);
    sink.u32((s.breath_held ? kHeld : 0u) | (s.needle_in_guide ? kGuided : 0u) |
             (s.probe_parked ? kParked : 0u));
    sink.u32(s.faults);
    eachSampleNumber(s, [&](double v) { sink.f32(float(v)); });
}

// Returns false for an unknown tool, phase or tissue.
bool readSample(ByteReader& source, Sample& s) {
    const std::uint32_t kinds = source.u32(), flags = source.u32();
    s.faults = source.u32();
    eachSampleNumber(s, [&](double& v) { v = double(source.f32()); });
    const std::uint32_t tool = kinds & 0xff, phase = kinds >> 8 & 0xff, tissue = kinds >> 16 & 0xff;
    if (tool >= std::uint32_t(haptics::kToolCount) || phase > std::uint32_t(haptics::Phase::pass) ||
        tissue >= std::uint32_t(patient::kTissueCount) || flags > (kHeld | kGuided | kParked))
        return false;
    s.tool = haptics::Tool(tool);
    s.phase = haptics::Phase(phase);
    s.tissue = haptics::Tissue(tissue);
    s.label = std::uint8_t(kinds >> 24);
    s.breath_held = (flags & kHeld) != 0;
    s.needle_in_guide = (flags & kGuided) != 0;
    s.probe_parked = (flags & kParked) != 0;
    return source.ok();
}

std::vector<unsigned char> encodeSamplesHeader(const SamplesHeader& header) {
    std::vector<unsigned char> body;
    ByteWriter sink(body);
    sink.u64(header.package_digest);
    sink.f64(header.dt_s);
    sink.u32(kSampleBytes);
    return encodeFileHeader(kSamplesFile, body);
}

SamplesHeader decodeSamplesHeader(std::span<const unsigned char> bytes, const std::filesystem::path& file) {
    ByteReader body(bytes);
    const SamplesHeader header{body.u64(), body.f64()};
    const std::uint32_t sample_bytes = body.u32();
    if (!body.ok() || body.remaining() != 0 || sample_bytes != kSampleBytes)
        throw DataError(file, "header", "its size does not fit its version");
    if (!(header.dt_s > 0.0 && header.dt_s <= 1.0))
        throw DataError(file, "dt_s", "must be more than 0 and at most 1");
    return header;
}

bool readSamples(const Frame& frame, std::uint64_t after, std::vector<Sample>& samples) {
    if (frame.first <= after || frame.last - frame.first + 1 != frame.ticks) return false;
    if (frame.body.size() != std::size_t(frame.ticks) * kSampleBytes) return false;
    ByteReader body(frame.body);
    std::vector<Sample> fresh(frame.ticks);
    for (std::size_t i = 0; i < fresh.size(); ++i) {
        if (!readSample(body, fresh[i])) return false;
        fresh[i].tick = frame.first + i;
    }
    samples.insert(samples.end(), fresh.begin(), fresh.end());
    return true;
}

}  // namespace

Sample makeSample(const TickOutput& now, double clearance_m) {
    Sample s;
    s.tick = now.tick;
    s.tool = now.tool;
    s.patient_from_tool = now.patient_from_tool;
    s.tip_m = now.patient_from_needle.position_m;
    s.axis = -now.patient_from_needle.direction({0, 0, 1});
    s.patient_from_probe = now.patient_from_probe;
    s.needle_in_guide = now.needle_in_guide;
    s.probe_parked = now.probe_parked;
    s.breath_held = now.breath_held;
    s.phase = now.phase;
    s.tissue = now.tissue;
    s.label = now.label;
    s.depth_m = now.depth_m;
    s.force_n = now.force_n;
    s.tool_force_n = now.tool_force.force_n;
    s.sent_n = now.sent_device_n;
    s.extension_m = now.extension_m;
    s.breath_v = now.breath.v;
    s.clearance_m = clearance_m;
    s.faults = now.faults;
    return s;
}

bool equalWhenEncoded(const Sample& a, const Sample& b) {
    std::vector<unsigned char> bytes_a, bytes_b;
    ByteWriter sink_a(bytes_a), sink_b(bytes_b);
    writeSample(sink_a, a), writeSample(sink_b, b);
    return a.tick == b.tick && bytes_a == bytes_b;
}

SampleWriter::SampleWriter(const std::filesystem::path& folder, const SamplesHeader& header)
    : file_(folder / "samples.bin", encodeSamplesHeader(header)) {
    syncFolder(folder);
}

void SampleWriter::add(const Sample& sample) {
    if (count_ > 0 && sample.tick != last_ + 1) writeFrame();
    if (count_ == 0) first_ = sample.tick;
    last_ = sample.tick;
    ByteWriter sink(body_);
    writeSample(sink, sample);
    if (++count_ == kFrameTicks) writeFrame();
}

void SampleWriter::writeFrame() {
    file_.add({count_, first_, last_, body_, 0});
    count_ = 0;
    body_.clear();
}

void SampleWriter::finish() {
    if (count_ > 0) writeFrame();
    file_.sync();
}

Samples parseSamples(std::span<const unsigned char> bytes, const std::filesystem::path& file) {
    const ParsedHeader head = parseFileHeader(bytes, file, kSamplesFile);
    Samples samples;
    samples.header = decodeSamplesHeader(head.body, file);
    std::size_t position = head.size;
    std::uint64_t after = 0;
    while (const std::optional<Frame> frame = parseFrame(bytes.subspan(position))) {
        if (!readSamples(*frame, after, samples.samples)) break;
        after = frame->last;
        position += frame->size;
    }
    samples.torn_bytes = bytes.size() - position;
    return samples;
}

Samples loadSamples(const std::filesystem::path& folder) {
    return parseSamples(readAll(folder / "samples.bin"), folder / "samples.bin");
}

}  // namespace stylet::records
