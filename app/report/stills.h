// Pictures of an attempt's capture points, small enough to embed in a page.
#pragma once

#include <filesystem>
#include <vector>

#include "app/report/page.h"

namespace stylet::report {

// Converts a PNG to JPEG, at most `max_width` pixels wide. Throws DataError.
Picture loadStill(const std::filesystem::path& png, int max_width);

struct Stills {
    std::vector<Picture> pictures;
    std::size_t left_out = 0;           // number of pictures beyond `most`
    std::vector<std::string> warnings;  // files that could not be read
};

// The folder's pictures except curve and slices, sorted by name, without right-eye pictures. The file name
// becomes the caption and the alternative text.
Stills loadStills(const std::filesystem::path& folder, std::size_t most, int max_width);

}  // namespace stylet::report
