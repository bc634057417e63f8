#include "app/study/result_blocks.h"

#include <fmt/core.h>

#include <cstring>
#include <fstream>
#include <type_traits>

#include "base/folder_linux.h"
#include "base/hash.h"
#include "base/whole_file.h"

namespace stylet::study {

namespace fs = std::filesystem;

namespace {

// Increment this when the same pair and settings give other results, or when PathResult changes.
constexpr std::uint64_t kResultsVersion = 3;

struct Header {
    std::uint64_t magic = 0x325244545359'5453;
    std::uint64_t digest = 0, block = 0, count = 0;
    std::uint64_t checksum = 0;  // of the bytes of the results
};
static_assert(std::is_trivially_copyable_v<PathResult> && std::is_trivially_copyable_v<Header>);

std::uint64_t checksum(std::span<const PathResult> results) {
    StateHash hash;
    hash.addBytes(std::as_bytes(results));
    return hash.value();
}

}  // namespace

std::uint64_t runDigest(const Pair& pair, std::span<const patient::PlannedPath> paths,
                        const RunSettings& settings) {
    StateHash hash;
    hash.add(kResultsVersion);
    hash.add(std::uint64_t(sizeof(PathResult)));
    hash.add(pair.reference_digest);
    hash.add(patient::digest(pair.found));
    hash.add(std::uint64_t(pair.labels));
    const SteeringSettings& s = settings.steering;
    hash.add(std::uint64_t(s.samples));
    for (const double v : {s.max_spacing_m, s.before_m, s.beyond_m, s.needle.a1_share, s.needle.cut_reach_m,
                           s.needle.max_force_n, s.needle.lateral_stiffness_n_per_m, s.needle.lateral_force_n,
                           s.speed_m_s, settings.measure.event_window_m})
        hash.add(v);
    hash.add(std::uint64_t(s.breathing));
    for (const patient::PlannedPath& p : paths)
        hash.add(p.entry_reference_m), hash.add(p.target_reference_m);
    return hash.value();
}

fs::path ResultBlocks::file(std::size_t block) const {
    return folder_ / fmt::format("{:06}.results", block);
}

bool ResultBlocks::read(std::size_t block, PathResult* into) const {
    std::ifstream in(file(block), std::ios::binary);
    Header header;
    if (!in.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
    if (header.magic != Header{}.magic || header.digest != digest_ || header.block != block ||
        header.count != size(block))
        return false;
    const std::span results(into, size(block));
    in.read(reinterpret_cast<char*>(results.data()), std::streamsize(results.size_bytes()));
    return in && in.peek() == std::ifstream::traits_type::eof() && checksum(results) == header.checksum;
}

bool ResultBlocks::has(std::size_t block) const {
    std::vector<PathResult> results(size(block));
    return read(block, results.data());
}

void ResultBlocks::write(std::size_t block, std::span<const PathResult> results) const {
    const Header header{
        .digest = digest_, .block = block, .count = size(block), .checksum = checksum(results)};
    std::string bytes(sizeof header + results.size_bytes(), '\0');
    std::memcpy(bytes.data(), &header, sizeof header);
    std::memcpy(bytes.data() + sizeof header, results.data(), results.size_bytes());
    requireFolder(folder_, "--out");
    writeWholeFile(file(block), bytes);
}

std::vector<PathResult> ResultBlocks::all() const {
    std::vector<PathResult> results(paths_);
    for (std::size_t block = 0; block < count(); ++block)
        if (!read(block, results.data() + begin(block)))
            throw DataError(file(block), "file",
                            "missing, or of another run: complete the study with `stylet-study run` first");
    return results;
}

}  // namespace stylet::study
