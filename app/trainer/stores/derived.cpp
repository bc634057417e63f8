#include "app/trainer/stores/derived.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <tuple>

#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/cache_file.h"
#include "base/hash.h"
#include "base/hex.h"

namespace stylet::trainer {

namespace fs = std::filesystem;

namespace {

constexpr std::array<char, 8> kMagic{'s', 't', 'y', 'l', 'k', 'e', 'p', 't'};
constexpr std::uint64_t kMaxBytes = std::uint64_t(1) << 30;

struct Head {
    std::array<char, 8> magic = kMagic;
    std::uint64_t key = 0, size = 0, hash = 0;
};
static_assert(sizeof(Head) == 32, "written as it lies in memory");

std::uint64_t hashOf(std::span<const std::byte> bytes) {
    StateHash hash;
    hash.addBytes(bytes);
    return hash.value();
}

// Evicts the least recently used files until the limits are met, but never `fresh`. Other programs may do the
// same at the same time, so a missing file is not an error.
void evictOldest(const fs::path& fresh, const DerivedLimits& limits) {
    struct Kept {
        fs::file_time_type used;
        std::uintmax_t bytes;
        fs::path file;
    };
    std::vector<Kept> others;
    std::error_code end;
    for (fs::directory_iterator entry(fresh.parent_path(), end), none; !end && entry != none;
         entry.increment(end)) {
        std::error_code gone;
        const fs::file_time_type used = entry->last_write_time(gone);
        const std::uintmax_t bytes = gone ? 0 : entry->file_size(gone);
        if (!gone && entry->path() != fresh && entry->is_regular_file(gone))
            others.push_back({used, bytes, entry->path()});
    }
    std::sort(others.begin(), others.end(), [](const Kept& a, const Kept& b) {
        return std::tie(b.used, b.file) < std::tie(a.used, a.file);
    });
    std::error_code unknown;
    std::uintmax_t bytes = fs::file_size(fresh, unknown);
    if (unknown) bytes = 0;
    std::size_t files = 1;
    for (const Kept& kept : others) {
        bytes += kept.bytes;
        if (++files > limits.files || bytes > limits.bytes) fs::remove(kept.file, unknown);
    }
}

struct TouchHead {
    std::array<std::int64_t, 3> dims{};
    std::array<double, 3> spacing_m{}, origin_m{};
};

}  // namespace

std::optional<haptics::TouchMap> parseTouchMap(std::span<const std::byte> bytes) {
    TouchHead head;
    if (bytes.size() < sizeof head) return std::nullopt;
    std::memcpy(&head, bytes.data(), sizeof head);
    bytes = bytes.subspan(sizeof head);
    haptics::TouchMap map;
    std::uint64_t floats = 3;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (head.dims[axis] < 1 || head.dims[axis] > kMaxVoxelsPerSide) return std::nullopt;
        if (!(head.spacing_m[axis] > 0.0) || !std::isfinite(head.spacing_m[axis]) ||
            !std::isfinite(head.origin_m[axis]))
            return std::nullopt;
        floats *= std::uint64_t(head.dims[axis]);
        map.grid.dims[int(axis)] = int(head.dims[axis]);
        map.grid.spacing_m[int(axis)] = head.spacing_m[axis];
        map.grid.origin_m[int(axis)] = head.origin_m[axis];
    }
    if (bytes.size() != floats * sizeof(float)) return std::nullopt;
    map.nodes.resize(std::size_t(floats));
    std::memcpy(map.nodes.data(), bytes.data(), bytes.size());
    if (!std::all_of(map.nodes.begin(), map.nodes.end(), [](float v) { return std::isfinite(v); }))
        return std::nullopt;
    return map;
}

std::vector<std::byte> bytesOf(const haptics::TouchMap& map) {
    TouchHead head;
    for (int axis = 0; axis < 3; ++axis) {
        head.dims[std::size_t(axis)] = map.grid.dims[axis];
        head.spacing_m[std::size_t(axis)] = map.grid.spacing_m[axis];
        head.origin_m[std::size_t(axis)] = map.grid.origin_m[axis];
    }
    const std::span<const std::byte> nodes = std::as_bytes(std::span(map.nodes));
    std::vector<std::byte> bytes(sizeof head + nodes.size());
    std::memcpy(bytes.data(), &head, sizeof head);
    std::memcpy(bytes.data() + sizeof head, nodes.data(), nodes.size());
    return bytes;
}

std::optional<std::uint64_t> derivedKey(std::initializer_list<std::uint64_t> parts) {
    const std::uint64_t build = buildId();
    if (build == 0) return std::nullopt;
    StateHash hash;
    hash.add(build);
    for (const std::uint64_t part : parts)
        hash.add(part);
    return hash.value();
}

std::optional<std::vector<std::byte>> loadDerived(const fs::path& file, std::uint64_t key) {
    removeStaleTemporaryFiles(file.parent_path());
    // Use the size of the open stream, because another program may replace the file in the meantime.
    std::ifstream in(file, std::ios::binary | std::ios::ate);
    if (!in) return std::nullopt;
    const auto size = std::uintmax_t(std::max<std::streamoff>(0, in.tellg()));
    in.seekg(0);
    const auto damaged = [&]() -> std::optional<std::vector<std::byte>> {
        printMessage(file.string() + " is damaged; rebuilding it");
        return std::nullopt;
    };
    Head head;
    if (size < sizeof head || !in.read(reinterpret_cast<char*>(&head), sizeof head) || head.magic != kMagic)
        return damaged();
    if (head.key != key) return std::nullopt;
    if (head.size > kMaxBytes || size != sizeof head + head.size) return damaged();
    std::vector<std::byte> bytes(head.size);
    if (!in.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size())) ||
        hashOf(bytes) != head.hash)
        return damaged();
    std::error_code ignored;
    fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);
    return bytes;
}

void saveDerived(const fs::path& file, std::uint64_t key, std::span<const std::byte> bytes,
                 const DerivedLimits& limits) {
    if (bytes.size() > kMaxBytes) return;
    try {
        const Head head{kMagic, key, bytes.size(), hashOf(bytes)};
        writeCacheFile(file, {std::as_bytes(std::span(&head, 1)), bytes});
        evictOldest(file, limits);
    } catch (const std::exception& e) {
        printMessage(fmt::format("not cached for the next start: {}", e.what()));
    }
}

haptics::TouchMap loadOrMakeTouchMap(const patient::Patient& patient, std::uint64_t patient_digest,
                                     const fs::path& folder, Made* made) {
    const std::optional<std::uint64_t> key = derivedKey({patient_digest});
    const fs::path file = folder / ("touch-" + hexText(patient_digest));
    if (const auto bytes = key ? loadDerived(file, *key) : std::nullopt)
        if (std::optional<haptics::TouchMap> map = parseTouchMap(*bytes)) return std::move(*map);
    haptics::TouchMap map = haptics::makeTouchMap(patient);
    if (key) saveDerived(file, *key, bytesOf(map));
    if (made) ++made->touch_maps;
    return map;
}

}  // namespace stylet::trainer
