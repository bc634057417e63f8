// Output file of `stylet-image-reader`: this header, then dims.x * dims.y * dims.z int16 voxels, x fastest,
// little endian, on RAS axes.
#pragma once

#include <array>
#include <cstdint>

namespace stylet::modeller {

inline constexpr std::array<char, 8> kHandoverMagic{'S', 'T', 'Y', 'L', 'I', 'M', 'G', '1'};
inline constexpr std::int64_t kMaxImageSide = 2048;
inline constexpr std::int64_t kMaxImageVoxels = 256ll << 20;

struct ImageHandover {
    std::array<char, 8> magic = kHandoverMagic;
    std::array<std::int64_t, 3> dims{};
    std::array<double, 3> spacing_mm{};
    std::array<double, 3> origin_mm{};  // centre of voxel (0, 0, 0)
};
static_assert(sizeof(ImageHandover) == 80);

// Output file of `stylet-register`: this header, then three float32 per voxel, x fastest: the position of
// the voxel's tissue in the other phase minus its position here, in millimetres along RAS.
inline constexpr std::array<char, 8> kFieldMagic{'S', 'T', 'Y', 'L', 'F', 'L', 'D', '1'};

struct FieldHandover {
    std::array<char, 8> magic = kFieldMagic;
    std::array<std::int64_t, 3> dims{};
    std::array<double, 3> spacing_mm{};
    std::array<double, 3> origin_mm{};
};

}  // namespace stylet::modeller
