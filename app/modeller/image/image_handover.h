// Files that the child processes and this program exchange: a header, then one value per voxel, x fastest,
// little endian, on RAS axes.
// - an image (input of `stylet-register`, output of `stylet-image-reader`): int16
// - a displacement field (output of `stylet-register`, which matches two images): three float32, the
//   vector in millimetres from a voxel of the one image to the same tissue in the other image
// - an affine transform between two images (of `stylet-register`): no voxels
#pragma once

#include <array>
#include <cstdint>

namespace stylet::modeller {

inline constexpr std::array<char, 8> kImageMagic{'S', 'T', 'Y', 'L', 'I', 'M', 'G', '1'};
inline constexpr std::array<char, 8> kFieldMagic{'S', 'T', 'Y', 'L', 'F', 'L', 'D', '1'};
inline constexpr std::int64_t kMaxImageSide = 2048;
inline constexpr std::int64_t kMaxImageVoxels = 256ll << 20;

struct ImageHandover {
    std::array<char, 8> magic = kImageMagic;
    std::array<std::int64_t, 3> dims{};
    std::array<double, 3> spacing_mm{};
    std::array<double, 3> origin_mm{};  // centre of voxel (0, 0, 0)
};
static_assert(sizeof(ImageHandover) == 80);

// Maps a point p of the one image to  matrix (p - centre) + centre + shift  in the other.
inline constexpr std::array<char, 8> kAffineMagic{'S', 'T', 'Y', 'L', 'A', 'F', 'F', '1'};
struct AffineHandover {
    std::array<char, 8> magic = kAffineMagic;
    std::array<std::array<double, 3>, 3> matrix{};  // by rows
    std::array<double, 3> centre_mm{}, shift_mm{};
};
static_assert(sizeof(AffineHandover) == 128);

}  // namespace stylet::modeller
