// Internal: parses and checks the 348-byte header of a NIfTI-1 file.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>

#include "base/geometry.h"

namespace stylet::patient {

inline constexpr std::size_t kNiftiHeaderBytes = 348;
// Offset of the voxels in the files that Stylet writes: the header plus the four bytes of NIfTI's extension
// flag.
inline constexpr std::size_t kNiftiDataOffset = 352;

// NIfTI's datatype codes.
enum class NiftiType : int { uint8 = 2, int16 = 4, int32 = 8, float32 = 16, float64 = 64, uint16 = 512 };
std::size_t bytesOf(NiftiType) noexcept;

struct NiftiHeader {
    bool big_endian = false;
    NiftiType type = NiftiType::int16;
    std::size_t data_offset = kNiftiDataOffset;
    double slope = 1.0, intercept = 0.0;
    Grid grid;                                         // in RAS, after undoing flips
    std::array<bool, 3> flipped{false, false, false};  // axes stored in reverse
};

using NiftiHeaderBytes = std::array<std::byte, kNiftiDataOffset>;

// Checks every field that is used. `components` > 1: one vector per voxel, along the fifth dimension.
// Throws DataError.
NiftiHeader parseNiftiHeader(const std::filesystem::path& file,
                             std::span<const std::byte, kNiftiHeaderBytes> bytes, int components = 1);
NiftiHeaderBytes makeNiftiHeader(NiftiType, const Grid&, int components = 1);

}  // namespace stylet::patient
