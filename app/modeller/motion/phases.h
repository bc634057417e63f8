// The phases of a 4D CT and their registration.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/image/import_image.h"
#include "app/modeller/image/limited_child_linux.h"
#include "app/modeller/image/vector_field.h"

namespace stylet::modeller {

struct PhaseSettings {
    std::filesystem::path folder;  // one file (NIfTI, multi-frame DICOM) or folder (DICOM series) per phase
    double spacing_mm = 0.0;       // 0: as stored
    ReaderLimits reader;
    std::function<void(std::string_view)> progress = [](std::string_view) {};
};

struct Phase {
    std::string name;
    FloatVolume hu;
};

// Reads the phases in order of their names, comparing numbers by value. All must have one grid. If no
// stored value is negative, the values are taken as HU + 1000. Throws ImportError.
std::vector<Phase> readPhases(const PhaseSettings&);

struct RegisterSettings {
    std::filesystem::path program;  // empty: `stylet-register` next to this program
    int finest = 2;                 // voxels merged per side on the last level: 4, 2 or 1
    ChildLimits limits{.wall_s = 900, .cpu_s = 3600, .memory_bytes = std::size_t(8) << 30};
};

// Registers the tissue of `fixed` inside `mask` to `moving`. Returns a displacement that is smooth within
// the mask and is continued beyond it. Image content outside the mask is ignored. Throws ImportError.
VectorField registerPhases(const FloatVolume& fixed, const FloatVolume& moving, const Mask& mask,
                           const RegisterSettings&);

}  // namespace stylet::modeller
