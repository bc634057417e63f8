#include "base/hash.h"

namespace stylet {

void StateHash::add(std::string_view text) noexcept {
    addBytes(std::as_bytes(std::span(text.data(), text.size())));
}

// Hashes the length first, so that the end of the bytes is unambiguous. Then hashes little-endian words; the
// last one is padded with zeros.
void StateHash::addBytes(std::span<const std::byte> bytes) noexcept {
    add(std::uint64_t(bytes.size()));
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) {
        std::uint64_t word = 0;
        for (std::size_t b = 0; b < 8; ++b)
            word |= std::uint64_t(bytes[i + b]) << (8 * b);
        add(word);
    }
    if (i == bytes.size()) return;
    std::uint64_t word = 0;
    for (std::size_t b = 0; i + b < bytes.size(); ++b)
        word |= std::uint64_t(bytes[i + b]) << (8 * b);
    add(word);
}

}  // namespace stylet
