// Local anaesthetic in the patient, injected at the needle tip. In tissue it stays as depots, each a ball of
// its volume that pushes the tissue apart. In a vessel the blood carries it away; in a duct, in air or
// outside the body it is lost. A depot is a stain (contrast.h): in the reference frame, so it moves with the
// tissue.
//
// A depot numbs the tissue that its volume can soak: the ball of V / soaked_share. Beyond it the effect falls
// to nothing within half its radius. It acts at once and does not wear off: infiltrated lidocaine acts within
// a few minutes and lasts half an hour to two hours (product label of lidocaine hydrochloride injection,
// FDA), an attempt takes minutes.
#pragma once

#include <cstdint>
#include <vector>

#include "base/hash.h"
#include "patient/contrast/contrast.h"

namespace stylet::patient {

struct AnaestheticSettings {
    double max_m3_per_s = 2e-6;  // upper limit of the injection rate
    double new_place_m = 0.003;  // as in ContrastSettings
    double soaked_share = ContrastSettings{}.soft_porosity;
    double fade_share = 0.5;  // share of the numb ball's radius over which the effect falls to nothing
};

// Where the injected volume went. injected_m3 is the sum of the other members.
struct AnaestheticVolumes {
    double injected_m3 = 0.0;
    double tissue_m3 = 0.0;  // in depots
    double vessels_m3 = 0.0;
    double lost_m3 = 0.0;
};

struct AnaestheticInput {
    Vec3 tip_reference_m{0.0};
    double rate_m3_per_s = 0.0;
    Tissue tissue = Tissue::air;  // at the tip
};

// Radius of a depot of this volume.
double depotRadius_m(double volume_m3) noexcept;

class Anaesthetic {
  public:
    explicit Anaesthetic(const AnaestheticSettings& settings = {}) : settings_(settings) {}

    // Session thread. Advances by one tick. A rate that is NaN or negative counts as no injection.
    void step(const AnaestheticInput&, double dt_s);

    bool begun() const noexcept { return volumes_.injected_m3 > 0.0; }
    const AnaestheticVolumes& volumes() const noexcept { return volumes_; }
    const std::vector<Stain>& depots() const noexcept { return depots_; }
    // How numb the tissue at a place is: 0 not at all, 1 completely.
    double numbness(const Vec3& reference_m) const noexcept;
    std::uint64_t hash() const noexcept { return hash_.value(); }

  private:
    AnaestheticSettings settings_;
    AnaestheticVolumes volumes_;
    std::vector<Stain> depots_;
    StateHash hash_;
};

}  // namespace stylet::patient
