#include "app/records/record.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "app/records/bytes.h"
#include "base/fields.h"
#include "base/hex.h"
#include "base/path.h"
#include "base/whole_file.h"

namespace stylet::records {

using haptics::TickInput;
using json = nlohmann::ordered_json;

namespace {

constexpr FileKind kInputsFile{{'S', 'T', 'Y', 'L', 'R', 'E', 'C', '\n'}, kRecordVersion, "a Stylet record"};
constexpr std::size_t kMaxCapturePoints = 1000, kMaxInfoBytes = 1 << 30;
constexpr std::size_t kBeginningBytes = (1u << 20) + 64;  // a prologue, and the largest header
constexpr std::uint32_t kMaxPadPoints = 1 << 10;          // more than any touch pad has

// Visits every value of a tick in a fixed order, for writing and reading. Calls `number` for a double and
// `word` for a 32-bit integer.
template <typename AnyInput, typename Number, typename Word>
void eachTickValue(AnyInput& input, const Number& number, const Word& word) {
    auto& device = input.device;
    eachPoseNumber(device.device_from_stylus, number);
    word(device.buttons), word(device.fresh), word(device.flags);
    if ((device.flags & haptics::kDeviceClutch) != 0) {
        number(device.grip_at_m.x), number(device.grip_at_m.y), number(device.grip_at_m.z);
        number(device.force_share);
    }
    word(input.command_count);
    if (input.command_count > haptics::kMaxCommandsPerTick) return;
    for (std::uint32_t i = 0; i < input.command_count; ++i)
        word(input.commands[i].kind), word(input.commands[i].value);
}

void writeTick(ByteWriter& sink, const TickInput& input) {
    eachTickValue(input, [&](double v) { sink.f64(v); }, [&](auto v) { sink.u32(std::uint32_t(v)); });
}

// Returns false for an invalid count or kind.
bool readTick(ByteReader& source, TickInput& input) {
    eachTickValue(
        input, [&](double& v) { v = source.f64(); },
        [&](auto& v) { v = std::remove_cvref_t<decltype(v)>(source.u32()); });
    if (!source.ok() || input.command_count > haptics::kMaxCommandsPerTick) return false;
    return std::all_of(input.commands.begin(), input.commands.begin() + input.command_count,
                       [](const haptics::Command& c) { return c.kind <= haptics::kLastCommandKind; });
}

// Visits every number of the settings in a fixed order, for writing and reading.
template <typename Settings, typename Visit>
void eachSettingsNumber(Settings& s, Visit visit) {
    visit(s.dt_s);
    static_assert(sizeof s.output == 4 * sizeof(double),
                  "a new setting needs a place here and a new kRecordVersion");
    haptics::visitToolNumbers(s.tools, visit);
    haptics::visitAccessNumbers(s.tools.access, visit);
    visit(s.output.rate_limit_n_per_s), visit(s.output.model_force_n), visit(s.output.model_tangent_n_per_m);
    visit(s.output.controller_share);
    visit(s.profile.force_peak_n), visit(s.profile.stiffness_n_per_m);
    visit(s.profile.mass_kg), visit(s.profile.delay_s), visit(s.profile.workspace_radius_m);
    for (int i = 0; i < 3; ++i)
        visit(s.profile.workspace_centre_m[i]);
}

template <typename Plan, typename Visit>
void eachBreathNumber(Plan& p, Visit visit) {
    static_assert(sizeof p.rhythm == 2 * sizeof(double) && sizeof p.hold == 5 * sizeof(double),
                  "a new number needs a place here and a new kRecordVersion");
    visit(p.rhythm.period_s), visit(p.rhythm.amplitude);
    visit(p.period_jitter), visit(p.depth_jitter), visit(p.sighs), visit(p.coughs);
    visit(p.hold.creep_v), visit(p.hold.creep_s), visit(p.hold.missed), visit(p.hold.level_v),
        visit(p.hold.limit_s);
    visit(p.recording_dt_s);
}

void writeBreath(ByteWriter& sink, const std::optional<patient::BreathPlan>& breath) {
    sink.u32(breath.has_value());
    if (!breath) return;
    sink.u64(breath->seed);
    eachBreathNumber(*breath, [&](double v) { sink.f64(v); });
    sink.u64(breath->recording_v.size());
    for (const double v : breath->recording_v)
        sink.f64(v);
}

// Returns false if the breath does not fit into the rest of the header.
bool readBreath(ByteReader& source, std::optional<patient::BreathPlan>& breath) {
    const std::uint32_t there = source.u32();
    if (there == 0) return source.ok();
    breath.emplace();
    breath->seed = source.u64();
    eachBreathNumber(*breath, [&](double& v) { v = source.f64(); });
    const std::uint64_t samples = source.u64();
    if (there != 1 || samples > source.remaining() / sizeof(double)) return false;
    breath->recording_v.resize(samples);
    for (double& v : breath->recording_v)
        v = source.f64();
    return source.ok() && patient::isValidPlan(*breath);
}

// Names and titles are short; a longer one is damaged.
constexpr std::uint32_t kMaxInstrumentTextBytes = 256;

void writeText(ByteWriter& sink, const std::string& text) {
    sink.u32(static_cast<std::uint32_t>(text.size()));
    for (const char c : text)
        sink.u8(static_cast<unsigned char>(c));
}

// Returns false if the text is longer than kMaxInstrumentTextBytes.
bool readText(ByteReader& source, std::string& text) {
    const std::uint32_t size = source.u32();
    if (size > kMaxInstrumentTextBytes) return false;
    text.clear();
    for (std::uint32_t i = 0; i < size; ++i)
        text.push_back(static_cast<char>(source.u8()));
    return source.ok();
}

void writeShape(ByteWriter& sink, const haptics::Instrument& needle) {
    sink.u32(static_cast<std::uint32_t>(needle.gauge));
    sink.u32(static_cast<std::uint32_t>(needle.shape.tip));
    sink.u32(needle.shape.has_stylet);
    visitShapeNumbers(needle.shape, [&](double v) { sink.f64(v); });
}

// Reason why this version wrote no needle of this shape, or an empty string.
std::string readShape(ByteReader& source, haptics::Instrument& needle) {
    needle.gauge = static_cast<int>(source.u32());
    const std::uint32_t tip = source.u32();
    if (!haptics::isNeedleTip(tip)) return "its tip is unknown";
    needle.shape.tip = static_cast<NeedleTip>(tip);
    needle.shape.has_stylet = source.u32() != 0;
    visitShapeNumbers(needle.shape, [&](double& v) { v = source.f64(); });
    if (needle.kind != haptics::InstrumentKind::needle) return {};
    if (!haptics::isGauge(needle.gauge)) return "its gauge is out of range";
    return haptics::shapeError(needle.shape);
}

void writeInstrument(ByteWriter& sink, const RecordHeader& header, const haptics::Instrument& one) {
    writeText(sink, one.name);
    writeText(sink, one.title);
    if (haptics::hasShape(one.kind)) writeShape(sink, one);
    if (one.kind == haptics::InstrumentKind::probe) writeText(sink, one.transducer);
    sink.u64(instrumentDigest(header, one));
}

// Reads one of the header's instruments. Reason why it is not one that this version wrote, or an empty
// string.
std::string readInstrument(ByteReader& source, const RecordHeader& header, haptics::Instrument& one) {
    if (!readText(source, one.name) || !readText(source, one.title)) return "its name does not end";
    if (haptics::hasShape(one.kind))
        if (std::string why = readShape(source, one); !why.empty()) return why;
    if (one.kind == haptics::InstrumentKind::needle) {
        if (!haptics::isFrictionScale(header.settings.tools.needle.friction_scale))
            return "its friction scale is out of range";
    }
    if (one.kind == haptics::InstrumentKind::probe && !readText(source, one.transducer))
        return "the name of its transducer does not end";
    one = haptics::withToolForce(std::move(one), header.settings.tools);
    return source.u64() == haptics::digest(one) ? "" : "its numbers do not match its digest";
}

void readInstruments(ByteReader& source, const std::filesystem::path& file, RecordHeader& header) {
    header.instruments = {};
    visitInstruments(header.instruments, [&](haptics::Instrument& one) {
        const std::string_view kind = enumName(haptics::kInstrumentKindNames, one.kind);
        if (const std::string why = readInstrument(source, header, one); !why.empty())
            throw DataError(file, "header: " + std::string(kind), why);
    });
}

std::vector<unsigned char> encodeHeader(const RecordHeader& header) {
    std::vector<unsigned char> body;
    ByteWriter sink(body);
    sink.u64(header.package_digest);
    sink.u64(header.settings.scenario_digest);
    sink.u64(header.settings.seed);
    sink.u32(static_cast<std::uint32_t>(header.settings.tools.first));
    haptics::visitToolCounts(header.settings.tools, [&](int v) { sink.u32(static_cast<std::uint32_t>(v)); });
    eachSettingsNumber(header.settings, [&](double v) { sink.f64(v); });
    eachPoseNumber(header.settings.patient_from_device, [&](double v) { sink.f64(v); });
    visitInstruments(header.instruments,
                     [&](const haptics::Instrument& one) { writeInstrument(sink, header, one); });
    writeBreath(sink, header.settings.breath);
    return encodeFileHeader(kInputsFile, body);
}

// Fills `header` and returns the offset of the first frame.
std::size_t decodeHeader(std::span<const unsigned char> bytes, const std::filesystem::path& file,
                         RecordHeader& header) {
    const ParsedHeader head = parseFileHeader(bytes, file, kInputsFile);
    ByteReader body(head.body);
    header.package_digest = body.u64();
    header.settings.scenario_digest = body.u64();
    header.settings.seed = body.u64();
    const std::uint32_t first = body.u32();
    header.settings.tools.first = static_cast<haptics::Tool>(first);
    haptics::visitToolCounts(header.settings.tools,
                             [&](int& v) { v = static_cast<int>(std::min(body.u32(), kMaxPadPoints)); });
    eachSettingsNumber(header.settings, [&](double& v) { v = body.f64(); });
    eachPoseNumber(header.settings.patient_from_device, [&](double& v) { v = body.f64(); });
    readInstruments(body, file, header);
    const bool breathes = readBreath(body, header.settings.breath);
    header.settings.profile.name = "as recorded";
    header.settings.profile.source = "record";
    if (!body.ok() || !breathes || body.remaining() != 0 || first >= std::uint32_t(haptics::kToolCount))
        throw DataError(file, "header", "its size, tool or breath does not fit its version");
    if (!haptics::arePadsValid(header.settings.tools))
        throw DataError(file, "header", "no pad of finger or probe has so many points");
    if (!(std::isfinite(header.settings.dt_s) && header.settings.dt_s > 0.0))
        throw DataError(file, "header: dt_s", "must be finite and more than 0");
    return head.size;
}

// Decodes one frame at the start of `bytes` and sets `used` to its size. Returns false if it is not whole.
bool decodeFrame(std::span<const unsigned char> bytes, Record& record, std::size_t& used) {
    const std::optional<Frame> frame = parseFrame(bytes);
    if (!frame || frame->first != record.inputs.size()) return false;
    ByteReader body(frame->body);
    std::vector<TickInput> ticks(frame->ticks);
    for (TickInput& tick : ticks)
        if (!readTick(body, tick)) return false;
    if (body.remaining() != 0) return false;
    record.inputs.insert(record.inputs.end(), ticks.begin(), ticks.end());
    record.checkpoints.push_back({record.inputs.size(), frame->last});
    used = frame->size;
    return true;
}

// The instruments of record.json.
struct InstrumentName {
    const char* kind;
    std::string RecordInfo::* name;
    haptics::Instrument haptics::InstrumentSet::* instrument;
};
using haptics::InstrumentSet;
constexpr InstrumentName kInstrumentNames[]{{"needle", &RecordInfo::needle, &InstrumentSet::needle},
                                            {"scalpel", &RecordInfo::scalpel, &InstrumentSet::scalpel},
                                            {"probe", &RecordInfo::probe, &InstrumentSet::probe},
                                            {"finger", &RecordInfo::finger, &InstrumentSet::finger},
                                            {"wire", &RecordInfo::wire, &InstrumentSet::wire},
                                            {"dilator", &RecordInfo::dilator, &InstrumentSet::dilator},
                                            {"drain", &RecordInfo::drain, &InstrumentSet::drain}};

json vectorJson(const Vec3& v) {
    return json::array({v.x, v.y, v.z});
}

json infoJson(const RecordInfo& info) {
    json j;
    j["format_version"] = kRecordVersion;
    j["program_version"] = info.program_version;
    j["id"] = info.id;
    j["trainee"] = info.trainee;
    j["started_utc"] = info.started_utc;
    j["device"] = info.device;
    j["firmware_sha256"] = info.firmware_sha256;
    j["clock"] = info.clock;
    j["difficulty"] = info.difficulty;
    j["course"] = info.course;
    if (!info.patient_case.empty()) j["case"] = info.patient_case;
    if (info.registration_rms_m) j["registration_rms_m"] = *info.registration_rms_m;
    j["patient"] = {{"folder", info.patient_folder.string()}, {"name", info.patient_name}};
    if (!info.patient_check.empty()) j["patient"]["check"] = info.patient_check;
    j["scenario"] = info.scenario;
    for (const InstrumentName& one : kInstrumentNames)
        j["instruments"][one.kind] = info.*one.name;
    j["moments"] = info.capture_points;
    j["approach_distance_m"] = info.approach_distance_m;
    j["seed"] = info.seed;
    j["gain"] = info.gain;
    const patient::PlannedPath& p = info.path;
    j["path"] = {{"entry_m", vectorJson(p.entry_m)},
                 {"target_m", vectorJson(p.target_m)},
                 {"entry_reference_m", vectorJson(p.entry_reference_m)},
                 {"target_reference_m", vectorJson(p.target_reference_m)},
                 {"breath_v", p.breath.v},
                 {"breath_rate_per_s", p.breath.rate_per_s},
                 {"length_m", p.length_m},
                 {"quality", p.quality}};
    for (const Bookmark& mark : info.bookmarks)
        j["bookmarks"].push_back({{"tick", mark.tick}, {"text", mark.text}});
    j["events"] = eventsJson(info.events);
    if (info.end) {
        j["final_tick"] = info.end->tick;
        j["state_hash"] = hexText(info.end->state_hash);
    }
    if (info.lost) j["lost_ticks"] = {{"first", info.lost->first}, {"last", info.lost->last}};
    if (info.result) j["result"] = resultJson(*info.result);
    return j;
}

// Shortens the text at a UTF-8 character boundary.
std::string truncated(const std::string& text) {
    std::size_t size = std::min(text.size(), kMaxBookmarkBytes);
    while (size > 0 && size < text.size() && (static_cast<unsigned char>(text[size]) & 0xc0u) == 0x80u)
        --size;
    return text.substr(0, size);
}

// The names are in both files: for people, and with the instruments' numbers.
void checkInstruments(const Record& record, const std::filesystem::path& folder) {
    for (const InstrumentName& one : kInstrumentNames) {
        const std::string &shown = record.info.*one.name,
                          &used = (record.header.instruments.*one.instrument).name;
        if (shown != used)
            throw DataError(folder / "record.json", std::string("instruments: ") + one.kind,
                            "\"" + shown + "\" is not the " + one.kind + " of inputs.bin, \"" + used + "\"");
    }
}

void checkVersion(Fields& in) {
    constexpr std::int64_t kAnyVersion = 1 << 30;
    const std::int64_t version = in.integer("format_version", 0, kAnyVersion);
    if (version != kRecordVersion)
        in.refuse(
            "format_version",
            fmt::format(
                "{} is not {}: the record was written by {} program version; use that version to read it",
                version, kRecordVersion, version < kRecordVersion ? "an older" : "a newer"));
}

std::vector<Bookmark> parseBookmarks(Fields& in) {
    std::vector<Bookmark> marks;
    for (Fields& one : in.childrenOrNone("bookmarks", kMaxBookmarks)) {
        // An invalid byte is replaced by three.
        marks.push_back({one.count("tick"), one.text("text", 3 * kMaxBookmarkBytes)});
        one.finish();
        if (marks.size() > 1 && marks.back().tick < marks[marks.size() - 2].tick)
            one.refuse("tick", "before that of the previous bookmark");
    }
    return marks;
}

patient::PlannedPath parsePath(Fields in) {
    patient::PlannedPath path;
    path.entry_m = in.vector("entry_m");
    path.target_m = in.vector("target_m");
    path.entry_reference_m = in.vector("entry_reference_m");
    path.target_reference_m = in.vector("target_reference_m");
    path.breath = {in.number("breath_v"), in.number("breath_rate_per_s")};
    path.length_m = in.number("length_m");
    path.quality = in.number("quality");
    in.finish();
    return path;
}

void writeInfo(const RecordInfo& info, const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "record.json", part = folder / "record.json.part";
    {
        // A path may not be valid UTF-8. Replacing its invalid bytes is better than losing the record.
        const std::string text = infoJson(info).dump(2, ' ', false, json::error_handler_t::replace) + '\n';
        DiskFile stream(part);
        stream.write({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
        stream.sync();
    }
    std::filesystem::rename(part, file);
    syncFolder(folder);
}

RecordInfo readInfo(const std::filesystem::path& folder) {
    return parseInfo(readWholeFile(folder / "record.json", kMaxInfoBytes), folder / "record.json");
}

// The bytes of the header, and some of what follows.
std::vector<unsigned char> readBeginning(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw DataError(file, "file", "cannot be read");
    std::vector<unsigned char> bytes(kBeginningBytes);
    stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    bytes.resize(std::size_t(stream.gcount()));
    return bytes;
}

Record loadHead(const std::filesystem::path& record_folder) {
    const std::filesystem::path inputs = record_folder / "inputs.bin";
    Record record;
    record.info = readInfo(record_folder);
    decodeHeader(readBeginning(inputs), inputs, record.header);
    checkInstruments(record, record_folder);
    return record;
}

// Creates the folder and removes an earlier record from it. record.json is removed first, so that a crash
// cannot leave it beside new inputs.
std::filesystem::path createEmptyFolder(const std::filesystem::path& folder) {
    const std::filesystem::path place = std::filesystem::absolute(folder);
    createPrivateFolders(place);
    std::filesystem::remove(place / "record.json");
    syncFolder(place);
    syncFolder(place.parent_path());
    return place;
}

}  // namespace

std::uint64_t instrumentDigest(const RecordHeader& header, const haptics::Instrument& one) {
    return haptics::digest(haptics::withToolForce(one, header.settings.tools));
}

RecordWriter::RecordWriter(const std::filesystem::path& folder, const RecordHeader& header,
                           const RecordInfo& info)
    : folder_(createEmptyFolder(folder)), info_(info), inputs_(folder_ / "inputs.bin", encodeHeader(header)) {
    for (const InstrumentName& one : kInstrumentNames)
        info_.*one.name = (header.instruments.*one.instrument).name;
    info_.end.reset();
    info_.lost.reset();
    info_.result.reset();
    writeInfo(info_, folder_);
}

void RecordWriter::add(const TickInput& input, std::uint64_t tick, std::uint64_t state_hash) {
    if (ended_) return;
    if (tick != last_.tick + 1) {
        info_.lost = LostTicks{last_.tick + 1, tick - 1};
        finish();
        return;
    }
    ByteWriter sink(frame_);
    writeTick(sink, input);
    last_ = {tick, state_hash};
    if (++frame_count_ == kFrameTicks) writeFrame();
}

void RecordWriter::bookmark(Bookmark mark) {
    if (ended_ || info_.bookmarks.size() >= kMaxBookmarks) return;
    mark.text = truncated(mark.text);
    // A retry can set a mark while it recomputes ticks before the marks that it inherited.
    const auto after =
        std::upper_bound(info_.bookmarks.begin(), info_.bookmarks.end(), mark.tick,
                         [](std::uint64_t tick, const Bookmark& other) { return tick < other.tick; });
    info_.bookmarks.insert(after, std::move(mark));
    writeInfo(info_, folder_);
}

void RecordWriter::writeFrame() {
    inputs_.add({frame_count_, ticks_, last_.state_hash, frame_, 0});
    ticks_ += frame_count_;
    frame_count_ = 0;
    frame_.clear();
}

void RecordWriter::addEvents(const std::vector<EventRow>& events) {
    if (events.empty()) return;
    info_.events.insert(info_.events.end(), events.begin(), events.end());
    writeInfo(info_, folder_);
}

void RecordWriter::endInputs() {
    ended_ = true;
    if (frame_count_ > 0) writeFrame();
    inputs_.sync();
    info_.end = last_;
}

void RecordWriter::finish() {
    if (ended_) return;
    endInputs();
    writeInfo(info_, folder_);
}

void RecordWriter::finish(const AttemptResult& result) {
    if (!ended_) endInputs();
    info_.result = result;
    writeInfo(info_, folder_);
}

void parseInputs(std::span<const unsigned char> bytes, const std::filesystem::path& file, Record& record) {
    std::size_t position = decodeHeader(bytes, file, record.header);
    std::size_t used = 0;
    while (position < bytes.size() && decodeFrame(bytes.subspan(position), record, used))
        position += used;
    record.torn_bytes = bytes.size() - position;
}

RecordInfo parseInfo(std::string_view text, const std::filesystem::path& file) {
    Fields in = parseJson(file, text);
    checkVersion(in);
    RecordInfo info;
    info.program_version = in.text("program_version");
    info.id = in.text("id");
    info.trainee = in.text("trainee");
    info.started_utc = in.text("started_utc");
    info.device = in.text("device");
    info.firmware_sha256 = in.text("firmware_sha256");
    info.clock = in.text("clock");
    info.difficulty = in.text("difficulty");
    info.course = in.text("course");
    info.patient_case = in.textOr("case", "");
    if (in.has("registration_rms_m")) info.registration_rms_m = in.number("registration_rms_m", 0.0);
    Fields patient = in.child("patient");
    info.patient_folder = patient.text("folder");
    info.patient_name = patient.text("name");
    info.patient_check = patient.textOr("check", "");
    patient.finish();
    info.scenario = in.text("scenario");
    Fields instruments = in.child("instruments");
    for (const InstrumentName& one : kInstrumentNames)
        info.*one.name = instruments.text(one.kind);
    instruments.finish();
    info.capture_points = in.texts("moments", kMaxCapturePoints);
    info.approach_distance_m = in.number("approach_distance_m");
    info.seed = in.count("seed");
    info.gain = in.number("gain");
    info.path = parsePath(in.child("path"));
    info.bookmarks = parseBookmarks(in);
    info.events = parseEvents(in, "events");
    if (in.has("state_hash")) info.end = RecordEnd{in.count("final_tick"), in.hex("state_hash")};
    if (in.has("lost_ticks")) {
        Fields lost = in.child("lost_ticks");
        info.lost = LostTicks{lost.count("first"), lost.count("last")};
        lost.finish();
    }
    if (in.has("result")) info.result = parseResult(in.child("result"));
    in.finish();
    return info;
}

std::filesystem::path recordFolder(const std::filesystem::path& folder) {
    const std::filesystem::path name = withoutSlash(folder);
    if (name.filename() == "record" && std::filesystem::exists(folder / "record.json")) return folder;
    return std::filesystem::exists(folder / "record" / "record.json") ? folder / "record" : folder;
}

Record loadRecord(const std::filesystem::path& folder) {
    const std::filesystem::path place = recordFolder(folder);
    Record record;
    record.info = readInfo(place);
    parseInputs(readAll(place / "inputs.bin"), place / "inputs.bin", record);
    checkInstruments(record, place);
    return record;
}

Record loadRecordHead(const std::filesystem::path& folder) {
    return loadHead(recordFolder(folder));
}

Record loadAttemptHead(const std::filesystem::path& attempt_folder) {
    return loadHead(attempt_folder / "record");
}

}  // namespace stylet::records
