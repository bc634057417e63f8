// How a tool displaces the tissue under it. For pictures only: camera view, ultrasound, X-ray. It is never
// hashed, so it is not part of patient.h. Forces and scores never read it: if the force used the displaced
// surface, the surface would follow the tool and the force would vanish. Model, section 6.
//
// Each contact sets the displacement of the tissue at a tool. Elsewhere in a small box the displacement
// follows from stiffness-weighted diffusion (diffusion.h). It is zero in bone and cartilage and at the border
// of the box; air moves freely. The result is the inverse map that renderers need: tissue_m = p -
// displacementAt(p), applied before breathing is undone.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/diffusion.h"
#include "patient/package/package.h"

namespace stylet::patient {

inline constexpr int kMaxContacts = 16;

// A ball of tissue, or a capsule along [begin, end], that moves with a tool. Patient frame, deformed by
// breathing only.
struct ToolContact {
    int id = 0;  // in [0, kMaxContacts), same in every frame; identifies the tissue that springs back
    Vec3 begin_m{0.0}, end_m{0.0};              // position of the tissue without the tool
    Vec3 begin_moved_m{0.0}, end_moved_m{0.0};  // displacement: tool minus tissue, linear in between
    // Radius of the patch. Raised to at least 1.5 times the displacement, to avoid folds, and 1.5 node
    // spacings, to avoid point loads.
    double radius_m = 0.004;
};

struct ToolDisplacementSettings {
    int nodes = 33;  // per side: 2^k + 1
    double spacing_m = 0.003;
    int cycles = 2;  // per frame, starting from the last frame's solution
    int sweeps = 1;
    double recoil_s = 0.060;  // released tissue springs back like exp(-t / recoil_s), and no faster
};

// Displacements on nodes, x-fastest, metres; w is unused. Linear between nodes, zero on the faces and
// outside.
struct DisplacementTable {
    Grid grid;
    // displacement of the tissue that is now at the node: current minus undisplaced position
    std::vector<glm::vec4> moved_m;
};
Vec3 displacementAt(const DisplacementTable&, const Vec3& p) noexcept;

// All functions: frame thread. Only the constructor allocates.
class ToolDisplacement {
  public:
    // The patient must outlive it.
    explicit ToolDisplacement(const Patient&, const ToolDisplacementSettings& = {});

    // Updates from the current contacts, `dt_s` after the last call. Returns false if nothing is
    // displaced; this costs almost nothing.
    bool update(std::span<const ToolContact>, const Surrogate& breath, double dt_s) noexcept;

    bool active() const noexcept { return active_; }
    // Only valid while active.
    const DisplacementTable& table() const noexcept { return table_; }
    // The forward solution: displacement of the tissue whose undisplaced position is the node.
    const Diffusion& forward() const noexcept { return diffusion_; }

  private:
    struct Slot {
        ToolContact contact;
        bool used = false;
    };
    void relax(std::span<const ToolContact>, double dt_s) noexcept;
    bool place() noexcept;
    void updateStiffness(const Surrogate& breath) noexcept;
    void pull() noexcept;
    void pull(const ToolContact&) noexcept;
    void invert() noexcept;

    const Patient* patient_;
    ToolDisplacementSettings settings_;
    Diffusion diffusion_;
    std::vector<float> bone_pull_;  // pull toward zero at bone
    DisplacementTable table_;
    std::array<Slot, kMaxContacts> slots_{};
    Surrogate tissue_breath_;  // breathing state for which the stiffness was looked up
    bool active_ = false;
};

}  // namespace stylet::patient
