// Label ids of the reference patient, and their appearance in the CT.
#pragma once

#include <cstdint>
#include <initializer_list>

#include "base/geodesic.h"

namespace stylet::patient::synth {

enum class Id : std::uint8_t {
    air,
    skin,
    fat,
    muscle,
    fascia,
    visceralFat,
    ribsRight,
    ribsLeft,
    cartilage,
    spine,
    spinalCanal,
    sternum,
    lungRight,
    lungLeft,
    diaphragm,
    heart,
    aorta,
    cava,
    liver,
    portal,
    hepaticVeins,
    ducts,
    gallbladder,
    tumour,
    spleen,
    pancreas,
    kidneyRight,
    kidneyLeft,
    stomach,
    colon,
    bowel,
    gas,
    count
};
inline constexpr int kIdCount = int(Id::count);

// A set of ids, as a bit mask.
using IdSet = std::uint64_t;
constexpr IdSet only(Id id) noexcept {
    return IdSet(1) << int(id);
}
constexpr IdSet anyOf(std::initializer_list<Id> ids) noexcept {
    IdSet set = 0;
    for (Id id : ids)
        set |= only(id);
    return set;
}
constexpr bool contains(IdSet set, std::uint8_t id) noexcept {
    return (set >> id & 1u) != 0;
}

// Organs that must be in one piece.
inline constexpr IdSet kConnectedOrgans =
    anyOf({Id::lungRight, Id::lungLeft, Id::heart, Id::aorta, Id::cava, Id::liver, Id::portal,
           Id::hepaticVeins, Id::ducts, Id::gallbladder, Id::tumour, Id::spleen, Id::pancreas,
           Id::kidneyRight, Id::kidneyLeft, Id::stomach, Id::colon, Id::bowel, Id::diaphragm});

// The set in the form that base/geodesic.h uses.
LabelSet labelSet(IdSet);

// CT values of one label. A voxel's detail (0..255) blends from `low_hu` to `high_hu`. Then the whole
// label is shifted so that its mean in the finished image (blurred, noisy) is `mean_hu`.
struct CtRow {
    double mean_hu;          // over the label's voxels; sources in README.md
    double low_hu, high_hu;  // at detail 0 and 255
    double texture_hu;       // amplitude of the texture, a few millimetres in size
};
const CtRow& ctRow(Id) noexcept;

}  // namespace stylet::patient::synth
