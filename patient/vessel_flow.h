// Where the blood goes: the velocity in every voxel of a labelled vessel, along the way inside its tree.
//   portal vein      tributaries and trunk toward the hilum, branches away from it
//   hepatic veins    toward the vena cava;  vena cava  toward the head;  arteries  away from the heart
// Mean speeds follow Murray's law (1926: flow ~ r^3, so speed ~ r) from that of the trunk; across the lumen
// they are parabolic (Poiseuille). Trunks: portal vein 0.18 m/s (16-20 cm/s: AASLD; 19.6 +- 2.6: Zironi et
// al. 1992), hepatic veins 0.20, vena cava 0.25, aorta 0.30 over a heart beat (Abu-Yousef 1992; Scheinfeld et
// al. 2009, RadioGraphics 29:2081). The heart's chambers are left out.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "patient/geodesic.h"
#include "patient/package.h"

namespace stylet::patient {

// other: a vessel whose label does not say which; its blood goes from the widest place to the thin ends.
enum class BloodKind : std::uint8_t { none, portal, hepatic, cava, artery, other };
inline constexpr int kBloodKindCount = 6;

// By tissue and name: the reference patient's names, which imports use too.
BloodKind bloodKindOf(const Label&);

struct VesselFlowSettings {
    // Mean over the lumen and the beat, in the widest place of the tree, by kind.
    std::array<double, kBloodKindCount> trunk_m_per_s{0.0, 0.18, 0.20, 0.25, 0.30, 0.15};
    double slowest_share = 0.2;  // of it, in the thinnest twig
};

// One vessel that hangs together, members as in its piece.
struct VesselTree {
    BloodKind kind = BloodKind::none;
    VoxelPiece piece;
    std::vector<double> along_m;       // grows the way the blood goes
    std::vector<double> radius_m;      // of the lumen
    std::vector<double> wall_m;        // distance to the wall
    std::vector<double> mean_m_per_s;  // over the lumen
    Vec3 root_m{0.0};                  // hilum, mouth or trunk's end: where the way begins
};
// Hashed (contrast reads it): same bits everywhere. `piece` is of one label. Any thread.
VesselTree makeVesselTree(const Patient&, BloodKind, VoxelPiece piece, const VesselFlowSettings& = {});
// Unit vector the way the blood goes at a member, zero where the tree does not tell.
Vec3 bloodDirection(const VesselTree&, std::size_t member);

// Whether a voxel or one of its 26 neighbours bears a label of this kind.
bool touches(const Patient&, const Index3& voxel, const std::function<bool(const Label&)>& wanted);

// Of all vessels, for pictures. A box around liver and vessels, voxels as the CT's. Fit for a 3D image of
// four signed normalised 16-bit numbers: velocity = xyz / 32767 * scale_m_per_s in the reference frame, mean
// over the beat; w = kBloodKindStep * BloodKind, 0 where no blood is.
inline constexpr int kBloodKindStep = 6000;
struct VesselFlow {
    Grid grid;
    double scale_m_per_s = 1.0;
    std::vector<std::array<std::int16_t, 4>> velocity;  // x-fastest; empty: no vessel is labelled

    BloodKind kindAt(const Index3& i) const noexcept {
        return BloodKind(velocity[grid.offset(i)][3] / kBloodKindStep);
    }
    // Nearest voxel; zero beyond the box.
    Vec3 meanAt_m_per_s(const Vec3& reference_m) const noexcept;
};
VesselFlow makeVesselFlow(const Patient&, const VesselFlowSettings& = {}, int threads = 2);

// The heart's part: factor on the mean velocity at t, below zero where it flows back; mean over a beat 1.
// Portal nearly steady, hepatic veins and cava in two forward waves (S, D) and a short one back (a), arteries
// a systolic rise over diastolic flow (resistive index 0.7). Any thread. noexcept.
double pulse(BloodKind, double t_s, double beats_per_s = 1.17) noexcept;

}  // namespace stylet::patient
