#include "app/modeller/image/import_image.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <system_error>

#include "app/modeller/image/handover_files.h"
#include "app/modeller/image/image_handover.h"
#include "app/modeller/image/limited_child_linux.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

// Limits of requireHounsfield(). A CT scan in HU contains air, lung or bowel gas, so its lowest value is at
// most kMaxAir_hu. At least the share kMinSoftShare of its voxels is soft tissue. At most the share
// kMaxDenseShare is denser than cortical bone.
constexpr int kMaxAir_hu = -500;
constexpr double kMinSoftShare = 0.02, kMaxDenseShare = 0.1;

}  // namespace

Volume<std::int16_t> readImage(const fs::path& path, ImageKind kind, const ReaderLimits& limits,
                               const std::string& series) {
    std::error_code error;
    if (!fs::exists(path, error)) throw ImportError(path.string() + ": there is no such file or folder");
    const bool folder = fs::is_directory(path, error);
    if (!folder && !fs::is_regular_file(path, error))
        throw ImportError(path.string() + ": is neither a file nor a folder");
    if (!folder && !series.empty())
        throw ImportError(path.string() + ": is a file; --series chooses among a folder's");
    if (kind == ImageKind::labels && folder)
        throw ImportError(path.string() + ": is a folder; labels are one NIfTI file");
    const fs::path program = childProgram(limits.program, "stylet-image-reader");
    const PrivateFolder place;
    const std::string source = path.string(), out = (place.path() / "image").string();
    ChildLimits child{limits.wall_s, limits.cpu_s, limits.memory_bytes};
    child.file_bytes = std::size_t(kMaxImageVoxels) * 2 + 4096;
    constexpr const char* kKinds[] = {"ct", "labels", "phase"};
    std::vector<std::string> arguments{kKinds[int(kind)], source, out};
    if (!series.empty()) arguments.push_back(series);
    runChild(program, arguments, child, source, "the reader");
    return readImageFile(out, path, kind);
}

void requireHounsfield(const CtVolume& ct, const fs::path& source) {
    double soft = 0.0, dense = 0.0;
    int lowest = 32767;
    for (const std::int16_t hu : ct.voxels) {
        lowest = std::min(lowest, int(hu));
        soft += hu >= -200 && hu <= 200;
        dense += hu > 1500;
    }
    const auto refuse = [&](const std::string& why) {
        throw ImportError(
            source.string() + ": voxels: " + why +
            "; these are not HU (RescaleSlope (0028,1053), "
            "RescaleIntercept (0028,1052), or in a NIfTI file scl_slope and scl_inter, may be wrong)");
    };
    const double all = double(ct.voxels.size());
    if (lowest > kMaxAir_hu)
        refuse("the lowest value is " + std::to_string(lowest) + ", but air or lung shows below " +
               std::to_string(kMaxAir_hu));
    if (soft < kMinSoftShare * all) refuse("hardly any value is that of soft tissue, -200 to 200");
    if (dense > kMaxDenseShare * all) refuse("too many values are denser than the densest bone, above 1500");
}

}  // namespace stylet::modeller
