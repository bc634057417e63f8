// An attempt on disk: everything the simulation was given, bit for bit, so that it can be computed again.
//   inputs.bin    header, then frames of ticks, each with its checksum and the state hash it ended in
//   record.json   the same for a reader: patient, scenario, seed, gain, path, and how the attempt ended
// inputs.bin is little-endian throughout; README.md has the layout byte by byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/records/frames.h"
#include "haptics/simulation.h"
#include "patient/planning.h"

namespace stylet::records {

inline constexpr std::uint32_t kRecordVersion = 8;

// What a recomputation needs besides the patient. The profile's two texts are not stored.
struct RecordHeader {
    std::uint64_t package_digest = 0;
    haptics::SimulationSettings settings;
};

struct RecordEnd {
    std::uint64_t tick = 0;
    std::uint64_t state_hash = 0;
};

// Ticks that never reached the writer, both ends included.
struct LostTicks {
    std::uint64_t first = 0, last = 0;
};

// A mark of the instructor's, from which the attempt can be gone through again.
struct Bookmark {
    std::uint64_t tick = 0;
    std::string text;  // may be empty
};
inline constexpr std::size_t kMostBookmarks = 1000, kLongestBookmark = 512;

struct RecordInfo {
    std::string program_version;
    std::filesystem::path patient_folder;
    std::string patient_name;
    std::string scenario;
    std::vector<std::string> moments;
    double approach_distance_m = 0.0;
    std::uint64_t seed = 0;
    double gain = 1.0;
    patient::PlannedPath path;
    std::vector<Bookmark> bookmarks;  // in order
    std::optional<RecordEnd> end;     // absent: the attempt was cut short
    std::optional<LostTicks> lost;    // the record ends before them, the attempt went on
};

// Appends frames as ticks come in: after a crash the file is whole up to the last frame, after a power loss
// up to the last sync. A tick missing between two ends the record: nothing behind it could be recomputed.
// Session thread. Throws patient::DataError when the disk refuses.
class RecordWriter {
  public:
    RecordWriter(const std::filesystem::path& folder, const RecordHeader&, const RecordInfo&);
    // `state_hash` of the whole attempt (app/training/attempt_fold.h).
    void add(const haptics::TickInput&, std::uint64_t tick, std::uint64_t state_hash);
    // At once in record.json; more than kMostBookmarks are not kept.
    void bookmark(Bookmark);
    // Writes the frame in progress and the end into record.json; all of it is on the disk then.
    void finish();
    const std::optional<LostTicks>& lost() const { return info_.lost; }
    const std::vector<Bookmark>& bookmarks() const { return info_.bookmarks; }

  private:
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
    std::vector<Checkpoint> checkpoints;  // one a frame, ascending
    std::uint64_t torn_bytes = 0;         // behind the last whole frame: cut off
};

// Refuses a bad header, version or record.json with a DataError; a torn tail is cut at the last whole frame.
Record loadRecord(const std::filesystem::path& folder);

// The two files of a record by their contents; `file` is named when they are refused.
void parseInputs(std::span<const unsigned char> bytes, const std::filesystem::path& file, Record&);
RecordInfo parseInfo(std::string_view json, const std::filesystem::path& file);

std::string hexOf(std::uint64_t hash);  // 16 digits

}  // namespace stylet::records
