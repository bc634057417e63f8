// The axial needle force in four phases, with the needle's track and its sideways channel.
// Based on Mastmeyer, Fortmeier, Handels, "Evaluation of Direct Haptic 4D Volume Rendering of Partially
// Segmented Data for Liver Puncture Simulation", Sci. Rep. 2017, Algorithm 2 and Eqs. 1-8.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/incision.h"
#include "haptics/realtime.h"
#include "haptics/tool.h"
#include "patient/patient.h"

namespace stylet::haptics {

using patient::Pose;
using patient::Quat;
using patient::Tissue;
using patient::Vec3;

struct NeedleSettings {
    double a1_share = 0.5;        // a1 = share * k_B, in [0, 1] (Eq. 1)
    double cut_reach_m = 0.0015;  // a border this near to its like already cut does not hold (17 G)
    double max_force_n = 22.0;    // where the force against bone ends
    double lateral_stiffness_n_per_m = 150.0;
    double lateral_force_n = 0.5;  // where the channel is cut sideways
};

enum class Phase : std::uint8_t { outside, held, pass };

inline constexpr int kMaxQueuedBorders = 32;
inline constexpr int kMaxCutBorders = 128;

// A border between two tissues, met at `reference_m`.
struct Border {
    Vec3 reference_m{0.0};
    Tissue from = Tissue::air, to = Tissue::air;
    std::uint8_t to_label = 0;
    double depth_m = 0.0;  // along the track from the skin
};

// A border that holds the needle back. For a border pushed ahead (met while another one held) the depth
// counts from where the tip was then. Below zero the tip has been drawn back from it and is in the tissue
// before it.
struct Hold {
    Border border;
    double depth_m = 0.0;  // of the tip behind the border
    double a0_n = 0.0;     // the force on arrival
};

struct CutBorder {
    Vec3 reference_m{0.0};
    Tissue to = Tissue::air;
};

struct NeedleState {
    Phase phase = Phase::outside;
    Tissue tissue = Tissue::air;  // what the tip is in (behind a held border: the tissue being left)
    std::uint8_t label = 0;
    double extension_m = 0.0;  // e in `tissue`: proxy behind tip, signed (Eqs. 6-8); still while held
    double force_n = 0.0;      // axial, > 0 resists insertion
    double depth_m = 0.0;      // tip along the track from the skin's surface
    patient::TrackFlags track;
    double past_skin_depth_m = 0.0, past_fascia_depth_m = 0.0;  // where the flags were set

    Hold hold;                    // phase held
    bool bone_over_hold = false;  // `hold` is bone, met while `under_bone` held
    Hold under_bone;
    int queued_count = 0;  // borders passed while held, nearest first
    std::array<Border, kMaxQueuedBorders> queued{};
    int cut_count = 0;  // cut borders stay, in reference space
    std::array<CutBorder, kMaxCutBorders> cut{};
    patient::StateHash cuts;  // of all that were ever remembered: a tick does not hash the list anew

    Vec3 lateral_m{0.0};                                  // tip minus channel, across the axis, patient frame
    double lateral_cut_m = 0.0;                           // how far the channel was cut sideways, in all
    Vec3 tip_deformed_m{0.0};                             // of the last step
    Vec3 channel_reference_m{0.0};                        // where tissue is looked up
    patient::Side channel_side = patient::Side::outside;  // of the cavity, on which that point lies
    patient::LocalMotion channel_motion;                  // how the breath carries it
    patient::Surrogate breath;                            // of the last step
    bool primed = false;                                  // a first step has set the above
};

enum class NeedleEventKind : std::uint8_t {
    border,     // met and held
    puncture,   // a held border was cut
    entry,      // a tissue entered without a hold
    sideways,   // a border met sideways: a hit without a hold
    withdrawn,  // the needle left the skin, drawn back or out through a corner of it
    overflow    // a fixed list was full: counted, the oldest or the newest entry was dropped
};

struct NeedleEvent {
    NeedleEventKind kind = NeedleEventKind::border;
    patient::Role role = patient::Role::pass;
    Border border;
    double tenting_m = 0.0;                            // tip depth behind the border when it was cut
    double force_before_n = 0.0, force_after_n = 0.0;  // after: in the tissue entered, before any next border
};

// What one step says besides its force; overwritten by each step.
inline constexpr int kMaxStepEvents = 24;
struct NeedleEvents {
    int count = 0;
    int dropped = 0;
    std::array<NeedleEvent, kMaxStepEvents> list{};
    void add(const NeedleEvent& e) noexcept {
        if (count < kMaxStepEvents) {
            list[std::size_t(count++)] = e;
        } else {
            ++dropped;
        }
    }
};

// Haptics thread. noexcept, no allocation. Moves the tip to `tip_deformed_m` with the shaft's axis (unit,
// INTO the body) and solves every border on the way; leaves the axial force, > 0 against insertion, in the
// state. At an incision the body's surface does not hold. Returns what the hand gets, patient frame: that
// force and the lateral spring's.
ToolForce stepNeedle(NeedleState&, const NeedleSettings&, const patient::Patient&, const Vec3& tip_deformed_m,
                     const Vec3& axis, const patient::Surrogate& breath, NeedleEvents&,
                     const Incisions& incisions = {}) noexcept STYLET_NONBLOCKING;
// The force on the needle in the patient frame: -force * axis - lateral spring.
Vec3 needleForce(const NeedleState&, const NeedleSettings&, const Vec3& axis) noexcept STYLET_NONBLOCKING;
// What the axial springs hold: k e^2 / 2 in pass; while held also the integral of Eq. 1 over the tip's way
// behind the border, the spring of the tissue before it being kept as it was.
double axialEnergy(const NeedleState&, const NeedleSettings&,
                   const patient::Patient&) noexcept STYLET_NONBLOCKING;
// Proxy behind tip: from the border while held, e otherwise.
double proxyDistance(const NeedleState&) noexcept STYLET_NONBLOCKING;
void hashNeedle(patient::StateHash&, const NeedleState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
