// Local anaesthesia of the track: where the needle's tip is on the way from the skin to the liver's capsule,
// and how much local anaesthetic lies at both ends of it. Derived from the ticks, one after another.
//
// The skin and the liver's capsule hurt (with the parietal peritoneum on it), and so do the muscles between;
// the liver itself does not. So the standards ask for a wheal in the skin and an infiltration down to the
// capsule (CIRSE, Das et al. 2021; SIR, Saad et al. 2010).
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "app/training/metric_table.h"

namespace stylet::training {

// Least volumes at the two ends: own estimates, of the 10 ml that a track commonly gets.
inline constexpr double kWheal_m3 = 0.5e-6, kCapsuleDepot_m3 = 2e-6;
// Of lidocaine 1 %. More is refused; safety.h has the dose that fails an exam.
inline constexpr double kUsualAnaesthetic_m3 = 20e-6;

// A straight line through the body wall: points of the tissue, 1 mm apart, from the skin to the capsule.
using WallTrack = std::vector<Vec3>;
// Along `inward` from a place on the skin or outside it. Ends where the liver begins, or after `length_m`.
WallTrack makeWallTrack(const patient::Patient&, const patient::Surrogate&, const Vec3& from_m,
                        const Vec3& inward, double length_m);
// Depth of the liver's capsule along a planned path.
double capsuleDepth_m(const patient::Patient&, const patient::PlannedPath&);

class Infiltration {
  public:
    // `patient` must outlive this object.
    Infiltration(const patient::Patient& patient, const patient::PlannedPath&);

    // Session thread. Processes the next tick, which the fold must already contain.
    void update(const haptics::TickOutput&, const AttemptFold&, const haptics::GuideSettings&);
    bool done() const noexcept { return skin_m3_ >= kWheal_m3 && capsule_m3_ >= kCapsuleDepot_m3; }
    bool begun() const noexcept { return skin_m3_ + capsule_m3_ > 0.0; }
    TrackPlace place() const noexcept { return place_; }  // of the needle's tip
    Refusal missing() const noexcept;
    Refusal popRefusal() noexcept { return std::exchange(refusal_, Refusal::none); }

  private:
    TrackPlace findPlace(const haptics::TickOutput&) const noexcept;
    void addInjected(const patient::AnaestheticVolumes&);
    void judgeInjection(const patient::AnaestheticVolumes&, bool flows);

    const patient::Patient* patient_;
    std::array<WallTrack, 2> tracks_;  // of the reference path, and of the parked probe's rail
    double length_m_;
    TrackPlace place_ = TrackPlace::outside;
    double skin_m3_ = 0.0, capsule_m3_ = 0.0, aside_m3_ = 0.0;
    patient::AnaestheticVolumes last_, at_start_;  // of the newest tick; as the newest injection began
    double aside_at_start_m3_ = 0.0, at_entry_m3_ = 0.0;
    bool flows_ = false, refused_ = false, parked_ = false, too_much_ = false;
    Refusal refusal_ = Refusal::none;
};

}  // namespace stylet::training
