// The section of a scan that becomes a patient: resampled, cropped to the body, and within the package size
// limits.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/image/voxel_tools.h"
#include "patient/tissue/tissue.h"

namespace stylet::modeller {

inline constexpr std::int16_t kOutside_hu = -1024;  // value of voxels outside the body

// An isotropic grid over the scan's heights from `low_m` to `high_m` and its whole width, plus a rim of
// air. Aligned to whole voxels from the scan's first voxel. Throws ImportError if the scan is wider than
// 0.5 m. `source` is the file or folder that the message names.
Grid sectionGrid(const Grid& scan, double low_m, double high_m, double spacing_m,
                 const std::filesystem::path& source);

// Trilinear; air outside the scan.
CtVolume resampleCt(const CtVolume&, const Grid&);

// Sets everything outside the body to air without a label. Crops both volumes in-plane to the body and a rim.
// Leaves out slices at the ends in which the image contains a part of the body only, and notes it. Returns
// the body. Throws ImportError, which names `source`, if there is no body.
Mask cropToBody(CtVolume&, LabelVolume&, const std::filesystem::path& source,
                std::vector<std::string>& notes);

// Throws ImportError if a package with this grid could not be loaded again; the message names a spacing
// that fits.
void checkPackageSize(const Grid&);

// The distance between a scan's slices, on whichever axis they were taken.
double sliceDistance(const Grid& scan);

// Mask of the voxels whose label in targetTable() is wanted.
Mask labelMask(const LabelVolume&, const std::function<bool(const patient::Label&)>& wanted);
Mask labelMask(const LabelVolume&, std::string_view name);
// The same for another label table.
Mask labelMask(const LabelVolume&, const std::vector<patient::Label>& table,
               const std::function<bool(const patient::Label&)>& wanted);
// Sets the label of the mask's voxels. Voxels that already have a label are changed only if `over_all` is
// true. Returns the number of voxels changed.
std::size_t paint(LabelVolume&, const Mask& where, std::uint8_t id, bool over_all);

}  // namespace stylet::modeller
