// What inputs.bin and samples.bin have in common: a header and frames of ticks, each with a checksum.
//   magic 8 bytes, version u32, header size u32, header, CRC-32 of all so far
//   "FRAM", tick count u32, body size u32, first tick u64, another u64, body, CRC-32 of the frame
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

inline constexpr std::uint32_t kFrameTicks = 250;  // what a crash may cost: a quarter of a second
inline constexpr std::uint32_t kSyncTicks = 1000;  // what a power loss may cost: about a second

struct FileKind {
    std::array<char, 8> magic;
    std::uint32_t version;
    std::string_view what;  // "a Stylet record"
};

struct Frame {
    std::uint32_t ticks = 0;
    std::uint64_t first = 0;  // tick
    std::uint64_t last = 0;   // tick; of inputs.bin the state hash
    std::span<const unsigned char> body;
    std::size_t size = 0;  // in the file; of what is to be written: not needed
};

// Appends frames: after a crash the file is whole up to the last one, after a power loss up to the last sync.
// Throws patient::DataError when the disk refuses.
class FrameWriter {
  public:
    FrameWriter(const std::filesystem::path& file, std::span<const unsigned char> header);
    void add(const Frame&);
    void sync();

  private:
    DiskFile file_;
    std::uint64_t unsynced_ticks_ = 0;
};

// A header as it stands in the file.
std::vector<unsigned char> fileHeader(const FileKind&, std::span<const unsigned char> body);

struct FileHead {
    std::span<const unsigned char> body;
    std::size_t size = 0;  // where the frames begin
};
// Throws patient::DataError for another kind, version or checksum.
FileHead fileHead(std::span<const unsigned char> bytes, const std::filesystem::path& file, const FileKind&);
// The frame that `bytes` begin with; nothing where it is not whole.
std::optional<Frame> frameAt(std::span<const unsigned char> bytes);

// A file of at most 2 GiB. Throws patient::DataError.
std::vector<unsigned char> readAll(const std::filesystem::path& file);

// The part of a file that is whole: its header and every frame before the first that is not.
struct WholePart {
    std::uint64_t bytes = 0;  // 0: not even the header
    std::uint64_t file_bytes = 0;
    std::uint64_t frames = 0, ticks = 0;
    bool torn() const { return bytes != file_bytes; }
};
// Reads frame by frame, whatever the file's size. Throws patient::DataError when it cannot be read.
WholePart wholePart(const std::filesystem::path& file);

}  // namespace stylet::records
