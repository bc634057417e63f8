#include "haptics/loop/toolbox.h"

#include <algorithm>

#include "base/hash.h"
#include "haptics/output/output.h"

namespace stylet::haptics {

namespace {

BreathingSkin breathingSkin(const TouchTools& touch, const BreathingPatient& now) noexcept {
    return {*touch.map, now.motion(), now.breath};
}

// True if the active tool touches nothing.
bool isOutside(const ToolState& s, const ToolSettings& settings, const TouchTools* touch,
               const BreathingPatient& now) noexcept {
    const Pose& tool = s.patient_from_tool;
    if (!isInOpenAir(now, tool.position_m)) return false;
    if (isNeedleTool(s.active_tool) || !touch) return true;
    if (s.active_tool == Tool::scalpel) {
        const Vec3 reference_m = patient::referenceFromDeformed(now.motion(), now.breath, tool.position_m);
        return touchAt(*touch->map, reference_m).level_m >= 0.0;
    }
    PadState pad;
    const bool finger = s.active_tool == Tool::finger;
    return stepPad(pad, finger ? touch->finger_pad : touch->probe_pad,
                   finger ? settings.finger.pad : settings.probe.pad, breathingSkin(*touch, now), tool)
               .touching == 0;
}

// Moves the parked probe with breathing. Returns its displacement.
Vec3 moveParkedProbe(ParkedProbe& probe, const TouchTools* touch,
                     const BreathingPatient& breathing) noexcept {
    if (!probe.parked) return Vec3(0.0);
    if (touch) {
        const Vec3 ridden = followSkin(probe.follower, breathingSkin(*touch, breathing));
        probe.patient_from_probe.position_m = probe.follower.at_m;
        return ridden;
    }
    const Vec3 now =
        patient::deformedFromReference(breathing.motion(), breathing.breath, probe.skin_reference_m);
    const Vec3 moved = now - probe.patient_from_probe.position_m;
    probe.patient_from_probe.position_m = now;
    return moved;
}

ToolForce stepActiveNeedle(ToolState& s, const ToolSettings& settings, const BreathingPatient& now,
                           const Vec3& probe_moved_m, NeedleEvents& events) noexcept {
    GuideResult guided{s.patient_from_tool};
    const bool on_rail = s.probe.parked && (s.active_tool == Tool::guide || s.guide.snapped);
    if (on_rail) {
        const Pose patient_from_guide = s.probe.patient_from_probe * settings.guide.probe_from_guide;
        guided = stepGuide(s.guide, settings.guide, patient_from_guide, s.patient_from_tool,
                           s.needle.phase == Phase::outside);
    } else {
        s.guide = {};
    }
    s.patient_from_needle = guided.patient_from_needle;
    const Vec3 axis = s.patient_from_needle.direction(Vec3(0.0, 0.0, -1.0));
    ToolForce force = stepNeedle(s.needle, settings.needle, now, {s.patient_from_needle.position_m, axis},
                                 events, s.incisions);
    if (on_rail && s.needle.phase == Phase::outside) force.tissue_moved_m = probe_moved_m;
    if (s.guide.snapped) {
        // The rail bears the lateral forces on the needle: the hand feels the rail instead.
        force.force_n = -s.needle.force_n * axis;
        force.energy_j = axialEnergy(s.needle, settings.needle, now.patient);
        // The tissue's motion along the needle, the rail's motion across it.
        force.tissue_moved_m = probe_moved_m + axis * glm::dot(force.tissue_moved_m - probe_moved_m, axis);
    }
    force.force_n += guided.force_n;
    force.energy_j += guided.energy_j;
    force.event = force.event || guided.event;
    return force;
}

ToolForce stepActiveScalpel(ToolState& s, const ScalpelSettings& settings, const BreathingSkin& skin,
                            NeedleEvents& events) noexcept {
    const bool unmarked = s.scalpel.cutting && s.scalpel.incision < 0;
    const ToolForce force = stepScalpel(s.scalpel, s.incisions, settings, skin, s.patient_from_tool);
    // The blade started to cut, but the list of incisions is full.
    if (!unmarked && s.scalpel.cutting && s.scalpel.incision < 0)
        events.add({NeedleEventKind::overflow, patient::Role::pass,
                    Border{s.scalpel.skin_reference_m, Tissue::air, Tissue::skin, 0, 0.0}, s.scalpel.depth_m,
                    0.0, 0.0});
    return force;
}

// The active tool is the finger, the probe or the scalpel.
ToolForce stepOnSkin(ToolState& s, const ToolSettings& settings, const TouchTools& touch,
                     const BreathingPatient& now, NeedleEvents& events) noexcept {
    const BreathingSkin skin = breathingSkin(touch, now);
    if (s.active_tool == Tool::finger)
        return stepFinger(s.finger, settings.finger, touch.finger_pad, skin, s.patient_from_tool);
    if (s.active_tool == Tool::probe)
        return stepProbe(s.handheld_probe, settings.probe, touch.probe_pad, skin, s.patient_from_tool);
    return stepActiveScalpel(s, settings.scalpel, skin, events);
}

// True if the active tool is one of those on the track of an open access.
bool isOnTrack(const ToolState& s) noexcept {
    return s.access.open && (isAccessTool(s.active_tool) || isNeedleTool(s.active_tool));
}

// True if a wire would go through the drain in the body.
bool isThroughDrain(const ToolState& s) noexcept {
    return !s.access.open && s.access.drain_state != DrainState::none && s.needle.phase == Phase::outside;
}

bool maySelect(const ToolState& s, Tool tool) noexcept {
    const AccessState& a = s.access;
    const bool needle_inside = s.needle.phase != Phase::outside;
    const bool dents_skin = s.needle.phase == Phase::tenting && s.needle.tissue == Tissue::air;
    const bool drain_left = a.drain_state == DrainState::in_place;
    if (!a.open) {
        if (tool == Tool::wire && isThroughDrain(s)) return true;
        if (isAccessTool(tool))
            return tool == Tool::wire && isNeedleTool(s.active_tool) && needle_inside && !dents_skin &&
                   !drain_left;
        return !needle_inside || (isNeedleTool(s.active_tool) && isNeedleTool(tool));
    }
    const bool dilator_in = a.dilator.depth_m > 0.0, drain_in = a.drain.depth_m > 0.0;
    switch (tool) {
        case Tool::wire:
            return !dilator_in;
        case Tool::dilator:
            return a.wire_in && !a.needle_in && !drain_in;
        case Tool::drain:
            return a.wire_in && !a.needle_in && !dilator_in && !drain_left &&
                   a.drain_state != DrainState::misplaced;
        case Tool::needle:
            return a.needle_in;
        case Tool::guide:
            return false;
        default:
            return !a.needle_in && !dilator_in;
    }
}

ToolForce stepOnTrack(ToolState& s, const ToolSettings& settings, const BreathingPatient& now,
                      NeedleEvents& events) noexcept {
    if (!s.access.open) return {};
    const OnTrack in_hand = s.active_tool == Tool::wire      ? OnTrack::wire
                            : s.active_tool == Tool::dilator ? OnTrack::dilator
                            : s.active_tool == Tool::drain   ? OnTrack::drain
                                                             : OnTrack::needle;
    ToolForce force =
        stepAccess(s.access, s.needle, s.patient_from_needle, {in_hand, settings.needle, settings.access},
                   now, s.patient_from_tool.position_m, events);
    if (!s.access.open) {  // lost
        resetContact(s);
        force.event = true;
    }
    return force;
}

}  // namespace

bool selectTool(ToolState& s, Tool tool) noexcept {
    if (std::uint32_t(tool) >= std::uint32_t(kToolCount)) return false;
    const bool again = tool == Tool::wire && isThroughDrain(s);
    if ((tool == s.active_tool && !again) || !maySelect(s, tool)) return false;
    const bool keeps_needle = isNeedleTool(s.active_tool) && isNeedleTool(tool);
    if (tool == Tool::probe) s.probe.parked = false;
    if (!isNeedleTool(tool)) s.guide = {};
    if (s.active_tool == Tool::wire) layDownWire(s.access);
    s.access.released = false;
    // A wire that was laid down is taken again where the needle is now.
    if (again)
        openThroughDrain(s.access);
    else if (tool == Tool::wire && !s.access.wire_in)
        openAccess(s.access);
    s.active_tool = tool;
    if (!keeps_needle) resetContact(s);
    return true;
}

bool gripTool(ToolState& s, bool grip) noexcept {
    if (!isOnTrack(s)) return false;
    if (grip)
        regrip(s.access);
    else
        letGo(s.access);
    return true;
}

Following findFollowing(const ToolState& s, const Vec3& tip_m, bool leapt) noexcept {
    const bool outside = s.needle.phase == Phase::outside || isOnTrack(s) || isAccessTool(s.active_tool);
    if (outside) return leapt ? Following::reseats : Following::follows;
    const bool near = glm::distance(tip_m, s.patient_from_tool.position_m) <= kRejoin_m;
    return leapt || !near ? Following::stays : Following::follows;
}

bool isInOpenAir(const BreathingPatient& now, const Vec3& tip_m) noexcept {
    const Vec3 reference_m = patient::referenceFromDeformed(now.motion(), now.breath, tip_m);
    const patient::TissueSample x = now.patient.at(reference_m, {});
    return x.tissue == Tissue::air && x.label == 0;  // gas in the body is labelled
}

void resetContact(ToolState& s) noexcept {
    ++s.reset_count;
    if (isOnTrack(s) || isAccessTool(s.active_tool)) {
        s.access.gripped = false;  // a hand that has let go has still let go
        s.awaits_exit = false;
        return;
    }
    s.finger = {};
    s.handheld_probe = {};
    s.scalpel = {};
    s.needle.primed = false;
    s.awaits_exit = true;
}

bool parkProbe(ToolState& s, const TouchTools* touch, const BreathingPatient& now, bool park) noexcept {
    if (!park) {
        const bool guides = s.guide.snapped && s.needle.phase != Phase::outside;
        if (!s.probe.parked || guides) return false;
        s.awaits_exit = s.awaits_exit || s.active_tool == Tool::probe;  // in the hand again
        s.probe.parked = false;
        return true;
    }
    if (s.active_tool != Tool::probe || s.awaits_exit || s.probe.parked) return false;
    if (touch && !(s.handheld_probe.touching_share >= kMinParkedContact)) return false;
    s.handheld_probe = {};
    s.probe.parked = true;
    s.probe.patient_from_probe = s.patient_from_tool * kStylusFromProbe;
    const Vec3 face_m = s.probe.patient_from_probe.position_m;
    s.probe.skin_reference_m = patient::referenceFromDeformed(now.motion(), now.breath, face_m);
    if (touch) s.probe.follower = parkOnSkin(breathingSkin(*touch, now), s.patient_from_tool);
    return true;
}

ToolForce stepTools(ToolState& s, const ToolSettings& settings, const TouchTools* touch,
                    const BreathingPatient& now, const Pose& patient_from_stylus,
                    NeedleEvents& events) noexcept {
    s.patient_from_tool = patient_from_stylus;
    const Vec3 probe_moved_m = moveParkedProbe(s.probe, touch, now);
    if (isOnTrack(s) || isAccessTool(s.active_tool)) return stepOnTrack(s, settings, now, events);
    s.awaits_exit = s.awaits_exit && !isOutside(s, settings, touch, now);
    if (s.awaits_exit) {
        if (isNeedleTool(s.active_tool)) s.patient_from_needle = patient_from_stylus;
        return {};
    }
    if (s.active_tool == Tool::probe && s.probe.parked) return {};  // the hand is empty
    if (isNeedleTool(s.active_tool)) return stepActiveNeedle(s, settings, now, probe_moved_m, events);
    return touch ? stepOnSkin(s, settings, *touch, now, events) : ToolForce{};
}

void equip(ToolSettings& tools, const Instrument& instrument) noexcept {
    if (const auto* needle = std::get_if<NeedleSettings>(&instrument.force)) tools.needle = *needle;
    if (const auto* scalpel = std::get_if<ScalpelSettings>(&instrument.force)) tools.scalpel = *scalpel;
    if (const auto* probe = std::get_if<ProbeSettings>(&instrument.force)) tools.probe = *probe;
    if (const auto* finger = std::get_if<FingerSettings>(&instrument.force)) tools.finger = *finger;
    if (const auto* wire = std::get_if<WireSettings>(&instrument.force)) tools.access.wire = *wire;
    if (const auto* tube = std::get_if<TubeSettings>(&instrument.force))
        (instrument.kind == InstrumentKind::drain ? tools.access.drain : tools.access.dilator) = *tube;
}

void equip(ToolSettings& tools, const InstrumentSet& instruments) noexcept {
    visitInstruments(instruments, [&](const Instrument& one) { equip(tools, one); });
}

Instrument withToolForce(Instrument instrument, const ToolSettings& tools) {
    switch (instrument.kind) {
        case InstrumentKind::needle:
            instrument.force = tools.needle;
            break;
        case InstrumentKind::scalpel:
            instrument.force = tools.scalpel;
            break;
        case InstrumentKind::probe:
            instrument.force = tools.probe;
            break;
        case InstrumentKind::finger:
            instrument.force = tools.finger;
            break;
        case InstrumentKind::guideWire:
            instrument.force = tools.access.wire;
            break;
        case InstrumentKind::dilator:
            instrument.force = tools.access.dilator;
            break;
        case InstrumentKind::drain:
            instrument.force = tools.access.drain;
            break;
    }
    return instrument;
}

bool arePadsValid(const ToolSettings& s) noexcept {
    const auto fits = [](int n) { return n >= 1 && n <= kMaxPadPoints; };
    return fits(s.finger.points) && fits(s.probe.columns) && fits(s.probe.rows) &&
           fits(s.probe.columns * s.probe.rows);
}

double maxTangent(const patient::TissueTable& table, const ToolSettings& s) noexcept {
    const auto padTangent = [](const PadSettings& pad) {
        return pad.max_stiffness_n_per_m + pad.shear_n_per_m;
    };
    return std::max({maxTangent(table, s.needle), s.guide.stiffness_n_per_m, padTangent(s.finger.pad),
                     padTangent(s.probe.pad), s.scalpel.stiffness_n_per_m, s.access.wire.grip_n_per_m,
                     s.access.dilator.stiffness_n_per_m, s.access.drain.stiffness_n_per_m});
}

void hashTools(StateHash& hash, const ToolState& s) noexcept {
    hash.add(std::uint64_t(s.active_tool) | std::uint64_t(s.awaits_exit) << 8 |
             std::uint64_t(s.guide.snapped) << 9 | std::uint64_t(s.probe.parked) << 10 |
             std::uint64_t(s.guide.free) << 11);
    hash.add(s.patient_from_tool);
    if (s.probe.parked) hash.add(s.probe.skin_reference_m, s.probe.patient_from_probe);
    if (s.incisions.count > 0) hashIncisions(hash, s.incisions);
    if (s.active_tool == Tool::finger) hashPad(hash, s.finger.pad);
    if (s.active_tool == Tool::probe) hashPad(hash, s.handheld_probe.pad);
    if (s.active_tool == Tool::scalpel) hashScalpel(hash, s.scalpel);
    // Before the first wire, the hash does not depend on the access or its settings.
    if (s.access.used) {
        hash.add(s.access_digest);
        hashAccess(hash, s.access, s.needle);
    }
    if (!isNeedleTool(s.active_tool)) return;
    hash.add(s.patient_from_needle);
    hashNeedle(hash, s.needle);
}

void hashToolSettings(StateHash& hash, const ToolSettings& s) noexcept {
    hash.add(std::uint64_t(s.first));
    visitToolCounts(s, [&](int v) { hash.add(std::uint64_t(v)); });
    visitToolNumbers(s, [&](double v) { hash.add(v); });
}

}  // namespace stylet::haptics
