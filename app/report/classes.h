// Shows how the CT value alone classifies tissue: the haptic transfer function over the histogram and over a
// slice, as in Figs. 10 to 13 of Mastmeyer et al. 2017.
#pragma once

#include <filesystem>
#include <string>

#include "patient/patient.h"

namespace stylet::report {

// Writes one PNG of four panels: the histogram with its intervals, and the undeformed axial slice at
// `at_reference_m` as classified before the fascia, past the fascia, and with the segmented ducts and
// vessels. Throws DataError.
void drawClasses(const patient::Patient&, const Vec3& at_reference_m, const std::string& title,
                 const std::filesystem::path& png);

}  // namespace stylet::report
