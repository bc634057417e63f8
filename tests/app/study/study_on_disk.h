// A small study on disk: two pairs, each of the same reference patient and one of two builds.
#pragma once

#include <algorithm>
#include <fstream>

#include "app/study/commands.h"
#include "tests/app/study/pairs.h"
#include "tests/support/temp_folder.h"

namespace stylet::test {

inline void writeStudy(const std::filesystem::path& folder) {
    patient::savePackage(seededTruth(), folder / "truth");
    patient::Package found = movedAndCut(seededTruth());
    patient::savePackage(found, folder / "built");
    // Moves the labels one voxel toward the head, because those of the first build are one voxel too low.
    const Grid grid = found.labels.grid;
    const std::size_t slice = std::size_t(grid.dims.x) * std::size_t(grid.dims.y);
    std::vector<std::uint8_t>& voxels = found.labels.voxels;
    std::copy_backward(voxels.begin(), voxels.end() - std::ptrdiff_t(2 * slice), voxels.end());
    patient::savePackage(found, folder / "other");
    std::ofstream(folder / "study.toml") << "[[pair]]\nname = 'one'\nreference = 'truth'\nfound = 'built'\n"
                                            "[[pair]]\nname = 'two'\nreference = 'truth'\nfound = 'other'\n";
}

struct TestStudyOptions : study::StudyOptions {
    explicit TestStudyOptions(const std::filesystem::path& folder) {
        study = folder / "study.toml";
        out = folder / "out";
        plan.skin_spacing_m = 0.008;
    }
};

}  // namespace stylet::test
