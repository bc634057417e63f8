// The record of an attempt is the only source of everything that programs read about it:
//   inputs.bin    every simulation input, bit for bit, so that the attempt can be recomputed: header, then
//                 frames of ticks, each with a checksum and the state hash at its end
//   record.json   who, on which patient, with what; events and bookmarks; the result once it has ended
//   samples.bin   the state of every tick (samples.h)
// inputs.bin is little-endian. README.md documents its layout byte by byte. All other files of an attempt are
// exports (export.h) or pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/records/frames.h"
#include "app/records/result.h"
#include "haptics/loop/simulation.h"
#include "patient/planning/planning.h"

namespace stylet::records {

inline constexpr std::uint32_t kRecordVersion = 10;

// What a recomputation needs besides the patient and the ticks. The name and source of
// the device profile are not stored.
struct RecordHeader {
    std::uint64_t package_digest = 0;
    haptics::SimulationSettings settings;
    // The attempt's instruments. Their forces are not stored here, but in `settings.tools`.
    haptics::InstrumentSet instruments{};
};
// The digest of one of the header's instruments with the force of its tool, as the record stores it.
std::uint64_t instrumentDigest(const RecordHeader&, const haptics::Instrument&);

struct RecordEnd {
    std::uint64_t tick = 0;
    std::uint64_t state_hash = 0;
};

// Ticks that never reached the writer, first and last inclusive.
struct LostTicks {
    std::uint64_t first = 0, last = 0;
};

// A mark set by the instructor, from which the attempt can be restarted.
struct Bookmark {
    std::uint64_t tick = 0;
    std::string text;  // may be empty
};
inline constexpr std::size_t kMaxBookmarks = 1000, kMaxBookmarkBytes = 512;

// The contents of record.json.
struct RecordInfo {
    std::string id, trainee, started_utc;  // empty outside a store
    std::string program_version;
    std::string device;           // "scripted", "replay", or a device's name
    std::string firmware_sha256;  // of the firmware image loaded into the device; empty: none
    std::string clock;            // "real time" or "virtual"
    std::string difficulty;
    std::string course = "puncture";           // one of training::kCourseNames
    std::string patient_case;                  // text of the reviewed case's file; empty: none
    std::optional<double> registration_rms_m;  // for a device registered in the headset's room
    std::filesystem::path patient_folder;
    std::string patient_name;
    // Why `stylet-model check` would have refused the patient, or that there was no check; empty: accepted.
    std::string patient_check;
    std::string scenario;
    // Names of the instruments, for people; RecordWriter fills them in from the header.
    std::string needle, scalpel, probe, finger, wire, dilator, drain;
    std::vector<std::string> capture_points;
    double approach_distance_m = 0.0;
    std::uint64_t seed = 0;
    double gain = 1.0;
    patient::PlannedPath path;
    std::vector<Bookmark> bookmarks;      // by tick
    std::vector<EventRow> events;         // in the order of adding
    std::optional<RecordEnd> end;         // absent: the attempt was interrupted
    std::optional<LostTicks> lost;        // the record ends before these ticks; the attempt continued
    std::optional<AttemptResult> result;  // absent: the attempt was cut short
};

// Appends frames as ticks arrive. After a crash the file is complete up to the last frame, after a power
// failure up to the last sync. A missing tick ends the record, because later ticks could not be recomputed.
// Session thread. Throws DataError if the disk refuses.
class RecordWriter {
  public:
    RecordWriter(const std::filesystem::path& folder, const RecordHeader&, const RecordInfo&);
    // `state_hash` covers the whole attempt (app/training/attempt_fold.h).
    void add(const haptics::TickInput&, std::uint64_t tick, std::uint64_t state_hash);
    // Writes the bookmark to record.json at once. Bookmarks beyond kMaxBookmarks are dropped.
    void bookmark(Bookmark);
    // Writes the events to record.json at once. Accepts events of ticks that were lost.
    void addEvents(const std::vector<EventRow>&);
    // Writes the current frame, and the end into record.json. Returns when both are on the disk.
    void finish();
    void finish(const AttemptResult&);  // the same, with the result
    // For the end: the easiest difficulty that the trainee had.
    void setDifficulty(std::string name) { info_.difficulty = std::move(name); }
    const RecordInfo& info() const { return info_; }

  private:
    void endInputs();
    void writeFrame();

    std::filesystem::path folder_;
    RecordInfo info_;
    FrameWriter inputs_;
    std::vector<unsigned char> frame_;
    std::uint32_t frame_count_ = 0;
    std::uint64_t ticks_ = 0;
    RecordEnd last_;
    bool ended_ = false;
};

// The state hash after the first `ticks` inputs.
struct Checkpoint {
    std::uint64_t ticks = 0;
    std::uint64_t state_hash = 0;
};

struct Record {
    RecordHeader header;
    RecordInfo info;
    std::vector<haptics::TickInput> inputs;
    std::vector<Checkpoint> checkpoints;  // one per frame, ascending
    std::uint64_t torn_bytes = 0;         // bytes behind the last whole frame; ignored
};

// The folder of the record in an attempt's folder, or `folder` itself if it contains no other record or is a
// record's folder named "record".
std::filesystem::path recordFolder(const std::filesystem::path& folder);

// `folder`: of the attempt or of its record. Throws DataError for a bad header, version or record.json.
// Ignores a torn tail behind the last whole frame.
Record loadRecord(const std::filesystem::path& folder);
// The same without the ticks: `inputs` and `checkpoints` are empty. Reads little, however long the attempt.
Record loadRecordHead(const std::filesystem::path& folder);
// The same, only from the subfolder "record" of an attempt's folder.
Record loadAttemptHead(const std::filesystem::path& attempt_folder);

// Parse the contents of a record's two files. `file` is used in error messages.
void parseInputs(std::span<const unsigned char> bytes, const std::filesystem::path& file, Record&);
RecordInfo parseInfo(std::string_view json, const std::filesystem::path& file);

}  // namespace stylet::records
