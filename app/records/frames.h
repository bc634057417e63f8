// The common format of inputs.bin and samples.bin: a header and frames of ticks, each with a checksum.
//   magic 8 bytes, version u32, header size u32, header, CRC-32 of all bytes so far
//   "FRAM", tick count u32, body size u32, first tick u64, `Frame::last` u64, body, CRC-32 of the frame
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/records/disk_linux.h"

namespace stylet::records {

inline constexpr std::uint32_t kFrameTicks = 250;  // maximum loss in a crash: a quarter of a second
inline constexpr std::uint32_t kSyncTicks = 1000;  // maximum loss in a power failure: about a second

struct FileKind {
    std::array<char, 8> magic;
    std::uint32_t version;
    std::string_view what;  // for messages: "a Stylet record"
};

struct Frame {
    std::uint32_t ticks = 0;
    std::uint64_t first = 0;  // tick
    std::uint64_t last = 0;   // last tick; in inputs.bin the state hash
    std::span<const unsigned char> body;
    std::size_t size = 0;  // size in the file; ignored when writing
};

// Appends frames. After a crash the file is complete up to the last frame, after a power failure up to the
// last sync. Throws DataError if the disk refuses.
class FrameWriter {
  public:
    FrameWriter(const std::filesystem::path& file, std::span<const unsigned char> header);
    void add(const Frame&);
    void sync();

  private:
    DiskFile file_;
    std::uint64_t unsynced_ticks_ = 0;
};

// Encodes a header as it appears in the file.
std::vector<unsigned char> encodeFileHeader(const FileKind&, std::span<const unsigned char> body);

struct ParsedHeader {
    std::span<const unsigned char> body;
    std::size_t size = 0;  // offset of the first frame
};
// Throws DataError if the kind, version or checksum is wrong.
ParsedHeader parseFileHeader(std::span<const unsigned char> bytes, const std::filesystem::path& file,
                             const FileKind&);
// Decodes the frame at the start of `bytes`. Returns nothing if it is incomplete or damaged.
std::optional<Frame> parseFrame(std::span<const unsigned char> bytes);

// Reads a file of at most 2 GiB. Throws DataError.
std::vector<unsigned char> readAll(const std::filesystem::path& file);

// The intact part of a file: its header and all frames before the first damaged one.
struct IntactPart {
    std::uint64_t bytes = 0;  // 0: not even the header is intact
    std::uint64_t file_bytes = 0;
    std::uint64_t frames = 0, ticks = 0;
    bool torn() const { return bytes != file_bytes; }
};
// Reads frame by frame, so the file may have any size. Throws DataError if it cannot be read.
IntactPart findIntactPart(const std::filesystem::path& file);

}  // namespace stylet::records
