// The axial needle force in four phases, the needle's track, and the needle's lateral channel.
// Based on Mastmeyer, Fortmeier, Handels, "Evaluation of Direct Haptic 4D Volume Rendering of Partially
// Segmented Data for Liver Puncture Simulation", Sci. Rep. 2017, Algorithm 2 and Eqs. 1-8.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/hash.h"
#include "base/realtime.h"
#include "haptics/tools/incision.h"
#include "haptics/tools/tool.h"
#include "patient/patient.h"

namespace stylet::haptics {

using patient::Tissue;

struct NeedleSettings {
    double a1_share = 0.5;  // a1 = share * k_B, in [0, 1] (Eq. 1)
    // A border within this distance of a punctured border of the same kind does not tent. By default the
    // needle's outer diameter (instrument.h; 17 G).
    double cut_reach_m = 0.0015;
    // Friction relative to the force table, whose needle is the paper's of 17 G. By default the ratio of the
    // outer diameters, because friction is proportional to the wetted surface.
    double friction_scale = 1.0;
    double max_force_n = 22.0;  // limit of the force against bone
    double lateral_stiffness_n_per_m = 150.0;
    double lateral_force_n = 0.5;  // lateral force above which the channel is cut sideways
};

enum class Phase : std::uint8_t { outside, tenting, pass };

inline constexpr int kMaxQueuedBorders = 32;
inline constexpr int kMaxCutBorders = 128;

// A border between two tissues, reached at `reference_m`.
struct Border {
    Vec3 reference_m{0.0};
    Tissue from = Tissue::air, to = Tissue::air;
    std::uint8_t to_label = 0;
    double depth_m = 0.0;  // along the track from the skin
};

// A border that resists puncture (tenting). `depth_m` is measured from the tip's position when tenting began.
// That position differs from the border's rest position if the border was reached while another one was
// tenting. Negative: the tip has been withdrawn from the border and is in the tissue in front of it.
struct TentingBorder {
    Border border;
    double depth_m = 0.0;  // of the tip behind the border
    double a0_n = 0.0;     // force on arrival
};

struct CutBorder {
    Vec3 reference_m{0.0};
    Tissue to = Tissue::air;
};

struct NeedleState {
    Phase phase = Phase::outside;
    Tissue tissue = Tissue::air;  // tissue at the tip; while tenting, the tissue before the border
    std::uint8_t label = 0;
    double extension_m = 0.0;  // e: proxy behind the tip, signed (Eqs. 6-8); frozen while tenting
    double force_n = 0.0;      // axial, > 0 resists insertion
    double depth_m = 0.0;      // of the tip along the track from the skin's surface
    patient::TrackFlags track;
    double past_skin_depth_m = 0.0, past_fascia_depth_m = 0.0;  // depths at which the flags were set

    TentingBorder tenting;           // valid in phase `tenting`
    bool bone_over_tenting = false;  // `tenting` is bone, reached while `under_bone` was tenting
    TentingBorder under_bone;
    int queued_count = 0;  // borders passed while tenting, nearest first
    std::array<Border, kMaxQueuedBorders> queued{};
    int fold_count = 0;          // skin folds in front of the body that the shaft passes through
    Vec3 fold_reference_m{0.0};  // while `fold_count` > 0 outside the body: where the tip last left the skin
    int cut_count = 0;           // punctured borders are kept, in reference space
    std::array<CutBorder, kMaxCutBorders> cut{};
    // Hash of every punctured border ever stored, so that a tick need not hash the whole list again.
    StateHash cuts;

    Vec3 lateral_m{0.0};            // tip minus channel, across the axis, patient frame
    double lateral_cut_m = 0.0;     // total distance the channel was cut sideways
    Vec3 tip_deformed_m{0.0};       // of the last step
    Vec3 channel_reference_m{0.0};  // where tissue is looked up
    // Side of the cavity surface on which the channel point lies.
    patient::Side channel_side = patient::Side::outside;
    patient::LocalMotion channel_motion;  // breathing motion around the channel point
    patient::Surrogate breath;            // of the last step
    bool primed = false;                  // the first step has set the members above
};

enum class NeedleEventKind : std::uint8_t {
    border,     // reached; tenting begins
    puncture,   // a tenting border was punctured
    entry,      // a tissue was entered without tenting
    sideways,   // a border was crossed sideways, without tenting
    withdrawn,  // the needle left the skin: withdrawn, or advanced out through a corner of it
    overflow    // a fixed list was full and an entry was dropped
};

struct NeedleEvent {
    NeedleEventKind kind = NeedleEventKind::border;
    patient::Role role = patient::Role::pass;
    Border border;
    // Tip depth behind the border's rest position at puncture.
    double tenting_m = 0.0;
    // `force_after_n`: in the tissue just entered, before the next border is handled.
    double force_before_n = 0.0, force_after_n = 0.0;
};

// Events of one step. Overwritten by each step.
inline constexpr int kMaxStepEvents = 24;
struct NeedleEvents {
    int count = 0;
    int dropped = 0;
    std::array<NeedleEvent, kMaxStepEvents> list{};

    std::span<const NeedleEvent> all() const noexcept { return std::span(list).first(std::size_t(count)); }
    void add(const NeedleEvent& e) noexcept {
        if (count < kMaxStepEvents) {
            list[std::size_t(count++)] = e;
        } else {
            ++dropped;
        }
    }
};

// The patient at one breathing state. Stores references, so use it only within the tick.
struct BreathingPatient {
    const patient::Patient& patient;
    const patient::Surrogate& breath;
    const patient::DuctSpace* ducts = nullptr;  // for the guide wire; null: it finds no duct

    const patient::MotionModel& motion() const noexcept { return patient.package().motion; }
};
// Position and direction of the needle's shaft in the deformed patient.
struct NeedleShaft {
    Vec3 tip_m{0.0};
    Vec3 axis{0.0};  // unit vector INTO the body
};

// Haptics thread. noexcept, no allocation. Moves the needle to `NeedleShaft::tip_m` and handles every border
// along its path. Stores the axial force in the state; positive force resists insertion. At an incision the
// body's surface does not tent. Returns the force on the user's hand in the patient frame: the axial force
// plus the lateral spring's.
ToolForce stepNeedle(NeedleState&, const NeedleSettings&, const BreathingPatient&, const NeedleShaft&,
                     NeedleEvents&, const Incisions& incisions = {}) noexcept STYLET_NONBLOCKING;
// Haptics thread. Ends the track of a needle in the body without moving it through the tissue. Returns the
// event to report.
NeedleEvent drawOutNeedle(NeedleState&) noexcept STYLET_NONBLOCKING;
// Force on the needle, patient frame: -force * axis - lateral spring.
Vec3 needleForce(const NeedleState&, const NeedleSettings&, const Vec3& axis) noexcept STYLET_NONBLOCKING;
// Energy of the axial springs. In phase `pass` it is k e^2 / 2. While tenting it is that energy, frozen,
// plus the integral of Eq. 1 from the border to the tip.
double axialEnergy(const NeedleState&, const NeedleSettings&,
                   const patient::Patient&) noexcept STYLET_NONBLOCKING;
// Distance of the proxy behind the tip: the depth behind the border while tenting, e otherwise.
double proxyDistance(const NeedleState&) noexcept STYLET_NONBLOCKING;
void hashNeedle(StateHash&, const NeedleState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
