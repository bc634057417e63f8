// The results on disk while a study runs and after it: a file a block of paths. What is finished stays when
// the program does not, and an unfinished study goes on from there; ranks share the work through them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "app/study/study.h"

namespace stylet::study {

// 64 bits over all that the results depend on: both packages, what counts of the labels, paths and settings.
std::uint64_t runDigest(const Pair&, std::span<const patient::PlannedPath>, const RunSettings&);

inline std::size_t blockCount(std::size_t paths) {
    return (paths + kBlock - 1) / kBlock;
}

// The blocks of one pair's run, in a folder of their own.
class KeptBlocks {
  public:
    KeptBlocks(std::filesystem::path folder, std::uint64_t digest, std::size_t paths)
        : folder_(std::move(folder)), digest_(digest), paths_(paths) {}

    std::size_t count() const { return blockCount(paths_); }
    std::size_t begin(std::size_t block) const { return block * kBlock; }  // its first path
    std::size_t size(std::size_t block) const { return std::min(kBlock, paths_ - begin(block)); }
    // Whole, and of this run.
    bool has(std::size_t block) const;
    // A crash leaves the whole file or none. Throws patient::DataError.
    void keep(std::size_t block, std::span<const PathResult>) const;
    // The results of all paths, in their order. Throws patient::DataError where a block is missing.
    std::vector<PathResult> all() const;

  private:
    std::filesystem::path file(std::size_t block) const;
    bool read(std::size_t block, PathResult* into) const;

    std::filesystem::path folder_;
    std::uint64_t digest_;
    std::size_t paths_;
};

}  // namespace stylet::study
