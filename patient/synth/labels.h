// Label ids of the reference patient, and their appearance in the CT.
#pragma once

#include <cstdint>
#include <initializer_list>

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
constexpr bool holds(IdSet set, std::uint8_t id) noexcept {
    return (set >> id & 1u) != 0;
}

// CT values of one label. A voxel's detail (0..255) blends from `low_hu` to `high_hu`. Then the whole
// label is shifted so that its mean in the finished image (blurred, noisy) is `mean_hu`.
struct CtRow {
    double mean_hu;          // over the label's voxels; sources in README.md
    double low_hu, high_hu;  // at detail 0 and 255
    double texture_hu;       // amplitude of the texture, a few millimetres in size
};
const CtRow& ctRow(Id) noexcept;

}  // namespace stylet::patient::synth
