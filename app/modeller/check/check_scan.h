// Internal: checks of the scan itself (contrast phase, noise, field of view, distance of slices) and of what
// a segmentation often misses in an unusual scan (vessels, kidneys, spleen) or invents (ducts in fat, fascia
// outside the body). Every finding names a cause and a cure. Depths and areas are in millimetres, so that
// their limits hold for any voxel size.
#pragma once

#include "app/modeller/check/findings.h"
#include "app/modeller/check/package_statistics.h"

namespace stylet::modeller {

// NaN where the structure is missing.
struct ScanMeasures {
    double liver_hu = 0.0, vessels_hu = 0.0, aorta_hu = 0.0;  // means; vessels: those in the liver
    double noise_hu = 0.0;       // standard deviation between voxels of the liver 4 mm apart
    double blur_across_m = 0.0;  // standard deviation; NaN if no lung lies on the diaphragm
    double vessel_share = 0.0;   // of vessels in the whole liver's volume
    double fat_in_ducts =
        0.0;  // share of the liver's duct voxels that have the CT value of fat after smoothing
    // Share of the body's rows along x that end within 3 mm of this side's outermost one.
    double flat_right = 0.0, flat_left = 0.0;
    double bone_at_liver_mm2 = 0.0;  // area in which bone touches the liver's parenchyma or a tumour
    double bone_in_liver_mm3 = 0.0;  // pieces of bone, or of liver as dense as bone, inside the liver
    double cartilage_share = std::numeric_limits<double>::quiet_NaN();  // of the bones' volume
    // Distance along z between ribs that lie above one another, as a share of the rib cage's width: median,
    // and lower quartile, which stays the same if ribs are missing. NaN with few ribs.
    double rib_distance_median = 0.0, rib_distance_quartile = 0.0;
    double fascia_outside = 0.0;  // share of the fascia voxels that lie in the air around the body
};
ScanMeasures measureScan(const PackageStatistics&);

void checkScan(const PackageStatistics&, Findings&);

}  // namespace stylet::modeller
