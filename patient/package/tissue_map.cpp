// Based on Mastmeyer et al. 2017, Algorithm 1. Calls Patient::at() for each code, so that the rule exists
// only once.
#include "patient/package/tissue_map.h"

#include <optional>

namespace stylet::patient {
namespace {

// Number of the CT class, in ascending HU. Includes both thresholds for bone.
int classNumberOf(double ct_hu, const Thresholds& t) noexcept {
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
                            "more than 250 of them are in use: a tissue map tells 256 kinds apart");
        code = Code(count++);
        for (const bool past_skin : {false, true}) {
            for (const bool past_fascia : {false, true}) {
                const TrackFlags flags{past_skin, past_fascia};
                const TissueSample sample = patient.at(voxel, flags);
                entries_[flagBits(flags)][*code] = {sample, patient.flagsAfterEntering(sample, flags)};
            }
        }
    };
    std::optional<Code> outside;
    add(outside, Index3(-1));

    std::size_t at = 0;
    for (Index3 i{0}; i.z < grid_.dims.z; ++i.z) {
        for (i.y = 0; i.y < grid_.dims.y; ++i.y) {
            for (i.x = 0; i.x < grid_.dims.x; ++i.x, ++at) {
                const std::uint8_t label = package.labels.voxels[at];
                std::optional<Code>& code =
                    patient.label(label)
                        ? of_label[label]
                        : of_class[std::size_t(classNumberOf(package.ct.voxels[at], package.thresholds))];
                if (!code) add(code, i);
                codes_[at] = *code;
            }
        }
    }
}

}  // namespace stylet::patient
