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
// Along `inward` from a place on the skin or outside it, to where the liver begins. Empty if that is not
// within `length_m`.
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
    // Both ends of one track are numb.
    bool done() const noexcept { return missing() == Refusal::none; }
    bool begun() const noexcept { return fuller().skin_m3 + fuller().capsule_m3 > 0.0; }
    TrackPlace place() const noexcept { return place_; }  // of the needle's tip
    Refusal missing() const noexcept;
    // With the tip at an end of a track: the volume there that counts, and what is needed. Elsewhere zeros.
    std::pair<double, double> depotAtTip_m3() const noexcept;
    Refusal popRefusal() noexcept { return std::exchange(refusal_, Refusal::none); }

  private:
    struct Track {
        WallTrack points{};
        double skin_m3 = 0.0, capsule_m3 = 0.0;  // injected at its ends
    };

    static TrackPlace placeOn(const WallTrack&, const Vec3& tip_m) noexcept;
    void findPlace(const haptics::TickOutput&) noexcept;
    // The track with more local anaesthetic that counts.
    const Track& fuller() const noexcept;
    void addInjected(const haptics::TickOutput&, const patient::AnaestheticVolumes&);
    void judgeInjection(const patient::AnaestheticVolumes&, bool flows);

    const patient::Patient* patient_;
    std::array<Track, 2> tracks_;  // of the reference path, and of the parked probe's rail
    double length_m_;
    TrackPlace place_ = TrackPlace::outside;
    std::size_t at_ = 0;                           // the track that the tip is on, if it is on one
    double aside_m3_ = 0.0, beyond_m3_ = 0.0;      // injected beside every track; beyond the capsule
    patient::AnaestheticVolumes last_, at_start_;  // of the newest tick; as the newest injection began
    double aside_at_start_m3_ = 0.0, beyond_at_start_m3_ = 0.0, at_entry_m3_ = 0.0;
    bool flows_ = false, refused_ = false, parked_ = false, too_much_ = false;
    Refusal refusal_ = Refusal::none;
};

}  // namespace stylet::training
