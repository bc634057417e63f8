// stylet-image-reader ct|labels|phase PATH OUT [SERIES]: reads a hospital image with ITK, in a process of
// its own, because the underlying parsers are not hardened against hostile files. The parent sets the
// limits (import_image.cpp) and reads the voxels from OUT. On failure, the parent reads one sentence from
// standard output. SERIES is the UID of the series to read if a folder contains several.
#include <itkObject.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/modeller/image/raw_image.h"

namespace fs = std::filesystem;

namespace stylet::modeller {

namespace {

// Converts the stored axes to right, anterior, superior by swapping and flipping, never by interpolating.
ImageHandover toRas(const RawImage& in, std::vector<std::int16_t>& out) {
    ImageHandover header;
    std::array<int, 3> source{-1, -1, -1};  // source axis of each RAS axis
    std::array<bool, 3> flip{};
    V3 corner = in.origin;
    for (int i = 0; i < 3; ++i) {
        if (!(in.spacing[i] >= 0.05 && in.spacing[i] <= 20.0))
            refuse("spacing: a voxel spacing of " + formatNumber(in.spacing[i]) +
                   " mm is outside 0.05 to 20 mm");
        int along = 0;
        for (int d = 1; d < 3; ++d)
            if (std::fabs(in.axes[i][d]) > std::fabs(in.axes[i][along])) along = d;
        if (!(std::fabs(in.axes[i][along]) > kMinUprightCosine) || source[along] != -1)
            refuse("orientation: its axes are tilted by more than 5 degrees (" +
                   formatDegrees(std::fabs(in.axes[i][along])) +
                   ") against the patient's; resample it to upright axes");
        source[along] = i;
        const bool ras_sign_flips = along < 2;  // LPS to RAS
        flip[along] = (in.axes[i][along] > 0.0) == ras_sign_flips;
        if (flip[along])
            for (int d = 0; d < 3; ++d)
                corner[d] += in.axes[i][d] * in.spacing[i] * double(in.dims[i] - 1);
    }
    for (int d = 0; d < 3; ++d) {
        header.dims[d] = in.dims[source[d]];
        header.spacing_mm[d] = in.spacing[source[d]];
        header.origin_mm[d] = d < 2 ? -corner[d] : corner[d];
        if (!(std::fabs(corner[d]) < 1e5)) refuse("origin: is more than 100 m away");
    }
    const std::array<std::int64_t, 3> in_stride{1, in.dims[0], in.dims[0] * in.dims[1]};
    std::array<std::int64_t, 3> step{};
    std::int64_t start = 0;
    for (int d = 0; d < 3; ++d) {
        step[d] = flip[d] ? -in_stride[source[d]] : in_stride[source[d]];
        if (flip[d]) start += in_stride[source[d]] * (header.dims[d] - 1);
    }
    out.reserve(in.voxels.size());
    for (std::int64_t z = 0; z < header.dims[2]; ++z)
        for (std::int64_t y = 0; y < header.dims[1]; ++y)
            for (std::int64_t x = 0; x < header.dims[0]; ++x)
                out.push_back(in.voxels[std::size_t(start + x * step[0] + y * step[1] + z * step[2])]);
    return header;
}

}  // namespace

}  // namespace stylet::modeller

int main(int argc, char** argv) {
    using namespace stylet::modeller;
    if (argc != 4 && argc != 5) {
        std::puts("usage: stylet-image-reader ct|labels|phase PATH OUT [SERIES]");
        return 2;
    }
    try {
        itk::Object::GlobalWarningDisplayOff();
        const std::string kind = argv[1];
        const fs::path path(argv[2]);
        const bool frames = kind == "phase" && !fs::is_directory(path) && isDicom(path);
        const RawImage image = fs::is_directory(path) ? readDicomFolder(path, argc == 5 ? argv[4] : "")
                               : frames               ? readDicomFrames(path)
                                                      : readNifti(path, kind == "labels"  ? NiftiKind::labels
                                                                        : kind == "phase" ? NiftiKind::phase
                                                                                          : NiftiKind::ct);
        std::vector<std::int16_t> voxels;
        const ImageHandover header = toRas(image, voxels);
        std::ofstream out(argv[3], std::ios::binary);
        out.write(reinterpret_cast<const char*>(&header), sizeof header);
        out.write(reinterpret_cast<const char*>(voxels.data()),
                  std::streamsize(voxels.size() * sizeof voxels[0]));
        if (!out.flush())
            refuse("the voxels cannot be written to the temporary folder; free some disk space");
        return 0;
    } catch (const std::bad_alloc&) {
        std::puts("needs more memory than the reader may use; crop the image");
    } catch (const std::exception& e) {
        std::puts(e.what());
    }
    return 1;
}
