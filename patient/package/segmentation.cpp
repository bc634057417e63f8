#include "patient/package/segmentation.h"

namespace stylet::patient {

bool isInPartialSegmentation(const Label& label) {
    return label.tissue == Tissue::fascia || label.tissue == Tissue::liver ||
           label.tissue == Tissue::vessel || label.tissue == Tissue::duct;
}

double segmentedShare(const Package& package) {
    constexpr int kEvery = 4;
    const Grid& grid = package.ct.grid;
    std::size_t dense = 0, segmented = 0;
    for (int z = 0; z < grid.dims.z; z += kEvery)
        for (int y = 0; y < grid.dims.y; y += kEvery)
            for (int x = 0; x < grid.dims.x; x += kEvery) {
                const std::size_t at = grid.offset({x, y, z});
                if (package.ct.voxels[at] < package.thresholds.t1_hu) continue;
                ++dense;
                segmented += package.labels.voxels[at] != 0;
            }
    return dense > 0 ? double(segmented) / double(dense) : 0.0;
}

}  // namespace stylet::patient
