// Hospital images, read by `stylet-image-reader` in a child process with limits.
#pragma once

#include <filesystem>
#include <string>

#include "app/modeller/child_process_linux.h"
#include "patient/volume.h"

namespace stylet::modeller {

// A phase may also be a DICOM file of many frames; one that names no spacing comes with 1 mm.
enum class ImageKind { ct, labels, phase };

struct ReaderLimits {
    std::filesystem::path program;  // empty: `stylet-image-reader` beside this program
    int wall_s = 120;
    int cpu_s = 90;
    std::size_t memory_bytes = std::size_t(3) << 30;
};

// A DICOM folder or a NIfTI file as int16 on axes that are RAS (flipped or swapped, never interpolated): HU,
// or label ids, none below 0. `series` is the UID of the one to read where a folder holds several; left
// empty, such a folder is refused with a list of them. Throws ImportError: file, field and reason in one
// sentence.
patient::Volume<std::int16_t> readImage(const std::filesystem::path&, ImageKind, const ReaderLimits& = {},
                                        const std::string& series = {});

// Throws ImportError where a scan's values cannot be HU: no air, lung or gas, hardly any soft tissue, or
// mostly what no tissue shows.
void requireHounsfield(const patient::CtVolume&, const std::filesystem::path& source);

}  // namespace stylet::modeller
