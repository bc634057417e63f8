// Based on Mastmeyer et al. 2017, Algorithm 1. Calls Patient::at() for each code, so that the algorithm is
// implemented only once.
#include "patient/package/tissue_map.h"

#include <optional>

namespace stylet::patient {
namespace {

// Number of the CT class, in ascending HU. Includes both thresholds for bone.
int ctClassNumber(double ct_hu, const Thresholds& t) noexcept {
    return int(ct_hu >= t.t0_hu) + int(ct_hu >= t.t1_hu) + int(ct_hu >= t.t2_sensitive_hu) +
           int(ct_hu >= t.t2_specific_hu);
}

}  // namespace

TissueMap::TissueMap(const Patient& patient)
    : grid_(patient.grid()), tissues_(patient.package().tissues), codes_(grid_.voxelCount()) {
    const Package& package = patient.package();
    std::array<std::optional<Code>, 256> of_label;
    std::array<std::optional<Code>, 5> of_class;
    std::size_t count = 0;
    const auto add = [&](std::optional<Code>& code, const Index3& voxel) {
        if (count > 255)
            throw DataError(package.name, "labels",
                            "more than 250 labels are in use; a tissue map distinguishes 256 kinds of voxel");
        code = Code(count++);
        for (const TrackFlags flags : kAllTrackFlags) {
            const TissueSample sample = patient.at(voxel, flags);
            entries_[flagBits(flags)][*code] = {sample, patient.flagsAfterEntering(sample, flags)};
        }
    };
    std::optional<Code> outside;
    add(outside, Index3(-1));

    forEachVoxel(grid_, [&](const Index3& i) {
        const std::size_t at = grid_.offset(i);
        const std::uint8_t label = package.labels.voxels[at];
        std::optional<Code>& code =
            patient.label(label)
                ? of_label[label]
                : of_class[std::size_t(ctClassNumber(package.ct.voxels[at], package.thresholds))];
        if (!code) add(code, i);
        codes_[at] = *code;
    });
}

}  // namespace stylet::patient
