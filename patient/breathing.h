// Breathing: the motion that a surrogate signal v(t) drives.
// Based on Wilms et al. 2014 (regression of stationary velocity fields on a surrogate and its derivative),
// w(x,t) = a1(x) v(t) + a2(x) v'(t), forward exp(w), inverse exp(-w), two fields with a sliding interface.
#pragma once

#include <vector>

#include "patient/geometry.h"
#include "patient/signal.h"

namespace stylet::patient {

// A closed surface rho = 1 around the moving organs: ellipses stacked along z, linear between knots.
struct CavityKnot {
    double z_m = 0.0;
    double x_m = 0.0, y_m = 0.0;    // centre
    double rx_m = 0.1, ry_m = 0.1;  // half-axes
    friend bool operator==(const CavityKnot&, const CavityKnot&) = default;
};

// Motion in closed form. In the cavity's own coordinates (rho, phi, z) everything moves along z at constant
// rho and phi, so the interface maps onto itself and the two sides may slide: inside by z' = (a1 v + a2 v')
// bump(z), outside by `outside_share` of it, fading to zero at rho = fade_rho. bump is 1 between z_full_low
// and z_full_high and falls smoothly (C1) to 0 at z_low and z_high.
struct BreathingModel {
    double a1_m = 0.0;    // cranio-caudal travel from end-exhale to end-inhale, negative = caudal
    double a2_m_s = 0.0;  // hysteresis: metres per (1/s)
    double outside_share = 0.0;
    double fade_rho = 1.6;
    double z_low_m = 0.0, z_full_low_m = 0.0, z_full_high_m = 0.0, z_high_m = 0.0;
    std::vector<CavityKnot> cavity;  // ascending z; empty = the patient does not breathe
    Surrogate reference;             // the breath in which the CT was taken
    BreathingSignal signal;
    friend bool operator==(const BreathingModel&, const BreathingModel&) = default;
};

// exp(w)(p) and exp(-w)(p) for the difference between `now` and the model's reference breath, by four
// midpoint steps. The inverse tries inside, accepts if the pre-image lies inside, else outside; both sides
// keep rho, so this choice leaves no gap and no overlap. Any thread. noexcept, no allocation, about 0.1 us.
Vec3 deformedFromReference(const BreathingModel&, const Surrogate& now, const Vec3& reference_m) noexcept;
Vec3 referenceFromDeformed(const BreathingModel&, const Surrogate& now, const Vec3& deformed_m) noexcept;

// rho of the cavity at p: < 1 inside. Infinity when there is no cavity or p is off its z range.
double cavityRho(const BreathingModel&, const Vec3& p) noexcept;

// How much of the outside's motion is left at rho: 1 at the interface, smoothly 0 from fade_rho.
double outsideFade(const BreathingModel&, double rho) noexcept;

// For pictures: the same motion as a table over z of the DEFORMED patient: entry i is the reference z of the
// plane z_i = z_begin + i * dz, on each side, the outside at its interface. Linear between entries, identity
// beyond the table; outside, z blends towards the table by outsideFade(rho). A picture applies (rho, phi)
// unchanged. No motion: empty.
struct BreathingTable {
    double z_begin_m = 0.0, dz_m = 0.0;
    std::vector<float> inside_reference_z_m, outside_reference_z_m;
};
BreathingTable breathingTable(const BreathingModel&, const Surrogate& now, int entries);

}  // namespace stylet::patient
