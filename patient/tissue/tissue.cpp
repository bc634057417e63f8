// Based on Mastmeyer et al. 2017, Algorithm 1.
#include "patient/tissue/tissue.h"

#include "base/errors.h"

namespace stylet::patient {

namespace {

Tissue classifyCt(double ct_hu, const Thresholds& t, TrackFlags flags) noexcept {
    if (ct_hu < t.t0_hu) return Tissue::air;
    // Past the skin this class is the partial-volume rim of gas and lung. Treating it as skin would create
    // a second membrane.
    if (ct_hu < t.t1_hu) return flags.past_skin ? Tissue::soft : Tissue::skin;
    return ct_hu < (flags.past_fascia ? t.t2_specific_hu : t.t2_sensitive_hu) ? Tissue::soft : Tissue::bone;
}

}  // namespace

std::optional<RoleConflict> findRoleConflict(const Label& l) noexcept {
    const bool heart = l.structure == Structure::heart;
    if (heart && l.tissue != Tissue::vessel)
        return RoleConflict{"structure", "the heart, but the tissue is not \"vessel\""};
    if ((l.structure == Structure::lung || l.structure == Structure::gas) && l.tissue != Tissue::air)
        return RoleConflict{"structure", "lung or gas, but the tissue is not \"air\""};
    if (l.structure == Structure::cartilage && l.tissue != Tissue::cartilage)
        return RoleConflict{"structure", "cartilage, but the tissue is not \"cartilage\""};
    if (l.blood != BloodKind::none && l.tissue != Tissue::vessel)
        return RoleConflict{"blood", "flows, but the tissue is not \"vessel\""};
    if (l.blood != BloodKind::none && heart)
        return RoleConflict{"blood", "flows in the heart, whose chambers have no flow: use \"none\""};
    if (l.blood == BloodKind::none && l.tissue == Tissue::vessel && !heart)
        return RoleConflict{"blood", "\"none\" in a vessel that is not the heart: use \"other\" if unknown"};
    if (l.blocks_contrast && l.tissue == Tissue::duct && l.role == Role::target)
        return RoleConflict{"blocks_contrast", "true for a duct that is a target, in which medium flows"};
    if (l.drains_ducts && l.tissue != Tissue::soft && l.tissue != Tissue::air)
        return RoleConflict{"drains_ducts", "true, but the tissue is neither \"soft\" nor \"air\""};
    if (l.drains_ducts && l.blocks_contrast)
        return RoleConflict{"drains_ducts", "true for a label that blocks contrast medium"};
    return std::nullopt;
}

Patient::Patient(const Package& package) : package_(&package) {
    for (const Label& label : package.label_table)
        palette_[label.id] = &label;
}

Patient::Patient(const Package& package, bool (*segmented)(const Label&)) : package_(&package) {
    for (const Label& label : package.label_table)
        if (segmented(label)) palette_[label.id] = &label;
}

TissueSample Patient::at(const Index3& i, TrackFlags flags) const noexcept {
    Tissue tissue = Tissue::air;
    if (grid().contains(i)) {
        const std::size_t offset = grid().offset(i);
        if (const Label* label = palette_[package_->labels.voxels[offset]])
            return {label->tissue, label->id, label->role};
        tissue = classifyCt(package_->ct.voxels[offset], package_->thresholds, flags);
    }
    if (tissue == Tissue::air) return {tissue, 0, flags.past_skin ? Role::risk : Role::pass};
    return {tissue, 0, row(tissue).role};
}

TrackFlags Patient::flagsAfterEntering(const TissueSample& entered, TrackFlags before) const noexcept {
    const Label* label = palette_[entered.label];
    const bool inside = entered.tissue == Tissue::liver || (label && label->abdominal);
    const bool in_air_or_skin = entered.tissue == Tissue::air || entered.tissue == Tissue::skin;
    return {before.past_skin || inside || !in_air_or_skin,
            before.past_fascia || inside || entered.tissue == Tissue::fascia};
}

}  // namespace stylet::patient
