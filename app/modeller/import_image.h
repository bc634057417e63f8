// Hospital images, read by `stylet-image-reader` in a child process with limits.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "patient/volume.h"

namespace stylet::modeller {

// Bad input, or a parser that gave up: what() is one sentence that names the file.
class ImportError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

enum class ImageKind { ct, labels };

struct ReaderLimits {
    std::filesystem::path program;  // empty: `stylet-image-reader` beside this program
    int wall_s = 120;
    int cpu_s = 90;
    std::size_t memory_bytes = std::size_t(3) << 30;
};

// A DICOM folder or a NIfTI file as int16 on axes that are RAS (flipped or swapped, never interpolated): HU,
// or label ids, none below 0. Throws ImportError.
patient::Volume<std::int16_t> readImage(const std::filesystem::path&, ImageKind, const ReaderLimits& = {});

}  // namespace stylet::modeller
