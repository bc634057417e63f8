// Valid NIfTI files as bytes, for tests to corrupt. Offsets are those of nifti1.h.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

namespace stylet::test {

using Bytes = std::vector<std::byte>;

template <typename Value>
void put(Bytes& bytes, std::size_t at, Value value) {
    std::memcpy(bytes.data() + at, &value, sizeof(Value));
}

// 3 x 4 x 5 voxels of 1 x 2 x 3 mm at (-10, 20, 30) mm, stored type int16, value = index.
inline Bytes validNifti() {
    Bytes bytes(352 + 60 * 2);
    put(bytes, 0, std::int32_t(348));
    const std::int16_t dim[8] = {3, 3, 4, 5, 1, 1, 1, 1};
    std::memcpy(bytes.data() + 40, dim, sizeof dim);
    put(bytes, 70, std::int16_t(4)), put(bytes, 72, std::int16_t(16));
    const float pixdim[4] = {1, 1, 2, 3};
    std::memcpy(bytes.data() + 76, pixdim, sizeof pixdim);
    put(bytes, 108, 352.0f);
    put(bytes, 123, std::uint8_t(2));
    put(bytes, 254, std::int16_t(1));
    const float srow[12] = {1, 0, 0, -10, 0, 2, 0, 20, 0, 0, 3, 30};
    std::memcpy(bytes.data() + 280, srow, sizeof srow);
    std::memcpy(bytes.data() + 344, "n+1", 4);
    for (std::size_t i = 0; i < 60; ++i)
        put(bytes, 352 + 2 * i, std::int16_t(i));
    return bytes;
}

inline Bytes fileBytes(const std::filesystem::path& file) {
    Bytes bytes(std::size_t(std::filesystem::file_size(file)));
    std::ifstream(file, std::ios::binary)
        .read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    return bytes;
}

inline void writeBytes(const std::filesystem::path& file, const Bytes& bytes) {
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

}  // namespace stylet::test
