#include "app/records/record.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <bit>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/app/records/some_result.h"
#include "tests/support/file_text.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::records {
namespace {

using haptics::TickInput;
using haptics::TickOutput;
using std::filesystem::path;

constexpr std::size_t kRecordTicks = 2 * kFrameTicks + 17;

RecordHeader someHeader() {
    RecordHeader header;
    header.package_digest = 0x0123456789abcdefull;
    header.settings.scenario_digest = 0xfedcba9876543210ull;
    header.settings.seed = 42;
    header.settings.patient_from_device.position_m = {0.1, -0.2, 0.3};
    header.settings.tools.first = haptics::Tool::probe;
    header.settings.tools.needle.max_force_n = 19.5;
    header.settings.tools.guide.release_n = 4.25;
    header.instruments.needle.name = "chiba-22g";
    header.instruments.needle.title = "a thin needle";
    header.instruments.needle.gauge = 22;
    header.instruments.needle.shape.outer_m = 0.00072, header.instruments.needle.shape.inner_m = 0.00041;
    header.instruments.needle.shape.tip = NeedleTip::trocar;
    header.instruments.needle.shape.has_stylet = false;
    header.settings.tools.needle.friction_scale = 0.48;
    header.instruments.probe.name = "my-probe";
    header.instruments.probe.transducer = "some-array";
    header.settings.tools.probe.length_m = 0.04;
    header.settings.profile.force_peak_n = 8.5;
    patient::BreathPlan& breath = header.settings.breath.emplace();
    breath.rhythm = {5.5, 0.9};
    breath.hold = {-0.3, 20.0, 0.1, 0.05, 12.0};
    breath.sighs = 0.02, breath.coughs = 0.01, breath.period_jitter = 0.1, breath.depth_jitter = 0.15;
    breath.seed = 9;
    breath.recording_dt_s = 0.125;
    breath.recording_v = {0.0, 0.25, 0.5, 0.1};
    return header;
}

std::vector<std::uint64_t> digests(const RecordHeader& header) {
    std::vector<std::uint64_t> found;
    visitInstruments(header.instruments,
                     [&](const haptics::Instrument& one) { found.push_back(instrumentDigest(header, one)); });
    return found;
}

RecordInfo someRecordInfo() {
    RecordInfo info;
    info.program_version = "1.2.3";
    info.patient_folder = "/somewhere/patient";
    info.patient_name = "someone";
    info.patient_check = "overruled: liver volume";
    info.patient_case = "title = \"x\"\n";
    info.scenario = "demo";
    info.needle = "chiba-22g";
    info.capture_points = {"approach", "duct"};
    info.approach_distance_m = 0.02;
    info.seed = 42;
    info.gain = 0.25;
    info.path.entry_m = {0.1, 0.2, 0.3};
    info.path.target_m = {-0.1, 1.0 / 3.0, 0.0};
    info.path.length_m = 0.2;
    return info;
}

// Values with arbitrary bit patterns: the record must preserve every double bit for bit.
TickInput someInput(std::uint64_t i) {
    std::mt19937_64 bits(i);
    TickInput input;
    input.device.device_from_stylus.rotation.w = std::bit_cast<double>(bits());
    input.device.device_from_stylus.position_m = {std::bit_cast<double>(bits()), -0.0, double(i)};
    input.device.buttons = std::uint32_t(bits());
    input.device.fresh = i % 3 != 0;
    input.device.flags = std::uint32_t(bits());
    if ((input.device.flags & haptics::kDeviceClutch) != 0) {
        input.device.grip_at_m = {double(i), std::bit_cast<double>(bits()), -0.0};
        input.device.force_share = std::bit_cast<double>(bits());
    }
    if (i % 100 == 5) {
        input.command_count = 3;
        input.commands[0] = {haptics::CommandKind::holdBreath, 0};
        input.commands[1] = {haptics::CommandKind::marker, std::uint32_t(i)};
        input.commands[2] = {haptics::kLastCommandKind, 1};
    }
    return input;
}

TickOutput outputOf(std::uint64_t i) {
    TickOutput output;
    output.tick = i + 1;
    output.state_hash = 0x9e3779b97f4a7c15ull * (i + 1);
    return output;
}

void addTo(RecordWriter& writer, const TickInput& input, const TickOutput& output) {
    writer.add(input, output.tick, output.state_hash);
}

void addTicks(RecordWriter& writer, std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i)
        addTo(writer, someInput(i), outputOf(i));
}

