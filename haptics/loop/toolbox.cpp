#include "haptics/loop/toolbox.h"

#include <algorithm>

#include "base/hash.h"
#include "haptics/output/output.h"

namespace stylet::haptics {

namespace {

BreathingSkin breathingSkin(const TouchTools& touch, const BreathingPatient& now) noexcept {
    return {*touch.map, now.patient.package().motion, now.breath};
}

// True if the active tool touches nothing. Gas in the body is labelled; the air outside is not.
bool isOutside(const ToolState& s, const ToolSettings& settings, const TouchTools* touch,
               const BreathingPatient& now) noexcept {
    const patient::MotionModel& motion = now.patient.package().motion;
    const Pose& tool = s.patient_from_tool;
    const Vec3 reference_m = patient::referenceFromDeformed(motion, now.breath, tool.position_m);
    const patient::TissueSample x = now.patient.at(reference_m, {});
    if (x.tissue != Tissue::air || x.label != 0) return false;
    if (holdsNeedle(s.in_hand) || !touch) return true;
    if (s.in_hand == Tool::scalpel) return touchAt(*touch->map, reference_m).level_m >= 0.0;
    PadState pad;
    const bool finger = s.in_hand == Tool::finger;
    return stepPad(pad, finger ? touch->finger_pad : touch->probe_pad,
                   finger ? settings.finger.pad : settings.probe.pad, breathingSkin(*touch, now), tool)
               .touching == 0;
}

// Clears all contact state: the tool gives force again once it has been outside the body.
void beginAnew(ToolState& s) noexcept {
    s.finger = {};
    s.held_probe = {};
    s.scalpel = {};
    s.needle.primed = false;
    s.waits = true;
    ++s.begun;
}

// Moves the parked probe with breathing. Returns its displacement.
Vec3 carryProbe(ParkedProbe& probe, const TouchTools* touch, const BreathingPatient& breathing) noexcept {
    if (!probe.parked) return Vec3(0.0);
    if (touch) {
        const Vec3 ridden = rideSkin(probe.rider, breathingSkin(*touch, breathing));
        probe.patient_from_probe.position_m = probe.rider.at_m;
        return ridden;
    }
    const patient::MotionModel& motion = breathing.patient.package().motion;
    const Vec3 now = patient::deformedFromReference(motion, breathing.breath, probe.skin_reference_m);
    const Vec3 moved = now - probe.patient_from_probe.position_m;
    probe.patient_from_probe.position_m = now;
    return moved;
}

ToolForce stepHeldNeedle(ToolState& s, const ToolSettings& settings, const BreathingPatient& now,
                         const Vec3& probe_moved_m, NeedleEvents& events) noexcept {
    Guided guided{s.patient_from_tool};
    const bool railed = s.probe.parked && (s.in_hand == Tool::guide || s.guide.snapped);
    if (railed) {
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
    if (railed && s.needle.phase == Phase::outside) force.tissue_moved_m = probe_moved_m;
    if (s.guide.snapped) {
        // The rail bears the lateral forces on the needle: the hand feels the rail instead.
        force.force_n = -s.needle.force_n * axis;
        force.energy_j = axialEnergy(s.needle, settings.needle, now.patient);
        // Along the needle the tissue's motion, across it the rail's.
        force.tissue_moved_m = probe_moved_m + axis * glm::dot(force.tissue_moved_m - probe_moved_m, axis);
    }
    force.force_n += guided.force_n;
    force.energy_j += guided.energy_j;
    force.event = force.event || guided.event;
    return force;
}

ToolForce stepHeldScalpel(ToolState& s, const ScalpelSettings& settings, const BreathingSkin& skin,
                          NeedleEvents& events) noexcept {
    const bool unmarked = s.scalpel.cutting && s.scalpel.incision < 0;
    const ToolForce force = stepScalpel(s.scalpel, s.incisions, settings, skin, s.patient_from_tool);
    // It cuts, but the list is full.
    if (!unmarked && s.scalpel.cutting && s.scalpel.incision < 0)
        events.add({NeedleEventKind::overflow, patient::Role::pass,
                    Border{s.scalpel.skin_reference_m, Tissue::air, Tissue::skin, 0, 0.0}, s.scalpel.depth_m,
                    0.0, 0.0});
    return force;
}

ToolForce stepOnSkin(ToolState& s, const ToolSettings& settings, const TouchTools& touch,
                     const BreathingPatient& now, NeedleEvents& events) noexcept {
    const BreathingSkin skin = breathingSkin(touch, now);
    switch (s.in_hand) {
        case Tool::finger:
            return stepFinger(s.finger, settings.finger, touch.finger_pad, skin, s.patient_from_tool);
        case Tool::probe:
            return stepProbe(s.held_probe, settings.probe, touch.probe_pad, skin, s.patient_from_tool);
        case Tool::scalpel:
            return stepHeldScalpel(s, settings.scalpel, skin, events);
        case Tool::guide:
        case Tool::needle:
            break;
    }
    return {};
}

}  // namespace

bool takeTool(ToolState& s, Tool tool) noexcept {
    if (tool == s.in_hand || std::uint32_t(tool) >= std::uint32_t(kToolCount)) return false;
    const bool keeps_needle = holdsNeedle(s.in_hand) && holdsNeedle(tool);
    if (s.needle.phase != Phase::outside && !keeps_needle) return false;
    if (tool == Tool::probe) s.probe.parked = false;
    if (!holdsNeedle(tool)) s.guide = {};
    s.in_hand = tool;
    if (!keeps_needle) beginAnew(s);
    return true;
}

bool leap(ToolState& s) noexcept {
    if (s.needle.phase != Phase::outside) return false;
    beginAnew(s);
    return true;
}

bool parkProbe(ToolState& s, const TouchTools* touch, const BreathingPatient& now, bool stay) noexcept {
    if (!stay) {
        const bool guides = s.guide.snapped && s.needle.phase != Phase::outside;
        if (!s.probe.parked || guides) return false;
        s.waits = s.waits || s.in_hand == Tool::probe;  // active again
        s.probe.parked = false;
        return true;
    }
    if (s.in_hand != Tool::probe || s.waits || s.probe.parked) return false;
    s.held_probe = {};
    s.probe.parked = true;
    s.probe.patient_from_probe = s.patient_from_tool * kStylusFromProbe;
    const patient::MotionModel& motion = now.patient.package().motion;
    const Vec3 face_m = s.probe.patient_from_probe.position_m;
    s.probe.skin_reference_m = patient::referenceFromDeformed(motion, now.breath, face_m);
    if (touch) s.probe.rider = parkOnSkin(breathingSkin(*touch, now), s.patient_from_tool);
    return true;
}

ToolForce stepTools(ToolState& s, const ToolSettings& settings, const TouchTools* touch,
                    const BreathingPatient& now, const Pose& patient_from_stylus,
                    NeedleEvents& events) noexcept {
    s.patient_from_tool = patient_from_stylus;
    const Vec3 probe_moved_m = carryProbe(s.probe, touch, now);
    s.waits = s.waits && !isOutside(s, settings, touch, now);
    if (s.waits) {
        if (holdsNeedle(s.in_hand)) s.patient_from_needle = patient_from_stylus;
        return {};
    }
    if (s.in_hand == Tool::probe && s.probe.parked) return {};  // the hand is empty
    if (holdsNeedle(s.in_hand)) return stepHeldNeedle(s, settings, now, probe_moved_m, events);
    return touch ? stepOnSkin(s, settings, *touch, now, events) : ToolForce{};
}

bool padsFit(const ToolSettings& s) noexcept {
    const auto fits = [](int n) { return n >= 1 && n <= kMaxPadPoints; };
    return fits(s.finger.points) && fits(s.probe.columns) && fits(s.probe.rows) &&
           fits(s.probe.columns * s.probe.rows);
}

double worstTangent(const patient::TissueTable& table, const ToolSettings& s) noexcept {
    const auto padTangent = [](const PadSettings& pad) { return pad.stiffest_n_per_m + pad.shear_n_per_m; };
    return std::max({worstTangent(table, s.needle), s.guide.stiffness_n_per_m, padTangent(s.finger.pad),
                     padTangent(s.probe.pad), s.scalpel.stiffness_n_per_m});
}

void hashTools(StateHash& hash, const ToolState& s) noexcept {
    hash.add(std::uint64_t(s.in_hand) | std::uint64_t(s.waits) << 8 | std::uint64_t(s.guide.snapped) << 9 |
             std::uint64_t(s.probe.parked) << 10 | std::uint64_t(s.guide.free) << 11);
    hash.add(s.patient_from_tool);
    if (s.probe.parked) {
        hash.add(s.probe.skin_reference_m);
        hash.add(s.probe.patient_from_probe);
    }
    if (s.incisions.count > 0) hashIncisions(hash, s.incisions);
    if (s.in_hand == Tool::finger) hashPad(hash, s.finger.pad);
    if (s.in_hand == Tool::probe) hashPad(hash, s.held_probe.pad);
    if (s.in_hand == Tool::scalpel) hashScalpel(hash, s.scalpel);
    if (!holdsNeedle(s.in_hand)) return;
    hash.add(s.patient_from_needle);
    hashNeedle(hash, s.needle);
}

void hashToolSettings(StateHash& hash, const ToolSettings& s) noexcept {
    hash.add(std::uint64_t(s.first));
    eachToolCount(s, [&](int v) { hash.add(std::uint64_t(v)); });
    eachToolNumber(s, [&](double v) { hash.add(v); });
}

}  // namespace stylet::haptics
