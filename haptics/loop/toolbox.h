// The tools that the user's hand can hold. Selects the active tool and steps it; inactive tools are not
// stepped.
#pragma once

#include "base/hash.h"
#include "haptics/loop/access.h"
#include "haptics/tools/finger.h"
#include "haptics/tools/guide.h"
#include "haptics/tools/instrument.h"
#include "haptics/tools/needle.h"
#include "haptics/tools/probe.h"
#include "haptics/tools/scalpel.h"
#include "haptics/tools/tool.h"

namespace stylet::haptics {

struct ToolSettings {
    Tool first = Tool::needle;  // active at the start
    NeedleSettings needle;
    GuideSettings guide;
    FingerSettings finger;
    ProbeSettings probe;
    ScalpelSettings scalpel;
    AccessSettings access;
};

// Sets the tool of the instrument's kind to the instrument's settings.
void equip(ToolSettings&, const Instrument&) noexcept;
// Sets the tools of all instruments.
void equip(ToolSettings&, const InstrumentSet&) noexcept;
// The instrument with the settings of its kind's tool as its force.
Instrument withToolForce(Instrument, const ToolSettings&);

constexpr bool isNeedleTool(Tool tool) noexcept {
    return tool == Tool::guide || tool == Tool::needle;
}
// True for wire, dilator and drain. The wire needs a DuctSpace of the patient and finds no duct without one.
constexpr bool isAccessTool(Tool tool) noexcept {
    return tool == Tool::wire || tool == Tool::dilator || tool == Tool::drain;
}
// True for the tools that cut: needle, free or in the guide, and scalpel.
constexpr bool cutsTissue(Tool tool) noexcept {
    return isNeedleTool(tool) || tool == Tool::scalpel;
}
// True for finger, probe and scalpel. They need a TouchMap of the patient and give no force without one.
constexpr bool pressesOnSkin(Tool tool) noexcept {
    return !isNeedleTool(tool) && !isAccessTool(tool);
}

// The touch map and the pads of the tools that press on the skin, built once.
struct TouchTools {
    TouchTools(const TouchMap& of, const ToolSettings& settings) noexcept
        : map(&of), finger_pad(fingerPad(settings.finger)), probe_pad(probePad(settings.probe)) {}

