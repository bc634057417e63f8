#include "render/gpu/pipeline_cache_file.h"

#include <algorithm>
#include <array>

#include "base/hash.h"

namespace stylet::render {

namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'S', 'T', 'Y', 'L', 'P', 'C', 'H', '1'};
constexpr std::size_t kHeaderBytes = kMagic.size() + sizeof(std::uint64_t);

std::uint64_t checksum(std::span<const std::uint8_t> bytes) {
    StateHash hash;
    hash.add(std::uint64_t(bytes.size()));
    hash.addBytes(std::as_bytes(bytes));
    return hash.value();
}

}  // namespace

std::vector<std::uint8_t> encodeCacheFile(std::span<const std::uint8_t> from_driver) {
    std::vector<std::uint8_t> file(kMagic.begin(), kMagic.end());
    const std::uint64_t sum = checksum(from_driver);
    for (int byte = 0; byte < 8; ++byte)
        file.push_back(std::uint8_t(sum >> (8 * byte)));
    file.insert(file.end(), from_driver.begin(), from_driver.end());
    return file;
}

std::span<const std::uint8_t> decodeCacheFile(std::span<const std::uint8_t> file) {
    if (file.size() < kHeaderBytes || !std::equal(kMagic.begin(), kMagic.end(), file.begin())) return {};
    std::uint64_t sum = 0;
    for (std::size_t byte = 0; byte < 8; ++byte)
        sum |= std::uint64_t(file[kMagic.size() + byte]) << (8 * byte);
    const auto inside = file.subspan(kHeaderBytes);
    return checksum(inside) == sum ? inside : std::span<const std::uint8_t>{};
}

}  // namespace stylet::render
