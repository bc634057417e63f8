// The pictures of an attempt's moments, small enough to stand in a page.
#pragma once

#include <filesystem>
#include <vector>

#include "app/report/page.h"

namespace stylet::report {

// A PNG at most `widest` pixels wide, as JPEG. Throws patient::DataError.
Picture still(const std::filesystem::path& png, int widest);

// A PNG as it is, its size read from its header. Throws patient::DataError.
Picture wholePng(const std::filesystem::path& png);

struct Stills {
    std::vector<Picture> pictures;
    std::size_t left_out = 0;             // more than `most`
    std::vector<std::string> complaints;  // of files that could not be read
};

// The folder's pictures but curve and slices, by name, right eyes left out; the name becomes caption and
// text.
Stills stillsOf(const std::filesystem::path& folder, std::size_t most, int widest);

}  // namespace stylet::report
