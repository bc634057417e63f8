#include "app/modeller/segmentation/orientation.h"

#include "app/modeller/image/import_error.h"
#include "app/modeller/image/morphology.h"

namespace stylet::modeller {

namespace {

// Lungs this far below the body's centroid mean upside down. In a chest scan that ends below the liver, both
// centroids are at about the same height.
constexpr double kUpsideDown_m = 0.03;

// Of a mask that is not empty.
Vec3 centroid(const Mask& mask) {
    Vec3 sum(0.0);
    forEachVoxel(mask.grid, [&](const Index3& i) {
        if (mask[i]) sum += mask.grid.centre(i);
    });
    return sum / double(countVoxels(mask));
}

}  // namespace

void checkUpright(const Mask& body, const Mask& lungs, const std::filesystem::path& scan) {
    if (countVoxels(lungs) > 0 && centroid(lungs).z < centroid(body).z - kUpsideDown_m)
        throw ImportError(
            scan.string() +
            ": axes: the scan is upside down: its lungs lie below the middle of the body. Correct the "
            "orientation in its file, or pass --trust-axes");
}

void checkFrontAndBack(const Mask& body, const Mask& bones, const std::filesystem::path& scan) {
    if (countVoxels(bones) > 0 && centroid(bones).y > centroid(body).y)
        throw ImportError(scan.string() +
                          ": axes: front and back of the scan are exchanged: its bones lie in front of the "
                          "middle of the body. Correct the orientation in its file, or pass --trust-axes");
}

}  // namespace stylet::modeller
