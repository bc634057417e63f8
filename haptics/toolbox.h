// The five tools of one hand: which is held, what it meets in a tick. An idle tool costs nothing.
#pragma once

#include "haptics/finger.h"
#include "haptics/guide.h"
#include "haptics/needle.h"
#include "haptics/probe.h"
#include "haptics/scalpel.h"
#include "haptics/tool.h"

namespace stylet::haptics {

struct ToolSettings {
    Tool first = Tool::needle;  // in hand at the start
    NeedleSettings needle;
    GuideSettings guide;
    FingerSettings finger;
    ProbeSettings probe;
    ScalpelSettings scalpel;
};

constexpr bool holdsNeedle(Tool tool) noexcept {
    return tool == Tool::guide || tool == Tool::needle;
}
// Finger, probe and scalpel: they need a TouchMap of the patient, and feel nothing without.
constexpr bool pressesOnSkin(Tool tool) noexcept {
    return !holdsNeedle(tool);
}

// What presses on the skin, with its pads made once.
struct TouchTools {
    TouchTools(const TouchMap& of, const ToolSettings& settings) noexcept
        : map(&of), finger_pad(fingerPad(settings.finger)), probe_pad(probePad(settings.probe)) {}

    const TouchMap* map;
    Pad finger_pad, probe_pad;
};
// What pads can be made of: settings read from a file are asked first.
bool padsFit(const ToolSettings&) noexcept;

// Stylus and probe have their tips in common; the probe's +z points the other way, into the body.
inline const Pose kStylusFromProbe{{0.0, 1.0, 0.0, 0.0}, Vec3(0.0)};

// A probe that was let go of: it keeps its orientation and rides the skin along its normal, its guide with it
// (without a map of the skin it goes wherever the point under it goes).
struct ParkedProbe {
    bool parked = false;
    Vec3 skin_reference_m{0.0};  // under the face's centre
    SkinRider rider;
    Pose patient_from_probe;
};

// Every number of the settings in one order, for hash and record; `first` and the counts apart.
template <typename Settings, typename Visit>
void eachToolNumber(Settings& s, const Visit& visit) {
    static_assert(sizeof s.needle == 5 * sizeof(double) && sizeof s.guide == (7 + 6) * sizeof(double) &&
                      sizeof s.finger == (1 + 5) * sizeof(double) &&
                      sizeof s.probe == (1 + 6) * sizeof(double) && sizeof s.scalpel == 8 * sizeof(double),
                  "a new setting needs a place here and a new kRecordVersion");
    visit(s.needle.a1_share), visit(s.needle.cut_reach_m), visit(s.needle.max_force_n);
    visit(s.needle.lateral_stiffness_n_per_m), visit(s.needle.lateral_force_n);
    auto& rail = s.guide.probe_from_guide;
    visit(rail.rotation.w), visit(rail.rotation.x), visit(rail.rotation.y), visit(rail.rotation.z);
    visit(rail.position_m.x), visit(rail.position_m.y), visit(rail.position_m.z);
    visit(s.guide.length_m), visit(s.guide.stiffness_n_per_m), visit(s.guide.catch_m);
    visit(s.guide.reach_m), visit(s.guide.catch_cosine), visit(s.guide.release_n);
    const auto visitPad = [&](auto& pad) {
        visit(pad.stiffest_n_per_m), visit(pad.shear_n_per_m), visit(pad.friction);
    };
    visit(s.finger.radius_m), visit(s.finger.curvature_m), visitPad(s.finger.pad);
    visit(s.probe.length_m), visit(s.probe.width_m), visit(s.probe.curvature_m), visitPad(s.probe.pad);
    visit(s.scalpel.stiffness_n_per_m), visit(s.scalpel.cut_force_n), visit(s.scalpel.friction);
    visit(s.scalpel.deeper_n), visit(s.scalpel.along_edge_n), visit(s.scalpel.across_blade_n);
    visit(s.scalpel.width_per_depth), visit(s.scalpel.open_reach_m);
}
template <typename Settings, typename Visit>
void eachToolCount(Settings& s, const Visit& visit) {
    visit(s.finger.points), visit(s.probe.columns), visit(s.probe.rows);
}

struct ToolState {
    Tool in_hand = Tool::needle;
    bool waits = true;  // at the start, taken up or after a leap: nothing is felt until it has been outside
    std::uint32_t begun = 0;  // how often that began; for who follows the ticks, not hashed
    Pose patient_from_tool;
    Pose patient_from_needle;  // the same, but on the rail in the guide; the last one while another is held
    NeedleState needle;
    GuideState guide;
    ParkedProbe probe;
    Incisions incisions;
    FingerState finger;
    ProbeState held_probe;
    ScalpelState scalpel;
};

// All below: haptics thread. noexcept, no allocation.

// Takes `tool` in hand. False when it was there already, or cannot be: a needle in the body is drawn out
// first.
bool takeTool(ToolState&, Tool) noexcept STYLET_NONBLOCKING;
// The probe in hand is let go of where it is (`stay`), and the hand is empty; or a parked one is taken off
// the skin, unless its rail guides a needle in the body. False when nothing came of it.
bool parkProbe(ToolState&, const TouchTools*, const patient::Patient&, const patient::Surrogate& breath,
               bool stay) noexcept STYLET_NONBLOCKING;
// The hand was not where it is now a tick ago, and went no way: a tool outside the body is as if taken up
// here. False where that cannot be, with a needle in the body.
bool leap(ToolState&) noexcept STYLET_NONBLOCKING;
// One tick of the tool in hand, patient frame. Without `touch` only the needle is felt.
ToolForce stepTools(ToolState&, const ToolSettings&, const TouchTools* touch, const patient::Patient&,
                    const Pose& patient_from_stylus, const patient::Surrogate& breath,
                    NeedleEvents&) noexcept STYLET_NONBLOCKING;

// The steepest that any of the tools gets, N/m: what a device's gain is set by.
double worstTangent(const patient::TissueTable&, const ToolSettings&) noexcept;

void hashTools(patient::StateHash&, const ToolState&) noexcept STYLET_NONBLOCKING;
void hashToolSettings(patient::StateHash&, const ToolSettings&) noexcept;

}  // namespace stylet::haptics
