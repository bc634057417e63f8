// What inputs.bin and samples.bin have in common: a header and frames of ticks, each with a checksum.
//   magic 8 bytes, version u32, header size u32, header, CRC-32 of all so far
//   "FRAM", tick count u32, body size u32, two u64, body, CRC-32 of the frame
#pragma once

#include <cstdint>
#include <filesystem>

namespace stylet::records {

inline constexpr std::uint32_t kFrameMark = 0x4d415246;   // "FRAM"
inline constexpr std::size_t kPrologueBytes = 8 + 4 + 4;  // magic, version, header size
inline constexpr std::size_t kFrameHeadBytes = 4 + 4 + 4 + 8 + 8;
inline constexpr std::uint32_t kMaxHeaderBytes = 1 << 20;
inline constexpr std::uint32_t kMaxFrameBytes = 1 << 20;  // of a body

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
