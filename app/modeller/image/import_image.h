// Hospital images, read by `stylet-image-reader` in a child process with resource limits.
#pragma once

#include <filesystem>
#include <string>

#include "app/modeller/image/child_process_linux.h"
#include "base/volume.h"

namespace stylet::modeller {

// A phase may also be a multi-frame DICOM file. If it has no spacing, 1 mm is used.
enum class ImageKind { ct, labels, phase };

struct ReaderLimits {
    std::filesystem::path program;  // empty: `stylet-image-reader` next to this program
    int wall_s = 120;
    int cpu_s = 90;
    std::size_t memory_bytes = std::size_t(3) << 30;
};

// Reads a DICOM folder or a NIfTI file as int16 on RAS axes (flipped or swapped, never interpolated): HU,
// or label ids that are never negative. `series` is the UID to read if a folder contains several series.
// Without it, such a folder is refused with a list of them. Throws ImportError: file, field and reason in
// one sentence.
Volume<std::int16_t> readImage(const std::filesystem::path&, ImageKind, const ReaderLimits& = {},
                               const std::string& series = {});

// Throws ImportError if a scan's values cannot be HU: no air, lung or gas; hardly any soft tissue; or too
// many values denser than bone.
void requireHounsfield(const CtVolume&, const std::filesystem::path& source);

}  // namespace stylet::modeller
