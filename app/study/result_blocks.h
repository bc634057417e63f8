// Study results on disk, one file per block of paths. Finished blocks survive a crash, so an interrupted
// study can resume. Ranks share their work through these files.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "app/study/study.h"

namespace stylet::study {

// 64-bit hash of everything that the results depend on: both packages, the labels used, paths and settings.
std::uint64_t runDigest(const Pair&, std::span<const patient::PlannedPath>, const RunSettings&);

// The result blocks of one pair's run, in their own folder.
class ResultBlocks {
  public:
    ResultBlocks(std::filesystem::path folder, std::uint64_t digest, std::size_t paths)
        : folder_(std::move(folder)), digest_(digest), paths_(paths) {}

    std::size_t count() const { return blockCount(paths_); }
    std::size_t begin(std::size_t block) const { return block * kBlock; }  // its first path
    std::size_t size(std::size_t block) const { return std::min(kBlock, paths_ - begin(block)); }
    // Returns true if the block's file is complete and belongs to this run.
    bool has(std::size_t block) const;
    // Writes atomically: a crash leaves the whole file or none. Throws DataError.
    void write(std::size_t block, std::span<const PathResult>) const;
    // Returns the results of all paths in order. Throws DataError if a block is missing.
    std::vector<PathResult> all() const;

  private:
    std::filesystem::path file(std::size_t block) const;
    bool read(std::size_t block, PathResult* into) const;

    std::filesystem::path folder_;
    std::uint64_t digest_;
    std::size_t paths_;
};

}  // namespace stylet::study
