// The access that a guide wire opens (Seldinger's technique): the track of the needle, the wire through it,
// and dilator and drain over the wire. One tool is in the hand; an assistant holds the others where they are
// in the breathing tissue. In the hand each moves along the track only, by the hand's motion relative to the
// tissue.
//
// The order of the steps is that of the CIRSE Standards of Practice (Das et al., Cardiovasc. Intervent.
// Radiol. 44, 2021): needle, wire through the needle, needle out over the wire, dilator, drain over the wire,
// wire out. packaging/guide/drainage.md has the formulas.
#pragma once

#include <cstdint>
#include <span>

#include "base/hash.h"
#include "haptics/tools/needle.h"
#include "haptics/tools/tube.h"
#include "haptics/tools/wire.h"

namespace stylet::haptics {

struct AccessSettings {
    WireSettings wire;
    TubeSettings dilator;
    TubeSettings drain = kDrainDefaults;
};
template <typename Settings, typename Visit>
void visitAccessNumbers(Settings& s, const Visit& visit) {
    static_assert(sizeof s.wire == 11 * sizeof(double) && sizeof s.dilator == 7 * sizeof(double),
                  "a new setting needs a place here and a new kRecordVersion");
    visitWireNumbers(s.wire, visit), visitTubeNumbers(s.dilator, visit), visitTubeNumbers(s.drain, visit);
}
std::uint64_t digest(const AccessSettings&) noexcept;

enum class DrainState : std::uint8_t {
    none,       // outside the body
    over_wire,  // in the body, straightened by the wire
    in_place,   // its end curled in a duct, without the wire in it
    misplaced   // its end not in a duct, without the wire in it
};
inline constexpr std::array<std::string_view, 4> kDrainStateNames{"none", "over wire", "in place",
                                                                  "misplaced"};

inline constexpr double kSideHoles_m = 0.020;  // length of the drain's end with side holes
inline constexpr int kMaxPathPoints = kMaxWireNodes + 2;

// Positions in the reference frame.
struct AccessState {
    bool used = false;     // a wire was in the hand. From then on this state is hashed.
    bool open = false;     // needle or wire hold the access
    bool pending = false;  // to be opened at the needle's pose in the next tick
    bool needle_in = false, wire_in = false;
    Vec3 entry_m{0.0};         // on the skin
    WireBase base;             // the needle's tip when the wire was taken
    double track_m = 0.0;      // from entry to base
    double needle_at_m = 0.0;  // of the needle's tip along the track, from the base; < 0: withdrawn
    Quat patient_from_needle{1.0, 0.0, 0.0, 0.0};  // rotation when the wire was taken
    WireState wire;
    TubeState dilator, drain;
    double dilated_m = 0.0;     // depth to which the track is dilated to its diameter
    double dilated_to_m = 0.0;  // diameter
    DrainState drain_state = DrainState::none;
    double holes_in_duct = 0.0;  // share of the drain's side holes that lie in a duct
    int path_count = 0;
    std::array<Vec3, kMaxPathPoints> path_m{};  // from the skin along track and wire; that of the tubes
    // Of the last step.
    bool gripped = false;                               // `hand_m` and `base_deformed_m` are valid
    bool released = false;                              // the hand has let go of the tool (letGo)
    Vec3 hand_m{0.0}, base_deformed_m{0.0}, axis{0.0};  // deformed patient; `axis` into the body
    double force_n = 0.0;
};

// The access for messages and scores. Trivially copyable. Positions in the reference frame.
struct AccessStatus {
    bool open = false, needle_in = false, wire_in = false;
    bool tip_in_duct = false, buckled = false, pierced = false;  // of the wire
    DrainState drain = DrainState::none;
    double wire_m = 0.0;     // length beyond the needle's first position; < 0: withdrawn from it
    double in_duct_m = 0.0;  // length of the wire in the ducts; 0 unless its tip is in one
    Vec3 wire_tip_m{0.0};
    double dilator_m = 0.0, drain_m = 0.0;  // depth of the tip along the path from the skin
    double dilated_m = 0.0;                 // depth to which the track is dilated
    double holes_in_duct = 0.0;             // share of the drain's side holes in a duct
    Vec3 entry_m{0.0}, base_m{0.0};
    int node_count = 0, path_count = 0;
};
// The same with its curves, for pictures. Points beyond the counts are leftovers of earlier ticks: clearing 2
// KB would add a tenth to a tick without a wire.
struct AccessOutput : AccessStatus {
    std::array<glm::vec3, kMaxWireNodes> nodes_m{};  // of the wire, from the tip to the base
    std::array<glm::vec3, kMaxPathPoints> path_m{};  // of dilator and drain, from the skin on
};

// All below: haptics thread. noexcept, no allocation.

// Needle, wire, dilator or drain: the tool whose motion stepAccess() computes.
enum class OnTrack : std::uint8_t { needle, wire, dilator, drain };

// Prepares a new access at the needle's pose in the next tick.
void openAccess(AccessState&) noexcept STYLET_NONBLOCKING;
// Puts the wire into the outer end of the drain that is in the body. A wire that reaches the middle of its
// loop straightens it: the drain then lies over the wire again and can be moved.
void openThroughDrain(AccessState&) noexcept STYLET_NONBLOCKING;
// The hand grips the tool anew, wherever the hand is.
inline void regrip(AccessState& s) noexcept {
    s.gripped = s.released = false;
}
// The hand lets go of the tool, which stays in the tissue without force, until regrip().
void letGo(AccessState&) noexcept STYLET_NONBLOCKING;
// The hand changes from the wire to another tool. A wire that does not reach beyond the needle is taken out.
void layDownWire(AccessState&) noexcept STYLET_NONBLOCKING;

struct AccessTools {
    OnTrack in_hand = OnTrack::wire;
    const NeedleSettings& needle;
    const AccessSettings& access;
};
// One tick with the hand at `hand_m` (deformed patient). Moves `patient_from_needle` while the needle is on
// the track. Force on the hand, patient frame. Sets AccessState::open to false when the access is lost: the
// needle has left the body and no wire reaches into it, or the wire has been withdrawn.
ToolForce stepAccess(AccessState&, NeedleState&, Pose& patient_from_needle, const AccessTools&,
                     const BreathingPatient&, const Vec3& hand_m, NeedleEvents&) noexcept STYLET_NONBLOCKING;

void summarize(const AccessState&, const patient::DuctSpace*, AccessOutput&) noexcept STYLET_NONBLOCKING;
void hashAccess(StateHash&, const AccessState&, const NeedleState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
