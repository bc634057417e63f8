// The planned paths over the patient, coloured by their quality: as Fig. 3 of Mastmeyer et al. 2017.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "patient/patient.h"

namespace stylet::study {

inline constexpr int kPathsPictureWidth = 1120, kPathsPictureHeight = 640;

// From the patient's right and from the front: bone, liver, vessels and ducts behind at most a few hundred of
// the paths, the best on top. A PNG; empty where there is no path.
std::vector<std::uint8_t> pathsPicture(const patient::TissueMap&, std::span<const patient::PlannedPath>,
                                       const std::string& title, int threads);

}  // namespace stylet::study
