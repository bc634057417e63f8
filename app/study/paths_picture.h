// A picture of the planned paths over the patient, coloured by quality, as in Fig. 3 of Mastmeyer et al.
// 2017.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "patient/patient.h"

namespace stylet::study {

inline constexpr int kPathsPictureWidth = 1120, kPathsPictureHeight = 640;

// Renders a view from the patient's right and one from the front: bone, liver, vessels and ducts, and at
// most a few hundred paths with the best ones on top. Returns a PNG, or empty if there are no paths.
std::vector<std::uint8_t> pathsPicture(const patient::TissueMap&, std::span<const patient::PlannedPath>,
                                       const std::string& title, int threads);

}  // namespace stylet::study