void expectSameBits(const TickInput& a, const TickInput& b) {
    const auto bits = [](double v) { return std::bit_cast<std::uint64_t>(v); };
    const auto &p = a.device.device_from_stylus, &q = b.device.device_from_stylus;
    for (int k = 0; k < 3; ++k)
        EXPECT_EQ(bits(p.position_m[k]), bits(q.position_m[k]));
    for (int k = 0; k < 4; ++k)
        EXPECT_EQ(bits(p.rotation[k]), bits(q.rotation[k]));
    EXPECT_EQ(a.device.buttons, b.device.buttons);
    EXPECT_EQ(a.device.fresh, b.device.fresh);
    EXPECT_EQ(a.device.flags, b.device.flags);
    for (int k = 0; k < 3; ++k)
        EXPECT_EQ(bits(a.device.grip_at_m[k]), bits(b.device.grip_at_m[k]));
    EXPECT_EQ(bits(a.device.force_share), bits(b.device.force_share));
    ASSERT_EQ(a.command_count, b.command_count);
    for (std::uint32_t c = 0; c < a.command_count; ++c) {
        EXPECT_EQ(a.commands[c].kind, b.commands[c].kind);
        EXPECT_EQ(a.commands[c].value, b.commands[c].value);
    }
}

class RecordFile : public testing::Test {
  protected:
    void SetUp() override {
        RecordWriter writer(folder_, someHeader(), someRecordInfo());
        addTicks(writer, 0, kRecordTicks);
        writer.finish();
    }

    test::TempFolder temp_;
    path folder_ = temp_ / "record", inputs_ = folder_ / "inputs.bin";
};

TEST_F(RecordFile, RestoresEveryBit) {
    const Record record = loadRecord(folder_);
    EXPECT_EQ(record.torn_bytes, 0u);
    EXPECT_EQ(record.header.package_digest, someHeader().package_digest);
    EXPECT_EQ(record.header.settings.scenario_digest, someHeader().settings.scenario_digest);
    EXPECT_EQ(record.header.settings.seed, 42u);
    EXPECT_EQ(record.header.settings.patient_from_device.position_m.z, 0.3);
    EXPECT_EQ(record.header.settings.tools.first, haptics::Tool::probe);
    EXPECT_EQ(record.header.settings.tools.needle.max_force_n, 19.5);
    EXPECT_EQ(record.header.settings.tools.guide.release_n, 4.25);
    EXPECT_EQ(record.header.settings.tools.needle.friction_scale, 0.48);
    EXPECT_EQ(record.header.instruments.needle.name, "chiba-22g");
    EXPECT_EQ(record.header.instruments.needle.title, "a thin needle");
    EXPECT_EQ(record.header.instruments.needle.gauge, 22);
    EXPECT_EQ(record.header.instruments.needle.shape, someHeader().instruments.needle.shape);
    EXPECT_EQ(digests(record.header), digests(someHeader()));
    EXPECT_EQ(std::get<haptics::NeedleSettings>(record.header.instruments.needle.force).max_force_n, 19.5);
    EXPECT_EQ(digests(loadRecordHead(folder_).header), digests(someHeader()));
    EXPECT_EQ(record.header.instruments.probe.transducer, "some-array");
    EXPECT_EQ(std::get<haptics::ProbeSettings>(record.header.instruments.probe.force).length_m, 0.04);
    EXPECT_EQ(record.info.needle, "chiba-22g");
    EXPECT_EQ(record.info.scalpel, "scalpel");
    EXPECT_EQ(record.info.probe, "my-probe");
    EXPECT_EQ(record.info.finger, "finger");
    EXPECT_EQ(record.header.settings.profile.force_peak_n, 8.5);
    EXPECT_EQ(record.header.settings.breath, someHeader().settings.breath);
    ASSERT_EQ(record.inputs.size(), kRecordTicks);
    for (std::uint64_t i = 0; i < kRecordTicks; ++i)
        expectSameBits(record.inputs[i], someInput(i));
    ASSERT_EQ(record.checkpoints.size(), 3u);
    EXPECT_EQ(record.checkpoints[1].ticks, 2 * kFrameTicks);
    EXPECT_EQ(record.checkpoints[1].state_hash, outputOf(2 * kFrameTicks - 1).state_hash);
    ASSERT_TRUE(record.info.end);
    EXPECT_EQ(record.info.end->tick, kRecordTicks);
    EXPECT_EQ(record.info.end->state_hash, outputOf(kRecordTicks - 1).state_hash);
    EXPECT_EQ(record.info.patient_folder, someRecordInfo().patient_folder);
    EXPECT_EQ(record.info.patient_check, someRecordInfo().patient_check);
    EXPECT_EQ(record.info.patient_case, someRecordInfo().patient_case);
    EXPECT_EQ(record.info.capture_points, someRecordInfo().capture_points);
    EXPECT_EQ(record.info.path.target_m, someRecordInfo().path.target_m);
    EXPECT_EQ(record.info.gain, 0.25);
}

