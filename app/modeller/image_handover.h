// What `stylet-image-reader` leaves for its parent: this header, then dims.x * dims.y * dims.z int16 voxels,
// x fastest, little endian, on axes that are RAS already.
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

// What `stylet-register` leaves: this header, then three float32 a voxel, x fastest: where the voxel's tissue
// lies in the other phase, less where it lies here, in millimetres along RAS.
inline constexpr std::array<char, 8> kFieldMagic{'S', 'T', 'Y', 'L', 'F', 'L', 'D', '1'};

struct FieldHandover {
    std::array<char, 8> magic = kFieldMagic;
    std::array<std::int64_t, 3> dims{};
    std::array<double, 3> spacing_mm{};
    std::array<double, 3> origin_mm{};
};

}  // namespace stylet::modeller
