// Small patients with known borders.
#pragma once

#include <utility>
#include <vector>

#include "patient/patient.h"

namespace stylet::test {

// The shipped force table and thresholds (assets/tissue/ptcd.toml, found through STYLET_ASSETS).
const patient::TissueDefaults& tissueDefaults();

// One label per tissue except air, in the table's order: id 1 = skin ... id 7 = duct, with the roles of the
// force table.
const std::vector<patient::Label>& tissueLabels();

inline constexpr double kSlabAirMargin_m = 0.020;
inline constexpr double kSlabHalfWidth_m = 0.020;

// Layers along +x. The first begins exactly at x = 0 with air in front of it; the last ends at the end of the
// grid. Thicknesses must be whole multiples of the spacing. y and z run over +-kSlabHalfWidth_m in voxels of
// at least 1 mm. Air layers are unlabelled. With `labelled` = false the package has only CT values;
// thresholds on them distinguish air, skin, soft tissue and bone. The patient does not breathe.
patient::Package makeSlabs(const std::vector<std::pair<patient::Tissue, double>>& layers_m, double spacing_m,
                           bool labelled = true);

// A patient that owns its package.
struct PackageOwner {
    patient::Package own;
};
class OwnedPatient : PackageOwner, public patient::Patient {
  public:
    explicit OwnedPatient(patient::Package package) : PackageOwner{std::move(package)}, Patient(own) {}
    OwnedPatient(const OwnedPatient&) = delete;
    OwnedPatient& operator=(const OwnedPatient&) = delete;
};

}  // namespace stylet::test