// A damaged needle is refused even if the header's checksum was computed again.
TEST_F(RecordFile, AnotherNeedleInTheHeaderIsRefused) {
    constexpr FileKind kKind{{'S', 'T', 'Y', 'L', 'R', 'E', 'C', '\n'}, kRecordVersion, "a Stylet record"};
    const std::vector<unsigned char> good = readAll(inputs_);
    const ParsedHeader head = parseFileHeader(good, inputs_, kKind);
    const std::string body(head.body.begin(), head.body.end());
    const auto refusal = [&](const std::string& changed) {
        std::vector<unsigned char> bytes =
            encodeFileHeader(kKind, {reinterpret_cast<const unsigned char*>(changed.data()), changed.size()});
        Record record;
        return test::errorText([&] { parseInputs(bytes, inputs_, record); });
    };
    EXPECT_EQ(refusal(body), "");
    const std::size_t name = body.find("chiba-22g");
    ASSERT_NE(name, std::string::npos);
    std::string other = body;
    other[name + 6] = '3';
    EXPECT_NE(refusal(other).find("needle: its numbers do not match its digest"), std::string::npos);
    other = body;
    other[name - 1] = '\x7f';  // the length of its name, 2 GB
    EXPECT_NE(refusal(other).find("needle: its name does not end"), std::string::npos);
    const std::size_t tip = name + 9 + 4 + std::string("a thin needle").size() + 4;
    other = body;
    other[tip] = 3;
    EXPECT_NE(refusal(other).find("needle: its tip is unknown"), std::string::npos);
    other = body;
    for (std::size_t i = 0; i < 8; ++i)
        other[tip + 8 + i] = '\xff';  // its outer diameter: NaN
    EXPECT_NE(refusal(other).find("needle: its outer diameter is out of range"), std::string::npos);
    EXPECT_NE(refusal(body.substr(0, tip)), "");
    // The probe's name, and its transducer's.
    const std::size_t probe = body.find("my-probe"), transducer = body.find("some-array");
    ASSERT_NE(transducer, std::string::npos);
    for (const std::size_t at : {probe, transducer}) {
        other = body;
        other[at] = 'x';
        EXPECT_NE(refusal(other).find("probe: its numbers do not match its digest"), std::string::npos);
    }
    other = body;
    other[transducer - 1] = '\x7f';  // the length of the name
    EXPECT_NE(refusal(other).find("probe: the name of its transducer does not end"), std::string::npos);
    // A force that is not the instrument's own.
    RecordHeader header = someHeader();
    header.settings.tools.scalpel.cut_force_n += 0.1;
    EXPECT_NE(digests(header), digests(someHeader()));
}

TEST_F(RecordFile, AnotherInstrumentInTheJsonIsRefused) {
    const path file = folder_ / "record.json";
    const std::string good = test::readText(file);
    for (const std::string name : {"chiba-22g", "scalpel", "my-probe", "finger"}) {
        std::string json = good;
        const std::string value = ": \"" + name + "\"";
        ASSERT_NE(json.find(value), std::string::npos) << json;
        json.replace(json.find(value), value.size(), ": \"another\"");
        std::ofstream(file) << json;
        EXPECT_NE(test::errorText([&] { loadRecord(folder_); }).find("instruments: "), std::string::npos);
        EXPECT_NE(test::errorText([&] { loadRecordHead(folder_); }).find("of inputs.bin, \"" + name),
                  std::string::npos);
    }
}

