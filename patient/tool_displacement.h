// Where a tool takes the tissue under it, for the eye only: pictures, ultrasound, X-ray. Forces and scores
// never read it and it never enters the hash (a force fed back through it would carry the surface along and
// vanish), so it is not part of patient.h. Model, section 6.
//
// Each contact says where a tool holds its tissue; between contacts, bone and the border of a small box the
// rest follows by stiffness-weighted diffusion (diffusion.h), air free. What comes out is the inverse map,
// which pictures read: tissue_m = p - displacementAt(p), the breath undone after it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "patient/diffusion.h"
#include "patient/package.h"

namespace stylet::patient {

inline constexpr int kMaxContacts = 16;

// A ball of tissue, or a capsule along [begin, end], that a tool has taken along. Patient frame, deformed by
// the breath alone.
struct ToolContact {
    int id = 0;  // the same from frame to frame, in [0, kMaxContacts): what springs back is known by it
    Vec3 begin_m{0.0}, end_m{0.0};              // where the tissue is without the tool
    Vec3 begin_moved_m{0.0}, end_moved_m{0.0};  // tool minus tissue, linear between
    // Of the patch. At least 1.5 times what it is moved by: no fold; and three halves of a node: no point
    // load.
    double radius_m = 0.004;
};

struct ToolDisplacementSettings {
    int nodes = 33;  // a side: 2^k + 1
    double spacing_m = 0.003;
    int cycles = 2;  // a frame, from the last frame's solution
    int sweeps = 1;
    double recoil_s = 0.060;  // tissue let go of springs back like exp(-t / recoil_s), and no faster
};

// x-fastest, metres, w unused. Linear between nodes, zero on the faces and beyond.
struct DisplacementTable {
    Grid grid;
    std::vector<glm::vec4> moved_m;  // of the tissue now at a node: now minus then
};
Vec3 displacementAt(const DisplacementTable&, const Vec3& p) noexcept;

// Frame thread, all. Allocates in the constructor only.
class ToolDisplacement {
  public:
    // The patient must outlive it.
    explicit ToolDisplacement(const Patient&, const ToolDisplacementSettings& = {});

    // What presses now, `dt_s` after the last call. False when nothing is displaced, which costs nothing.
    bool update(std::span<const ToolContact>, const Surrogate& breath, double dt_s) noexcept;

    bool active() const noexcept { return active_; }
    // Meaningless while not active.
    const DisplacementTable& table() const noexcept { return table_; }
    // The solution itself, of a node's own tissue: then to now.
    const Diffusion& forward() const noexcept { return diffusion_; }

  private:
    struct Slot {
        ToolContact contact;
        bool used = false;
    };
    void relax(std::span<const ToolContact>, double dt_s) noexcept;
    bool place() noexcept;
    void findTissue(const Surrogate& breath) noexcept;
    void pull() noexcept;
    void pull(const ToolContact&) noexcept;
    void invert() noexcept;

    const Patient* patient_;
    ToolDisplacementSettings settings_;
    Diffusion diffusion_;
    std::vector<float> held_;  // bone
    DisplacementTable table_;
    std::array<Slot, kMaxContacts> slots_{};
    Surrogate tissue_breath_;  // that the stiffness was looked up in
    bool active_ = false;
};

}  // namespace stylet::patient
