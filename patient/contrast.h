// Contrast medium on its way through the patient: injected at the needle's tip, it fills the bile ducts up to
// what blocks them, stains the parenchyma, is washed away in a vessel, or stays where it has no business.
// Hashed: a fold over ticks, reference space, so that the picture breathes with the tissue.
//
// How each looks under the screen is what tells a trainee where the tip is (Dawood et al., Percutaneous
// Transhepatic Cholangiography Technique, Medscape 2022): ducts fill slowly toward the hilum, vessels show
// and are gone, the portal vein toward the periphery, hepatic veins toward the heart.
//   duct       nearest first by the way inside the tree, behind a front that mixing widens; bile stays behind
//              at the walls. A tree that is blocked fills up, then leaks into the parenchyma at the tip; one
//              that opens into the bowel runs out there.
//   liver      a ball of what fits between the cells, fading slowly
//   vessel     carried along by the blood, and thinned out exponentially
//   elsewhere  a pool that stays; outside the body it is lost
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patient/contrast_fill.h"
#include "patient/hash.h"
#include "patient/package.h"
#include "patient/vessel_flow.h"

namespace stylet::patient {

struct ContrastSettings {
    double iodine_kg_per_m3 = 150.0;  // mg I/ml
    // Of iodine at about 70 keV: 0.075 /mm at 150 mg I/ml (model, section 8).
    double attenuation_m2_per_kg = 0.5;
    double bile_share = 0.2;  // of a filled duct's volume: what the medium does not displace
    FrontShape duct_front{0.002, 0.1};
    FrontShape stain_front{0.002, 0.6};
    // What medium can enter: the liver's extracellular space (18 % in health, 30 % in fibrosis: Eur. Radiol.
    // Exp. 3:52, 2019), that of other tissue, hollow organs whole.
    double liver_porosity = 0.25, soft_porosity = 0.15, hollow_porosity = 1.0;
    double stain_fade_s = 120.0;    // ours: minutes
    double vessel_washout_s = 1.5;  // ours: two or three heart beats
    double new_place_m = 0.003;     // a tip that has moved further injects at a new place
    double most_m3_per_s = 20e-6;   // no hand and no needle gives more
};

// Where the tip of the last injection was.
enum class ContrastPlace : std::uint8_t { none, duct, liver, vessel, elsewhere, outside };

// What became of every drop; injected is the sum of the others.
struct ContrastVolumes {
    double injected_m3 = 0.0;
    double ducts_m3 = 0.0, liver_m3 = 0.0, vessels_m3 = 0.0, pooled_m3 = 0.0;
    double washed_out_m3 = 0.0;  // by blood, from vessels and parenchyma
    double lost_m3 = 0.0;        // outside the body
};

// For people and pictures. Trivially copyable.
struct ContrastStatus {
    ContrastVolumes volumes;
    ContrastPlace place = ContrastPlace::none;
    double rate_m3_per_s = 0.0;
    // Of the duct tree filled last: what it holds when full, how far the front has come.
    double tree_m3 = 0.0, front_m = 0.0;
    bool at_stop = false;        // the medium stands at what blocks the tree
    Vec3 stop_reference_m{0.0};  // where that is
};

struct ContrastInput {
    Vec3 tip_reference_m{0.0};
    double rate_m3_per_s = 0.0;
    bool inside = true;  // the needle is in the body
};

// A duct tree while it is filled: target-role duct voxels that hang together. A duct of another role (a
// stricture, a stone) is shut.
struct DuctTree {
    VoxelPiece piece;
    std::vector<double> base_m3;  // in each member from earlier places
    double base_total_m3 = 0.0;
    std::size_t root = 0;       // the member where this injection began
    std::vector<double> way_m;  // from there
    FillOrder order;            // of what is left to fill
    double filled_m3 = 0.0;     // since it began
    std::size_t stop = 0;       // the member at what blocks the tree: a tumour, a shut duct; else its widest
    std::vector<std::size_t> outlets;  // members at the bowel
    double held_m3() const { return base_total_m3 + filled_m3; }
    // In a member with the front at `front_m`, of `room_m3` that it can take in all.
    double heldBy(std::size_t member, double room_m3, const FrontShape& shape, double front_m) const {
        return base_m3[member] + (room_m3 - base_m3[member]) * shape.share(front_m, way_m[member]);
    }
};

// A stain in parenchyma, or a pool.
struct Stain {
    Tissue kind = Tissue::liver;  // liver, soft, air: the voxels it spreads over
    Vec3 centre_m{0.0};
    double spread_m3 = 0.0;  // all that came: how far it reaches
    double held_m3 = 0.0;    // all that is left
};

// Medium in a vessel, by the time since it left the tip.
struct Plume {
    static constexpr int kSteps = 128;
    static constexpr double kStep_s = 0.05;
    std::size_t vessel = 0;  // of Contrast::vessels()
    Vec3 tip_m{0.0};
    std::vector<std::uint8_t> step;        // of each member; kSteps where the blood does not go
    std::array<double, kSteps> room_m3{};  // voxels of that step
    std::array<double, kSteps> held_m3{};
    double since_step_s = 0.0;
    double total() const;
};

double voxelVolume_m3(const Grid&) noexcept;
// Share of a tissue that a stain of this kind can take.
double porosity(const ContrastSettings&, Tissue kind) noexcept;
// What a duct's voxel takes.
double ductRoom_m3(const ContrastSettings&, const Grid&) noexcept;
// Which kind of stain a voxel can be part of: liver, air (gas, lung, bowel), soft, or vessel and duct, which
// none spreads over.
Tissue stainKind(const Patient&, const Index3& voxel) noexcept;

class Contrast {
  public:
    explicit Contrast(const Patient&, const ContrastSettings& = {});