TEST_F(RecordFile, AnOlderVersionIsRefusedWithAdvice) {
    std::string json = test::readText(folder_ / "record.json");
    const std::string now = "\"format_version\": " + std::to_string(kRecordVersion);
    ASSERT_NE(json.find(now), std::string::npos);
    json.replace(json.find(now), now.size(), "\"format_version\": 9");
    const std::string text = test::errorText([&] { parseInfo(json, "record.json"); });
    EXPECT_NE(text.find("record.json: format_version: 9 is not"), std::string::npos) << text;
    EXPECT_NE(text.find("use that version to read it"), std::string::npos);
    std::vector<unsigned char> bytes = readAll(inputs_);
    bytes[8] = 9;
    Record record;
    EXPECT_NE(
        test::errorText([&] { parseInputs(bytes, inputs_, record); }).find("use that version to read it"),
        std::string::npos);
}

TEST_F(RecordFile, UnfinishedRecordIsCompleteUpToTheLastFrame) {
    RecordWriter writer(folder_, someHeader(), someRecordInfo());
    addTicks(writer, 0, kFrameTicks + 3);
    const Record record = loadRecord(folder_);  // as after a crash: finish() was not called
    EXPECT_EQ(record.inputs.size(), kFrameTicks);
    EXPECT_EQ(record.torn_bytes, 0u);
    EXPECT_FALSE(record.info.end);
}

TEST_F(RecordFile, LargestPossibleTickFitsInAFrame) {
    TickInput largest = someInput(0);
    largest.device.flags |= haptics::kDeviceClutch;
    largest.command_count = haptics::kMaxCommandsPerTick;
    RecordWriter writer(folder_, someHeader(), someRecordInfo());
    addTo(writer, largest, outputOf(0));
    writer.finish();
    const Record record = loadRecord(folder_);
    EXPECT_EQ(record.torn_bytes, 0u);
    ASSERT_EQ(record.inputs.size(), 1u);
    EXPECT_EQ(record.inputs[0].command_count, haptics::kMaxCommandsPerTick);
}

TEST_F(RecordFile, LostTicksEndTheRecordBeforeTheGap) {
    constexpr std::uint64_t kWhole = kFrameTicks + 3;
    RecordWriter writer(folder_, someHeader(), someRecordInfo());
    addTicks(writer, 0, kWhole);
    addTicks(writer, kWhole + 5, kRecordTicks);
    writer.finish();
    const Record record = loadRecord(folder_);
    ASSERT_EQ(record.inputs.size(), kWhole);
    expectSameBits(record.inputs.back(), someInput(kWhole - 1));
    EXPECT_EQ(record.checkpoints.back().state_hash, outputOf(kWhole - 1).state_hash);
    EXPECT_EQ(record.torn_bytes, 0u);
    ASSERT_TRUE(record.info.end);
    EXPECT_EQ(record.info.end->tick, kWhole);
    EXPECT_EQ(record.info.end->state_hash, outputOf(kWhole - 1).state_hash);
    ASSERT_TRUE(record.info.lost);
    EXPECT_EQ(record.info.lost->first, kWhole + 1);
    EXPECT_EQ(record.info.lost->last, kWhole + 5);
}

TEST_F(RecordFile, ReportsNoLostTicksWhenNoneIsMissing) {
    EXPECT_FALSE(loadRecord(folder_).info.lost);
}

// HZ-RECORD-03
TEST_F(RecordFile, RecordJsonIsRemovedBeforeInputsAreReplaced) {
    std::filesystem::remove(inputs_);
    std::filesystem::create_directory(inputs_);  // cannot be opened for writing, not even by root
    EXPECT_THROW(RecordWriter(folder_, someHeader(), someRecordInfo()), DataError);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "record.json"));
}

// HZ-RECORD-02
TEST_F(RecordFile, FullDiskIsReported) {
    std::filesystem::remove(inputs_);
    std::filesystem::create_symlink("/dev/full", inputs_);
    test::expectRefused([&] { RecordWriter(folder_, someHeader(), someRecordInfo()); }, "inputs.bin", "file");
}

TEST_F(RecordFile, InvalidUtf8FolderNameIsReplaced) {
    RecordInfo info = someRecordInfo();
    info.patient_folder = "/some\xffwhere";
    RecordWriter(folder_, someHeader(), info).finish();
    EXPECT_EQ(loadRecord(folder_).info.patient_folder, "/some\xef\xbf\xbdwhere");  // U+FFFD
}

