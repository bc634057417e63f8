// The phases of a 4D CT, and how they lie to each other.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/import_image.h"
#include "app/modeller/vector_field.h"

namespace stylet::modeller {

struct PhaseSettings {
    std::filesystem::path folder;  // one file (NIfTI, DICOM of many frames) or folder (DICOM series) a phase
    double spacing_mm = 0.0;       // 0: as stored
    ReaderLimits reader;
    std::function<void(std::string_view)> progress = [](std::string_view) {};
};

struct Phase {
    std::string name;
    FloatVolume hu;
};

// In the order of their names, numbers by value. All on one grid. Stored values that never fall below 0 are
// taken to be HU + 1000. Throws ImportError.
std::vector<Phase> readPhases(const PhaseSettings&);

struct RegisterSettings {
    std::filesystem::path program;  // empty: `stylet-register` beside this program
    int finest = 2;                 // voxels merged a side on the last level: 4, 2 or 1
    ChildLimits limits{.wall_s = 900, .cpu_s = 3600, .memory_bytes = std::size_t(8) << 30};
};

// Where the tissue of `fixed` that `mask` holds lies in `moving`: a displacement, smooth within the mask,
// going on beyond it as near it. What the mask leaves out is not looked at. Throws ImportError.
VectorField registerPhases(const FloatVolume& fixed, const FloatVolume& moving, const Mask& mask,
                           const RegisterSettings&);

}  // namespace stylet::modeller
