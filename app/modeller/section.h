// The section of a scan that becomes a patient: resampled, cut to the body, no larger than a package takes.
#pragma once

#include <functional>
#include <string_view>

#include "app/modeller/voxel_tools.h"
#include "patient/tissue.h"

namespace stylet::modeller {

inline constexpr std::int16_t kOutside_hu = -1024;  // of voxels that are not body

// Isotropic: the scan's heights from `low_m` to `high_m`, its whole width and a rim of air; whole voxels from
// the scan's first one. Throws ImportError where it is wider than 0.5 m.
patient::Grid sectionGrid(const patient::Grid& scan, double low_m, double high_m, double spacing_m);

// Trilinear; air beyond the scan.
patient::CtVolume resampleCt(const patient::CtVolume&, const patient::Grid&);

// What is not body becomes air without a label, and both volumes shrink in the plane to the body and a rim.
// Returns the body. Throws ImportError where there is none.
Mask cutToBody(patient::CtVolume&, patient::LabelVolume&);

// Shrinks a volume to the voxels `low` to `high`.
template <typename T>
void cropTo(patient::Volume<T>& v, const patient::Index3& low, const patient::Index3& high) {
    patient::Volume<T> out(patient::Grid{high - low + 1, v.grid.spacing_m, v.grid.centre(low)});
    for (int z = 0; z < out.grid.dims.z; ++z)
        for (int y = 0; y < out.grid.dims.y; ++y)
            for (int x = 0; x < out.grid.dims.x; ++x)
                out[{x, y, z}] = v[low + patient::Index3{x, y, z}];
    v = std::move(out);
}

// Throws ImportError where a package of these voxels could not be loaded again; names the spacing that fits.
void checkFits(const patient::Grid&);

// The voxels with a wanted label of targetTable().
Mask maskOf(const patient::LabelVolume&, const std::function<bool(const patient::Label&)>& wanted);
Mask maskOf(const patient::LabelVolume&, std::string_view name);
// Gives the mask's voxels an id: all, or those without one. Returns how many.
std::size_t paint(patient::LabelVolume&, const Mask& where, std::uint8_t id, bool over_all);

}  // namespace stylet::modeller