// A frame with a correct checksum and an invalid command. The complete frames before it remain valid.
TEST_F(RecordFile, ReadingStopsAtAnUnknownCommand) {
    for (const std::uint32_t kind : {std::uint32_t(haptics::kLastCommandKind) + 1, 0x7fffffffu, ~0u}) {
        RecordWriter writer(folder_, someHeader(), someRecordInfo());
        for (std::uint64_t i = 0; i < 2 * kFrameTicks; ++i) {
            TickInput input = someInput(i);
            if (i == kFrameTicks + 3) {
                input.command_count = 1;
                input.commands[0].kind = haptics::CommandKind(kind);
            }
            addTo(writer, input, outputOf(i));
        }
        writer.finish();
        const Record record = loadRecord(folder_);
        EXPECT_EQ(record.inputs.size(), kFrameTicks);
        EXPECT_GT(record.torn_bytes, 0u);
    }
}

TEST_F(RecordFile, PreservesEquipmentCommands) {
    RecordWriter writer(folder_, someHeader(), someRecordInfo());
    TickInput input = someInput(0);
    using haptics::CommandKind;
    const haptics::Command commands[] = {{CommandKind::inject, 1500},
                                         {CommandKind::pedal, 1},
                                         {CommandKind::xray, 0x01ffffff},
                                         {CommandKind::ultrasound, ~0u}};
    for (const haptics::Command& c : commands)
        input.commands[input.command_count++] = c;
    addTo(writer, input, outputOf(0));
    writer.finish();
    const Record record = loadRecord(folder_);
    ASSERT_EQ(record.inputs.size(), 1u);
    expectSameBits(record.inputs[0], input);
}

TEST_F(RecordFile, RefusesBadJsonWithItsReason) {
    for (const char* text : {"", "{", "[]", "{\"format_version\": 99}", "{\"format_version\": \"1\"}"}) {
        std::ofstream(folder_ / "record.json", std::ios::trunc) << text;
        EXPECT_THROW((void)loadRecord(folder_), DataError) << text;
    }
}

TEST_F(RecordFile, ParsesBookmarksAndRefusesInvalidOnes) {
    const std::string rest = test::readText(folder_ / "record.json").substr(1);
    const auto parsed = [&](const std::string& bookmarks) {
        return parseInfo("{\"bookmarks\": " + bookmarks + "," + rest, "record.json").bookmarks;
    };
    const auto mark = [](const std::string& tick, const std::string& what) {
        return "{\"tick\": " + tick + ", \"text\": \"" + what + "\"}";
    };
    EXPECT_TRUE(parsed("[]").empty());
    const std::vector<Bookmark> two = parsed("[" + mark("3", "skin") + "," + mark("3", "") + "]");
    ASSERT_EQ(two.size(), 2u);
    EXPECT_EQ(two[0].text, "skin");
    std::string many = mark("1", "");
    for (std::size_t i = 0; i < kMaxBookmarks; ++i)
        many += "," + mark("1", "");
    for (const std::string& bad :
         {std::string("7"), "[" + mark("4", "") + "," + mark("3", "") + "]", "[" + mark("\"x\"", "") + "]",
          std::string("[{\"tick\": 4}]"), "[" + mark("1", std::string(3 * kMaxBookmarkBytes + 1, 'x')) + "]",
          "[" + many + "]"})
        EXPECT_THROW(parsed(bad), DataError) << bad.substr(0, 80);
}

