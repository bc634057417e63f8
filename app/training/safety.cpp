#include "app/training/safety.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <span>
#include <utility>

namespace stylet::training {

using haptics::TickOutput;
using patient::BloodKind;
using patient::Label;
using patient::Structure;
using patient::Tissue;

void SafetyWatch::update(const TickOutput& now, const TickFacts& facts) noexcept {
    if (!facts.inside) {
        in_vessel_ = in_liver_ = false;
        return;
    }
    if (const auto error = findError(now)) add(*error);
    followVessel(now, now.tissue == Tissue::vessel);
    countCapsule(now);
}

void SafetyWatch::judgeDose(const patient::AnaestheticVolumes& given) noexcept {
    if (given.tissue_m3 + given.vessels_m3 > kMaxAnaesthetic_m3 || given.vessels_m3 > kMaxInVessel_m3)
        add(CriticalError::overdose);
}

void SafetyWatch::judgeWire(const haptics::AccessStatus& access, bool proven) noexcept {
    if (access.wire_in && access.wire_m > kBlindWire_m && !proven) add(CriticalError::blindWire);
}

// The error of being where the tip is now.
std::optional<CriticalError> SafetyWatch::findError(const TickOutput& now) const noexcept {
    const Label* label = patient_->label(now.label);
    if (!label)
        return now.tissue == Tissue::air && now.depth_m > kGasDepth_m ? std::optional(CriticalError::lung)
                                                                      : std::nullopt;
    if (label->role != patient::Role::risk) return std::nullopt;
    if (label->blood == BloodKind::artery || label->blood == BloodKind::cava)
        return CriticalError::majorVessel;
    switch (label->structure) {
        case Structure::lung:
            return CriticalError::lung;
        case Structure::heart:
            return CriticalError::majorVessel;
        case Structure::gallbladder:
            return CriticalError::gallbladder;
        case Structure::stomach:
        case Structure::colon:
        case Structure::small_bowel:
        case Structure::gas:
            return CriticalError::bowel;
        default:
            return std::nullopt;
    }
}

void SafetyWatch::followVessel(const TickOutput& now, bool in_vessel) noexcept {
    if (!std::exchange(in_vessel_, in_vessel)) vessel_entry_m_ = now.tip_reference_m;
    if (in_vessel && glm::length(now.tip_reference_m - vessel_entry_m_) >= kMajorVessel_m)
        add(CriticalError::majorVessel);
}

void SafetyWatch::countCapsule(const TickOutput& now) noexcept {
    // Ducts and vessels of the liver are inside its capsule.
    const bool within = now.tissue == Tissue::liver ||
                        (in_liver_ && (now.tissue == Tissue::duct || now.tissue == Tissue::vessel));
    if (std::exchange(in_liver_, within) || !within || punctures_ > kMaxCapsulePunctures) return;
    const std::span known(holes_m_.data(), std::size_t(punctures_));
    if (std::any_of(known.begin(), known.end(), [&](const Vec3& hole_m) {
            return glm::length(hole_m - now.tip_reference_m) <= kSameHole_m;
        }))
        return;
    holes_m_[std::size_t(punctures_++)] = now.tip_reference_m;
    if (punctures_ > kMaxCapsulePunctures) add(CriticalError::capsule);
}

}  // namespace stylet::training