    // Session thread. One tick. Allocates where an injection begins at a new place, else not. Nonsense (NaN,
    // negative rates) is no injection.
    void step(const ContrastInput&, double dt_s);

    bool begun() const noexcept { return status_.volumes.injected_m3 > 0.0; }
    const ContrastVolumes& volumes() const noexcept { return status_.volumes; }
    const ContrastStatus& status() const noexcept { return status_; }
    std::uint64_t hash() const noexcept { return hash_.value(); }

    // What a picture is made from (contrast_table.h).
    const Patient& patient() const noexcept { return *patient_; }
    const ContrastSettings& settings() const noexcept { return settings_; }
    const std::vector<DuctTree>& ducts() const noexcept { return ducts_; }
    const std::vector<Stain>& stains() const noexcept { return stains_; }
    const std::vector<VesselTree>& vessels() const noexcept { return vessels_; }
    const std::vector<Plume>& plumes() const noexcept { return plumes_; }

  private:
    void inject(const Vec3& tip_m, bool inside, double amount_m3);
    void injectIntoDuct(const Vec3& tip_m, const Index3& voxel, double amount_m3);
    void injectIntoVessel(const Vec3& tip_m, const Index3& voxel, BloodKind, double amount_m3);
    void addStain(Tissue kind, const Vec3& at_m, double amount_m3);
    void fade(double dt_s);
    void flow(Plume&, double dt_s);
    void sum();
    void fold(const ContrastInput&);

    DuctTree& treeAt(const Index3& voxel);
    Plume* plumeAt(const Vec3& tip_m, const Index3& voxel, BloodKind);

    const Patient* patient_;
    ContrastSettings settings_;
    ContrastStatus status_;
    std::vector<DuctTree> ducts_;
    std::vector<Stain> stains_;
    std::vector<VesselTree> vessels_;
    std::vector<Plume> plumes_;
    double fade_dt_s_ = 0.0, stain_keeps_ = 1.0, plume_keeps_ = 1.0;  // over a tick
    StateHash hash_;
};

// Added attenuation, 1/m, on a box of the CT's grid: zero beyond it. What X-ray reads; made by
// contrast_table.h.
struct ContrastTable {
    Grid grid;                       // reference patient frame, voxels as the CT's
    std::vector<float> added_per_m;  // x-fastest; empty: no medium
    std::uint64_t revision = 0;      // grows with every change
};

// The voxels whose value has changed, for a table that another thread keeps.
struct ContrastChanges {
    Grid grid;
    bool whole = false;  // the box is a new one: everything not listed is zero
    std::uint64_t revision = 0;
    std::vector<std::uint32_t> offsets;  // in the box
    std::vector<float> added_per_m;
};
void apply(const ContrastChanges&, ContrastTable&);

}  // namespace stylet::patient
