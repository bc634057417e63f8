#include "app/training/pain.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "base/transcendental.h"

namespace stylet::training {

using haptics::AccessStatus;
using haptics::TickOutput;
using patient::Anaesthetic;
using patient::Tissue;

namespace {

constexpr double kLouder = 1.0;  // a lasting stimulus is reported again if it hurts this much more

bool isOfLiver(Tissue tissue) noexcept {
    return tissue == Tissue::liver || tissue == Tissue::duct || tissue == Tissue::vessel;
}

}  // namespace

Pain::Pain(const patient::Patient& patient, double dt_s) noexcept
    : patient_(&patient), fade_(detExp(-dt_s / kPainFade_s)) {}

void Pain::update(const TickOutput& now, const Anaesthetic& anaesthetic) noexcept {
    event_.reset();
    now_ *= fade_;
    if (now_ < 0.5) cause_ = {}, reported_ = 0.0;
    followNeedle(now, anaesthetic);
    if (now.cut_incision >= 0)
        hurt(kIncisionPain,
             std::min(anaesthetic.numbness(now.cut.begin_reference_m),
                      anaesthetic.numbness(now.cut.end_reference_m)),
             "the incision");
    followTubes(now.access, anaesthetic);
}

// Entering the skin or the capsule hurts, once; lying there does not. What hurts at the capsule is the
// peritoneum on the wall, along which the liver slides.
void Pain::followNeedle(const TickOutput& now, const Anaesthetic& anaesthetic) noexcept {
    const bool inside = now.phase != haptics::Phase::outside && !now.access.open;
    const bool in_liver = inside && (now.tissue == Tissue::liver || (in_liver_ && isOfLiver(now.tissue)));
    if (inside && !inside_) hurt(kSkinPrick, anaesthetic.numbness(now.tip_reference_m), "the needle");
    if (in_liver && !in_liver_) {
        const Vec3 on_wall_m =
            patient::referenceFromDeformed(patient_->package().motion, now.breath, patient::Side::outside,
                                           now.patient_from_needle.position_m);
        hurt(kCapsulePain, anaesthetic.numbness(on_wall_m), "the puncture of the liver's capsule");
    }
    inside_ = inside, in_liver_ = in_liver;
}

void Pain::followTubes(const AccessStatus& access, const Anaesthetic& anaesthetic) noexcept {
    // A new needle makes a new track. A wire that is passed through the drain again does not.
    if (std::exchange(base_m_, access.base_m) != access.base_m) dilated_m_ = widened_m_ = 0.0;
    if (!access.open) return;
    const double track_m = glm::length(access.base_m - access.entry_m);
    if (access.dilator_m > dilated_m_) {
        dilated_m_ = access.dilator_m;
        widen(access, anaesthetic, dilated_m_, kDilatationPain, "the dilatation");
    }
    const double drain_m = std::min(access.drain_m, track_m);
    if (!(drain_m > widened_m_)) return;
    torn_m_ += drain_m - widened_m_;
    widen(access, anaesthetic, drain_m, kTearPain, "the drain in a track that was not dilated");
}

// A tip hurts while it widens the wall, that is outside the liver.
void Pain::widen(const AccessStatus& access, const Anaesthetic& anaesthetic, double depth_m, double strength,
                 std::string_view cause) noexcept {
    widened_m_ = std::max(widened_m_, depth_m);
    const Vec3 way_m = access.base_m - access.entry_m;
    const double length_m = glm::length(way_m);
    if (!(length_m > depth_m)) return;
    const Vec3 at_m = access.entry_m + way_m * (depth_m / length_m);
    if (!isOfLiver(patient_->at(at_m, {true, false}).tissue))
        hurt(strength, anaesthetic.numbness(at_m), cause);
}

void Pain::hurt(double strength, double numbness, std::string_view cause) noexcept {
    const double pain = strength * (1.0 - numbness);
    now_ = std::max(now_, pain);
    worst_ = std::max(worst_, pain);
    if (!(pain > kSkinPrick) || (cause == cause_ && pain < reported_ + kLouder)) return;
    cause_ = cause, reported_ = pain;
    event_ = PainEvent{pain, cause};
}

}  // namespace stylet::training
