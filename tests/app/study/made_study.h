// A small study on disk: two pairs of one reference patient and two builds of it.
#pragma once

#include <algorithm>
#include <fstream>

#include "app/study/commands.h"
#include "tests/app/study/pairs.h"
#include "tests/support/temp_folder.h"

namespace stylet::test {

inline void makeStudy(const std::filesystem::path& folder) {
    patient::savePackage(seededTruth(), folder / "truth");
    patient::Package found = movedAndCut(seededTruth());
    patient::savePackage(found, folder / "built");
    // A voxel toward the head: the first build's labels lie one too low.
    const Grid grid = found.labels.grid;
    const std::size_t slice = std::size_t(grid.dims.x) * std::size_t(grid.dims.y);
    std::vector<std::uint8_t>& voxels = found.labels.voxels;
    std::copy_backward(voxels.begin(), voxels.end() - std::ptrdiff_t(2 * slice), voxels.end());
    patient::savePackage(found, folder / "other");
    std::ofstream(folder / "study.toml") << "[[pair]]\nname = 'one'\nreference = 'truth'\nfound = 'built'\n"
                                            "[[pair]]\nname = 'two'\nreference = 'truth'\nfound = 'other'\n";
}

struct StudyOptionsOf : study::StudyOptions {
    explicit StudyOptionsOf(const std::filesystem::path& folder) {
        study = folder / "study.toml";
        out = folder / "out";
        plan.skin_spacing_m = 0.008;
    }
};

}  // namespace stylet::test