    const TouchMap* map;
    Pad finger_pad, probe_pad;
};
// True if the pads can be built. Call it for settings that were read from a file.
bool arePadsValid(const ToolSettings&) noexcept;

// The stylus and probe frames share their origin, the tip. The probe's +z points the other way, into the
// body.
inline const Pose kStylusFromProbe{{0.0, 1.0, 0.0, 0.0}, Vec3(0.0)};

// A parked probe with its guide. It keeps its orientation and rides the skin along the skin normal. Without
// a touch map it follows the tissue point under it.
struct ParkedProbe {
    bool parked = false;
    Vec3 skin_reference_m{0.0};  // under the centre of the face
    SkinFollower follower;
    Pose patient_from_probe;
};

// Visits every floating-point setting in a fixed order, for hash and record. `first` is not visited;
// visitToolCounts() visits the counts, visitAccessNumbers() the settings of wire, dilator and drain.
template <typename Settings, typename Visit>
void visitToolNumbers(Settings& s, const Visit& visit) {
    static_assert(sizeof s.needle == 6 * sizeof(double) && sizeof s.guide == (7 + 6) * sizeof(double) &&
                      sizeof s.finger == (1 + 5) * sizeof(double) &&
                      sizeof s.probe == (1 + 6) * sizeof(double) && sizeof s.scalpel == 8 * sizeof(double),
                  "a new setting needs a place here and a new kRecordVersion");
    visit(s.needle.a1_share), visit(s.needle.cut_reach_m), visit(s.needle.friction_scale);
    visit(s.needle.max_force_n);
    visit(s.needle.lateral_stiffness_n_per_m), visit(s.needle.lateral_force_n);
    auto& rail = s.guide.probe_from_guide;
    visit(rail.rotation.w), visit(rail.rotation.x), visit(rail.rotation.y), visit(rail.rotation.z);
    visit(rail.position_m.x), visit(rail.position_m.y), visit(rail.position_m.z);
    visit(s.guide.length_m), visit(s.guide.stiffness_n_per_m), visit(s.guide.catch_m);
    visit(s.guide.reach_m), visit(s.guide.catch_cosine), visit(s.guide.release_n);
    const auto visitPad = [&](auto& pad) {
        visit(pad.max_stiffness_n_per_m), visit(pad.shear_n_per_m), visit(pad.friction);
    };
    visit(s.finger.radius_m), visit(s.finger.curvature_m), visitPad(s.finger.pad);
    visit(s.probe.length_m), visit(s.probe.width_m), visit(s.probe.curvature_m), visitPad(s.probe.pad);
    visit(s.scalpel.stiffness_n_per_m), visit(s.scalpel.cut_force_n), visit(s.scalpel.friction);
    visit(s.scalpel.deeper_n), visit(s.scalpel.along_edge_n), visit(s.scalpel.across_blade_n);
    visit(s.scalpel.width_per_depth), visit(s.scalpel.open_reach_m);
}
template <typename Settings, typename Visit>
void visitToolCounts(Settings& s, const Visit& visit) {
    visit(s.finger.points), visit(s.probe.columns), visit(s.probe.rows);
}

struct ToolState {
    Tool active_tool = Tool::needle;
    // After the start, a tool change or a leap: no force until the tool has been outside the body.
    bool awaits_exit = true;
    // Number of times that a tool change or leap set `awaits_exit`. Only reported in TickOutput, not
    // hashed.
    std::uint32_t reset_count = 0;
    Pose patient_from_tool;
    // As patient_from_tool, but on the rail while snapped into the guide. Keeps the last pose while another
    // tool is active.
    Pose patient_from_needle;
    NeedleState needle;
    GuideState guide;
    ParkedProbe probe;
    Incisions incisions;
    FingerState finger;
    ProbeState handheld_probe;
    ScalpelState scalpel;
    AccessState access;
    std::uint64_t access_digest = 0;  // of the settings of wire, dilator and drain
};

// All below: haptics thread. noexcept, no allocation.

// Selects `tool`. Returns false if it is already active or cannot be selected. From a needle in the body only
// the wire can be selected; any other tool must wait until the needle is withdrawn. The wire needs a needle
// in the body, the access that an earlier wire has opened, or a drain in the body; through a drain a wire
// that was drawn out can be selected again. Dilator and drain need a wire in the body without a needle or
// another tube around it.
bool selectTool(ToolState&, Tool) noexcept STYLET_NONBLOCKING;
// Share of its face with which a probe must touch the skin to stay there.
inline constexpr double kMinParkedContact = 0.2;
// Lets go of the needle, wire, dilator or drain on the track of an open access, or grips it again where it
// and the hand are. So a device with a short travel draws out a long wire. Returns false if nothing is on the
// track.
bool gripTool(ToolState&, bool grip) noexcept STYLET_NONBLOCKING;
// With `park`, parks the hand-held probe where it touches the skin; the hand is then empty. Otherwise removes
// a parked probe from the skin, unless its rail guides a needle in the body. Returns false if nothing
// changed.
bool parkProbe(ToolState&, const TouchTools*, const BreathingPatient&, bool park) noexcept STYLET_NONBLOCKING;
// A needle in the body follows the device again once it is back within this distance of the pose that the
// needle kept.
inline constexpr double kRejoin_m = 0.003;
// How the active tool follows the device's new pose.
enum class Following : std::uint8_t {
    follows,
    reseats,  // a leap outside the body: the tool is there now, without having been swept
    stays     // a leap while the needle is in the body: the needle keeps its pose
};
// `leapt`: the device moved faster than any intended motion, or elsewhere while it was absent (kAbsent_s).
// For a needle in the body, any step longer than kRejoin_m is a leap.
Following findFollowing(const ToolState&, const Vec3& tip_m, bool leapt) noexcept STYLET_NONBLOCKING;
// True if `tip_m` is in the air outside the body.
bool isInOpenAir(const BreathingPatient&, const Vec3& tip_m) noexcept STYLET_NONBLOCKING;
// Clears all contact state: the tool gives force again once it has been outside the body, as if it had just
// been selected. A tool on the track of an open access is only gripped anew.
void resetContact(ToolState&) noexcept STYLET_NONBLOCKING;
// One tick of the active tool, patient frame. Without `touch` finger, probe and scalpel
// give no force.
ToolForce stepTools(ToolState&, const ToolSettings&, const TouchTools* touch, const BreathingPatient&,
                    const Pose& patient_from_stylus, NeedleEvents&) noexcept STYLET_NONBLOCKING;

// Largest tangent stiffness of any tool, N/m. It determines the device's gain.
double maxTangent(const patient::TissueTable&, const ToolSettings&) noexcept;

void hashTools(StateHash&, const ToolState&) noexcept STYLET_NONBLOCKING;
void hashToolSettings(StateHash&, const ToolSettings&) noexcept;

}  // namespace stylet::haptics