// HZ-RECORD-04
TEST_F(RecordFile, RestoresFactsEventsAndResult) {
    RecordInfo info = someRecordInfo();
    info.id = "an-id", info.trainee = "T-01", info.started_utc = "2026-11-21T20:15:00.123Z";
    info.device = "falcon", info.firmware_sha256 = "ab", info.clock = "real time", info.difficulty = "exam";
    info.registration_rms_m = 0.0011;
    {
        RecordWriter writer(folder_, someHeader(), info);
        addTicks(writer, 0, 10);
        writer.addEvents({{3, "tool", "finger"}});
        EXPECT_EQ(loadRecordHead(folder_).info.events.size(), 1u) << "at once";
        EXPECT_FALSE(loadRecordHead(folder_).info.result);
        addTicks(writer, 20, 30);  // ticks were lost, so the inputs end here
        writer.addEvents({{25, "comment", "after the gap"}});
        writer.finish(test::someResult());
    }
    const Record record = loadRecordHead(temp_.path());
    EXPECT_TRUE(record.inputs.empty());
    EXPECT_EQ(record.header.package_digest, someHeader().package_digest);
    EXPECT_EQ(record.info.id, "an-id");
    EXPECT_EQ(record.info.trainee, "T-01");
    EXPECT_EQ(record.info.started_utc, info.started_utc);
    EXPECT_EQ(record.info.device, "falcon");
    EXPECT_EQ(record.info.firmware_sha256, "ab");
    EXPECT_EQ(record.info.clock, "real time");
    EXPECT_EQ(record.info.difficulty, "exam");
    EXPECT_EQ(record.info.registration_rms_m, 0.0011);
    ASSERT_EQ(record.info.events.size(), 2u);
    EXPECT_EQ(record.info.events[1].text, "after the gap");
    EXPECT_EQ(record.info.end.value().tick, 10u);
    EXPECT_EQ(record.info.lost.value().first, 11u);
    EXPECT_EQ(record.info.result.value().total, 87.5);
}

TEST_F(RecordFile, BookmarksAreOrderedByTick) {
    RecordInfo info = someRecordInfo();
    info.bookmarks = {{100, "inherited"}, {200, "inherited"}};
    RecordWriter writer(folder_, someHeader(), info);
    writer.bookmark({150, "while recomputing"});
    const std::vector<Bookmark> marks = loadRecord(folder_).info.bookmarks;
    ASSERT_EQ(marks.size(), 3u);
    EXPECT_EQ(marks[1].text, "while recomputing");
}

// HZ-RECORD-06
TEST_F(RecordFile, OtherVersionsAreRefusedWithTheReason) {
    auto json = nlohmann::json::parse(test::readText(folder_ / "record.json"));
    for (const auto& [version, whose] : {std::pair{int(kRecordVersion) - 1, "an older"}, {100, "a newer"}}) {
        json["format_version"] = version;
        const std::string text = test::errorText([&] { parseInfo(json.dump(), folder_ / "record.json"); });
        EXPECT_NE(text.find("record.json: format_version: " + std::to_string(version)), std::string::npos);
        EXPECT_NE(text.find(std::string("by ") + whose + " program version"), std::string::npos) << text;
    }
    std::string bytes = test::readText(inputs_);
    bytes[8] = char(kRecordVersion - 1);
    std::ofstream(inputs_, std::ios::binary) << bytes;
    EXPECT_NE(test::errorText([&] { loadRecordHead(folder_); })
                  .find(fmt::format("inputs.bin: version: {} is not {}: the file was written by an older "
                                    "program version",
                                    kRecordVersion - 1, kRecordVersion)),
              std::string::npos);
}

// Removes, replaces and adds each field of the document in turn.
TEST_F(RecordFile, EachFieldOfTheDocumentIsNeededAndChecked) {
    const auto json = nlohmann::json::parse(test::readText(folder_ / "record.json"));
    const auto refusal = [&](const nlohmann::json& changed) {
        return test::errorText([&] { parseInfo(changed.dump(), "record.json"); });
    };
    EXPECT_EQ(refusal(json), "");
    for (const auto& [key, value] : json.items()) {
        auto changed = json;
        changed[key] = value.is_object() ? nlohmann::json(1) : nlohmann::json::object();
        EXPECT_NE(refusal(changed).find("record.json: " + key), std::string::npos) << key;
        changed = json;
        changed.erase(key);
        if (key == "state_hash") continue;  // without it, the attempt was interrupted: final_tick is unknown
        if (key == "case") continue;        // a puncture has none
        EXPECT_NE(refusal(changed).find("record.json: " + key), std::string::npos) << key;
    }
    for (const char* key : {"result", "lost_ticks", "unheard_of"}) {
        auto changed = json;
        changed[key] = 7;
        EXPECT_NE(refusal(changed).find(std::string("record.json: ") + key), std::string::npos) << key;
    }
}

TEST(Record, RefusesAMissingFolder) {
    EXPECT_THROW((void)loadRecord("/nonexistent/record"), DataError);
}

}  // namespace
}  // namespace stylet::records
