// What the CT value alone says of a tissue: the haptic transfer function over the histogram and over a slice,
// as in Figs. 10 to 13 of Mastmeyer et al. 2017.
#pragma once

#include <filesystem>
#include <string>

#include "patient/patient.h"

namespace stylet::report {

// One PNG of four panels: the histogram with its intervals; an axial slice at `at_reference_m`, undeformed,
// as the needle's tip sees it before the fascia; past it, with the fascia; and with ducts and vessels where
// they are segmented. Throws patient::DataError.
void drawClasses(const patient::Patient&, const patient::Vec3& at_reference_m, const std::string& title,
                 const std::filesystem::path& png);

}  // namespace stylet::report
