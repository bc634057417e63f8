// Contrast medium in the patient, injected at the needle tip. It fills the bile ducts up to a blockage,
// stains the parenchyma, is washed out of a vessel, or pools elsewhere.
// The state is hashed every tick. It is stored in the reference frame, so the picture moves with the tissue.
//
// The way the medium spreads in the X-ray image shows the trainee where the tip is (Dawood et al.,
// Percutaneous Transhepatic Cholangiography Technique, Medscape 2022): ducts fill slowly toward the hilum;
// vessels fill and clear quickly, the portal vein toward the periphery and the hepatic veins toward the
// heart.
//   duct       Fills in order of distance along the tree from the tip, behind a front that mixing widens.
//              Some bile stays at the walls. A blocked tree fills up, then leaks into the parenchyma at
//              the tip. A tree that touches the bowel drains there.
//   liver      Fills the extracellular space of a ball around the tip; fades slowly.
//   vessel     Carried along by the blood and diluted exponentially.
//   elsewhere  Stays as a pool. Outside the body it is lost.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/hash.h"
#include "patient/contrast/contrast_fill.h"
#include "patient/contrast/vessel_flow.h"
#include "patient/package/package.h"

namespace stylet::patient {

struct ContrastSettings {
    double iodine_kg_per_m3 = 150.0;  // mg I/ml
    // Mass attenuation of iodine at about 70 keV: 0.075 /mm at 150 mg I/ml (model, section 8).
    double attenuation_m2_per_kg = 0.5;
    double bile_share = 0.2;  // share of a filled duct's volume that stays bile
    FrontShape duct_front{0.002, 0.1};
    FrontShape stain_front{0.002, 0.6};
    // Share of the volume that medium can enter. In the liver this is the extracellular space (18 % in
    // health, 30 % in fibrosis: Eur. Radiol. Exp. 3:52, 2019), likewise in other soft tissue. Hollow organs
    // fill completely.
    double liver_porosity = 0.25, soft_porosity = 0.15, hollow_porosity = 1.0;
    double stain_fade_s = 120.0;    // own estimate: minutes
    double vessel_washout_s = 1.5;  // own estimate: two or three heart beats
    double new_place_m = 0.003;     // moving the tip farther than this starts an injection at a new place
    double max_m3_per_s = 20e-6;    // upper limit of the injection rate
};

// Tissue at the tip at the last injection.
enum class ContrastPlace : std::uint8_t { none, duct, liver, vessel, elsewhere, outside };

// Where the injected volume is now. injected_m3 is the sum of the other members.
struct ContrastVolumes {
    double injected_m3 = 0.0;
    double ducts_m3 = 0.0, liver_m3 = 0.0, vessels_m3 = 0.0, pooled_m3 = 0.0;
    double washed_out_m3 = 0.0;  // by blood, from vessels and parenchyma
    double lost_m3 = 0.0;        // outside the body
};

// For display and rendering. Trivially copyable.
struct ContrastStatus {
    ContrastVolumes volumes;
    ContrastPlace place = ContrastPlace::none;
    double rate_m3_per_s = 0.0;
    // Of the duct tree that was filled last: its capacity, and the distance of its front from the tip.
    double tree_m3 = 0.0, front_m = 0.0;
    bool at_blockage = false;        // the medium has reached the blockage
    Vec3 blockage_reference_m{0.0};  // position of the blockage
};

struct ContrastInput {
    Vec3 tip_reference_m{0.0};
    double rate_m3_per_s = 0.0;
    bool inside = true;  // the needle is in the body
};

// A duct tree being filled: connected voxels of duct labels with the role target. Ducts of another role (a
// stricture, a stone) are closed to the medium.
struct DuctTree {
    VoxelPiece piece;
    std::vector<double> base_m3;  // volume in each member from injections at earlier places
    double base_total_m3 = 0.0;
    std::size_t root = 0;              // member where the current injection began
    std::vector<double> path_m;        // distance of each member from the root along the tree
    FillOrder order;                   // members with room left, by distance
    double filled_m3 = 0.0;            // volume since the current injection began
    std::size_t blockage = 0;          // member at the blockage (tumour, closed duct), or else the widest one
    std::vector<std::size_t> outlets;  // members that touch the bowel
    double volume_m3() const { return base_total_m3 + filled_m3; }
    // Volume in a member whose capacity is `capacity_m3`, with the front at `front_m`.
    double memberVolume_m3(std::size_t member, double capacity_m3, const FrontShape& shape,
                           double front_m) const {
        return base_m3[member] + (capacity_m3 - base_m3[member]) * shape.share(front_m, path_m[member]);
    }
};

// A stain in parenchyma, or a pool.
struct Stain {
    Tissue kind = Tissue::liver;  // the tissue of the voxels that the stain spreads over: liver, soft or air
    Vec3 centre_m{0.0};
    double spread_m3 = 0.0;  // total volume injected; determines the extent
    double volume_m3 = 0.0;  // volume left
};

// How a list of stains grows: the share of the tissue's volume that is filled, and the distance from a
// stain's centre beyond which an injection outside the stain begins another one.
struct StainGrowth {
    double porosity = 1.0, new_place_m = 0.003;
};
// Adds a volume to the stain of its kind at a place, or begins a new stain. Stained tissue is full: what is
// injected there widens the stain. A full list widens a stain elsewhere. Returns false if no stain is of the
// kind.
bool addToStains(std::vector<Stain>&, const StainGrowth&, Tissue kind, const Vec3& at_m, double amount_m3);

// Medium in a vessel, sorted by travel time from the tip.
struct Plume {
    static constexpr int kSteps = 128;
    static constexpr double kStep_s = 0.05;
    std::size_t vessel = 0;  // index into Contrast::vessels()
    Vec3 tip_m{0.0};
    // travel-time step of each member; kSteps where the blood does not flow
    std::vector<std::uint8_t> step;
    std::array<double, kSteps> capacity_m3{};  // capacity: volume of the voxels of each step
    std::array<double, kSteps> volume_m3{};
    double since_step_s = 0.0;
    double total() const;
};

double voxelVolume_m3(const Grid&) noexcept;
// Share of the volume that a stain of this kind can fill.
double porosity(const ContrastSettings&, Tissue kind) noexcept;
// Volume of medium that a duct voxel can hold.
double ductCapacity_m3(const ContrastSettings&, const Grid&) noexcept;
// The tissue that determines how medium spreads in a voxel: liver, air (gas, lung, bowel) or soft. Vessel and
// duct are returned unchanged; no stain spreads over them.
Tissue stainTissue(const Patient&, const Index3& voxel) noexcept;

class Contrast {
  public:
    explicit Contrast(const Patient&, const ContrastSettings& = {});

