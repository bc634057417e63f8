// The section of a scan that becomes a patient: resampled, cropped to the body, and within the package size
// limits.
#pragma once

#include <functional>
#include <string_view>

#include "app/modeller/voxel_tools.h"
#include "patient/tissue.h"

namespace stylet::modeller {

inline constexpr std::int16_t kOutside_hu = -1024;  // value of voxels outside the body

// An isotropic grid over the scan's heights from `low_m` to `high_m` and its whole width, plus a rim of
// air. Aligned to whole voxels from the scan's first voxel. Throws ImportError if the scan is wider than
// 0.5 m.
patient::Grid sectionGrid(const patient::Grid& scan, double low_m, double high_m, double spacing_m);

// Trilinear; air outside the scan.
patient::CtVolume resampleCt(const patient::CtVolume&, const patient::Grid&);

// Sets everything outside the body to air without a label, and crops both volumes in-plane to the body and
// a rim. Returns the body. Throws ImportError if there is no body.
Mask cutToBody(patient::CtVolume&, patient::LabelVolume&);

// Crops a volume to the voxels `low` to `high`, inclusive.
template <typename T>
void cropTo(patient::Volume<T>& v, const patient::Index3& low, const patient::Index3& high) {
    patient::Volume<T> out(patient::Grid{high - low + 1, v.grid.spacing_m, v.grid.centre(low)});
    for (int z = 0; z < out.grid.dims.z; ++z)
        for (int y = 0; y < out.grid.dims.y; ++y)
            for (int x = 0; x < out.grid.dims.x; ++x)
                out[{x, y, z}] = v[low + patient::Index3{x, y, z}];
    v = std::move(out);
}

// Throws ImportError if a package with this grid could not be loaded again; the message names a spacing
// that fits.
void checkFits(const patient::Grid&);

// Mask of the voxels whose label in targetTable() is wanted.
Mask maskOf(const patient::LabelVolume&, const std::function<bool(const patient::Label&)>& wanted);
Mask maskOf(const patient::LabelVolume&, std::string_view name);
// Sets the label of the mask's voxels: of all, or only of unlabelled ones. Returns the number of voxels
// changed.
std::size_t paint(patient::LabelVolume&, const Mask& where, std::uint8_t id, bool over_all);

}  // namespace stylet::modeller
