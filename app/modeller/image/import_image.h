// Hospital images, read by `stylet-image-reader` in a child process with resource limits.
#pragma once

#include <filesystem>
#include <string>

#include "app/modeller/image/import_error.h"
#include "base/volume.h"

namespace stylet::modeller {

// What an image contains: CT values, label ids, or the CT values of one breathing phase of a 4D CT. Only a
// phase may be a multi-frame DICOM file. If a phase's file states no voxel spacing, 1 mm is assumed.
enum class ImageKind { ct, labels, phase };

struct ReaderLimits {
    std::filesystem::path program;  // empty: `stylet-image-reader` next to this program
    int wall_s = 120;
    int cpu_s = 90;
    std::size_t memory_bytes = std::size_t(3) << 30;
};

// Reads a DICOM folder or a NIfTI file. The voxels are HU, or label ids (never negative). The image axes are
// flipped or swapped to RAS; voxels are never interpolated. `series` is the UID of the DICOM series to read.
// If it is empty and the folder contains several series, the error lists them. Throws ImportError; its
// message names file, field and reason in one sentence.
Volume<std::int16_t> readImage(const std::filesystem::path&, ImageKind, const ReaderLimits& = {},
                               const std::string& series = {});

// Throws ImportError if the values of a scan cannot be HU. That is the case if no value is -500 or less (air,
// lung, bowel gas), if fewer than 2 % are from -200 to 200 (soft tissue), or if more than 10 % are above 1500
// (denser than bone). `source` is the file or folder that the message names.
void requireHounsfield(const CtVolume&, const std::filesystem::path& source);

}  // namespace stylet::modeller