    // Session thread. Advances by one tick. Allocates only when an injection begins at a new place. A rate
    // that is NaN or negative counts as no injection.
    void step(const ContrastInput&, double dt_s);

    bool begun() const noexcept { return status_.volumes.injected_m3 > 0.0; }
    const ContrastVolumes& volumes() const noexcept { return status_.volumes; }
    const ContrastStatus& status() const noexcept { return status_; }
    std::uint64_t hash() const noexcept { return hash_.value(); }

    // Input of the renderer (contrast_table.h).
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
    void updateVolumes();
    void updateHash(const ContrastInput&);

    DuctTree& findOrAddTree(const Index3& voxel);
    Plume* findOrAddPlume(const Vec3& tip_m, const Index3& voxel, BloodKind);

    const Patient* patient_;
    ContrastSettings settings_;
    ContrastStatus status_;
    std::vector<DuctTree> ducts_;
    std::vector<Stain> stains_;
    std::vector<VesselTree> vessels_;
    std::vector<Plume> plumes_;
    double fade_dt_s_ = 0.0, stain_decay_ = 1.0, plume_decay_ = 1.0;  // decay factors per tick
    StateHash hash_;
};

// Added attenuation [1/m] on a box of the CT's grid; zero outside the box. contrast_table.h creates it, the
// X-ray renderer reads it.
struct ContrastTable {
    Grid grid;                       // reference frame, voxels aligned with the CT's
    std::vector<float> added_per_m;  // x-fastest; empty without medium
    std::uint64_t revision = 0;      // increases with every change
};

// Voxels whose value has changed, for updating a table on another thread.
struct ContrastChanges {
    Grid grid;
    bool whole = false;  // the box has changed, so every voxel not listed is zero
    std::uint64_t revision = 0;
    std::vector<std::uint32_t> offsets;  // voxel offsets in the box
    std::vector<float> added_per_m;
};
void apply(const ContrastChanges&, ContrastTable&);

}  // namespace stylet::patient
