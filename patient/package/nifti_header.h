// Internal: parses and checks the 348-byte header of a NIfTI-1 file.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "base/geometry.h"

namespace stylet::patient {

inline constexpr std::size_t kNiftiHeaderBytes = 348;
// Offset of the voxels in the files that Stylet writes: the header plus the four bytes of NIfTI's extension
// flag.
inline constexpr std::size_t kNiftiDataOffset = 352;

// Reads one number. `swap`: it is stored in the other byte order.
template <typename Stored>
double decodeNifti(const std::byte* at, bool swap) noexcept {
    std::array<std::byte, sizeof(Stored)> raw;
    std::copy_n(at, sizeof(Stored), raw.begin());
    if (swap) std::reverse(raw.begin(), raw.end());
    return double(std::bit_cast<Stored>(raw));
}

// How the numbers of a volume are stored.
struct NiftiType {
    std::int16_t code;  // NIfTI's datatype
    std::size_t bytes;
    double (*decode)(const std::byte*, bool swap) noexcept;
};
template <typename Stored>
constexpr NiftiType makeNiftiType(std::int16_t code) {
    return {code, sizeof(Stored), decodeNifti<Stored>};
}
inline constexpr NiftiType kNiftiUint8 = makeNiftiType<std::uint8_t>(2),
                           kNiftiInt16 = makeNiftiType<std::int16_t>(4),
                           kNiftiFloat32 = makeNiftiType<float>(16);
inline constexpr std::array kNiftiTypes{kNiftiUint8,
                                        kNiftiInt16,
                                        kNiftiFloat32,
                                        makeNiftiType<std::int32_t>(8),
                                        makeNiftiType<double>(64),
                                        makeNiftiType<std::uint16_t>(512)};

struct NiftiHeader {
    bool big_endian = false;
    NiftiType type = kNiftiInt16;
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
NiftiHeaderBytes makeNiftiHeader(const NiftiType&, const Grid&, int components = 1);

}  // namespace stylet::patient
