#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "app/modeller/image/handover_files.h"
#include "app/modeller/image/import_error.h"
#include "tests/fuzz/scratch_file.h"

// The input is the output file of a child process that read a hostile file. The result is a bounded image
// or field, or an ImportError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::modeller;
    const std::filesystem::path file = fuzz::scratchFile("handover", data, size);
    for (const ImageKind kind : {ImageKind::ct, ImageKind::labels}) {
        try {
            if (readImageFile(file, "fuzz.nii", kind).voxels.size() * 2 > size) std::abort();
        } catch (const ImportError&) {
        }
    }
    try {
        for (const glm::vec3& v : readFieldFile(file).voxels)
            if (!(std::fabs(v.x) + std::fabs(v.y) + std::fabs(v.z) < 31.0f)) std::abort();
    } catch (const ImportError&) {
    }
    return 0;
}
