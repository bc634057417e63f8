// Blood flow: the velocity in every voxel of a labelled vessel, directed along its tree.
//   portal vein      tributaries and trunk toward the hilum, branches away from it
//   hepatic veins    toward the vena cava;  vena cava  toward the head;  arteries  away from the heart
// Mean speeds follow from the speed of the trunk by Murray's law (1926: flow ~ r^3, so speed ~ r). The
// profile across the lumen is parabolic (Poiseuille). Trunks: portal vein 0.18 m/s (16-20 cm/s: AASLD;
// 19.6 +- 2.6: Zironi et al. 1992), hepatic veins 0.20, vena cava 0.25, aorta 0.30 over a heart beat
// (Abu-Yousef 1992; Scheinfeld et al. 2009, RadioGraphics 29:2081). The heart's chambers have no flow.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/geodesic.h"
#include "patient/package/package.h"

namespace stylet::patient {

struct VesselFlowSettings {
    // Mean over the lumen and the heart beat at the widest place of the tree, by kind.
    std::array<double, kBloodKindCount> trunk_m_per_s{0.0, 0.18, 0.20, 0.25, 0.30, 0.15};
    double slowest_share = 0.2;  // lowest speed, in the thinnest branch, as a share of the trunk's
};

// One connected vessel. Vectors are indexed by the members of `piece`.
struct VesselTree {
    BloodKind kind = BloodKind::none;
    VoxelPiece piece;
    std::vector<double> along_m;       // increases in the direction of flow
    std::vector<double> radius_m;      // of the lumen
    std::vector<double> wall_m;        // distance to the wall
    std::vector<double> mean_m_per_s;  // over the lumen
    Vec3 root_m{0.0};                  // origin of along_m: hilum, mouth or end of the trunk
};
// Bit-equal on every machine, because the hashed contrast state depends on it. `piece` must have one
// label. Any thread.
VesselTree makeVesselTree(const Patient&, BloodKind, VoxelPiece piece, const VesselFlowSettings& = {});
// Unit vector in the direction of flow at a member; zero if it is undetermined.
Vec3 bloodDirection(const VesselTree&, std::size_t member);

// True if the voxel or one of its 26 neighbours has a label accepted by `wanted`.
bool touches(const Patient&, const Index3& voxel, const std::function<bool(const Label&)>& wanted);

// Flow of all vessels, for rendering. Covers a box around liver and vessels, with voxels aligned to the CT's.
// The format is that of a 3D image with four signed normalised 16-bit numbers. xyz: mean velocity over the
// beat in the reference frame, velocity = xyz / 32767 * scale_m_per_s. w: kBloodKindStep * BloodKind, 0
// without blood.
inline constexpr int kBloodKindStep = 6000;
struct VesselFlow {
    Grid grid;
    double scale_m_per_s = 1.0;
    std::vector<std::array<std::int16_t, 4>> velocity;  // x-fastest; empty if no vessel is labelled

    BloodKind kindAt(const Index3& i) const noexcept {
        return BloodKind(velocity[grid.offset(i)][3] / kBloodKindStep);
    }
    // Mean velocity at the nearest voxel; zero outside the box.
    Vec3 meanAt_m_per_s(const Vec3& reference_m) const noexcept;
};
VesselFlow makeVesselFlow(const Patient&, const VesselFlowSettings& = {}, int threads = 2);

// The heart beat: factor on the mean velocity at time t. It is negative during backward flow, and its mean
// over a beat is 1. Portal vein: nearly steady. Hepatic veins and cava: two forward waves (S, D) and a short
// backward one (a). Arteries: a systolic rise over diastolic flow (resistive index 0.7). Any thread.
// noexcept.
double pulse(BloodKind, double t_s, double beats_per_s = 1.17) noexcept;

}  // namespace stylet::patient
