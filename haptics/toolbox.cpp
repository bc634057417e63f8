#include "haptics/toolbox.h"

namespace stylet::haptics {

using patient::Patient;
using patient::StateHash;
using patient::Surrogate;

namespace {

bool isOutside(const Patient& patient, const Surrogate& breath, const Vec3& tip_m) noexcept {
    const Vec3 reference_m = patient::referenceFromDeformed(patient.package().motion, breath, tip_m);
    return patient.at(reference_m, {}).tissue == Tissue::air;
}

// Returns how far the breath has carried the probe.
Vec3 carryProbe(ParkedProbe& probe, const TouchTools* touch, const Patient& patient,
                const Surrogate& breath) noexcept {
    if (!probe.parked) return Vec3(0.0);
    const patient::MotionModel& motion = patient.package().motion;
    if (touch) {
        const Vec3 ridden = rideSkin(probe.rider, *touch->map, motion, breath);
        probe.patient_from_probe.position_m = probe.rider.at_m;
        return ridden;
    }
    const Vec3 now = patient::deformedFromReference(motion, breath, probe.skin_reference_m);
    const Vec3 moved = now - probe.patient_from_probe.position_m;
    probe.patient_from_probe.position_m = now;
    return moved;
}

ToolForce stepHeldNeedle(ToolState& s, const ToolSettings& settings, const Patient& patient,
                         const Surrogate& breath, const Vec3& probe_moved_m, NeedleEvents& events) noexcept {
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
    ToolForce force = stepNeedle(s.needle, settings.needle, patient, s.patient_from_needle.position_m, axis,
                                 breath, events, s.incisions);
    const Vec3 carried_m = probe_moved_m - axis * glm::dot(probe_moved_m, axis);
    if (railed && s.needle.phase == Phase::outside) force.tissue_moved_m = carried_m;
    if (s.guide.snapped) {
        // What pushes the needle sideways is the rail's to bear: the hand feels the rail.
        force.force_n = -s.needle.force_n * axis;
        force.energy_j = axialEnergy(s.needle, settings.needle, patient);
        force.tissue_moved_m = axis * glm::dot(force.tissue_moved_m, axis) + carried_m;
    }
    force.force_n += guided.force_n;
    force.energy_j += guided.energy_j;
    force.event = force.event || guided.event;
    return force;
}

ToolForce stepOnSkin(ToolState& s, const TouchTools& touch, const Patient& patient,
                     const Surrogate& breath) noexcept {
    const patient::MotionModel& motion = patient.package().motion;
    switch (s.in_hand) {
        case Tool::finger:
            return stepFinger(s.finger, touch.finger, touch.finger_pad, *touch.map, motion,
                              s.patient_from_tool, breath);
        case Tool::probe:
            return stepProbe(s.held_probe, touch.probe, touch.probe_pad, *touch.map, motion,
                             s.patient_from_tool, breath);
        case Tool::scalpel:
            return stepScalpel(s.scalpel, s.incisions, touch.scalpel, *touch.map, motion, s.patient_from_tool,
                               breath);
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
    s.finger = {};
    s.held_probe = {};
    s.scalpel = {};
    s.waits = s.waits || !keeps_needle;
    return true;
}

void parkProbe(ToolState& s, const TouchTools* touch, const Patient& patient, const Surrogate& breath,
               bool stay) noexcept {
    if (!stay) {
        s.waits = s.waits || (s.probe.parked && s.in_hand == Tool::probe);  // in hand again
        s.probe.parked = false;
        return;
    }
    if (s.in_hand != Tool::probe || s.waits || s.probe.parked) return;
    s.held_probe = {};
    s.probe.parked = true;
    s.probe.patient_from_probe = s.patient_from_tool * kStylusFromProbe;
    const patient::MotionModel& motion = patient.package().motion;
    const Vec3 face_m = s.probe.patient_from_probe.position_m;
    s.probe.skin_reference_m = patient::referenceFromDeformed(motion, breath, face_m);
    if (touch) s.probe.rider = parkOnSkin(*touch->map, motion, breath, face_m);
}

ToolForce stepTools(ToolState& s, const ToolSettings& settings, const TouchTools* touch,
                    const Patient& patient, const Pose& patient_from_stylus, const Surrogate& breath,
                    NeedleEvents& events) noexcept {
    s.patient_from_tool = patient_from_stylus;
    events.count = events.dropped = 0;
    const Vec3 probe_moved_m = carryProbe(s.probe, touch, patient, breath);
    if (s.waits) {
        if (!isOutside(patient, breath, patient_from_stylus.position_m)) return {};
        s.waits = false;
    }
    if (s.in_hand == Tool::probe && s.probe.parked) return {};  // the hand is empty
    if (holdsNeedle(s.in_hand)) return stepHeldNeedle(s, settings, patient, breath, probe_moved_m, events);
    return touch ? stepOnSkin(s, *touch, patient, breath) : ToolForce{};
}

void hashTools(StateHash& hash, const ToolState& s) noexcept {
    hash.add(std::uint64_t(s.in_hand) | std::uint64_t(s.waits) << 8 | std::uint64_t(s.guide.snapped) << 9 |
             std::uint64_t(s.probe.parked) << 10);
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
    hash.add(s.guide.across_m);
    hashNeedle(hash, s.needle);
}

void hashToolSettings(StateHash& hash, const ToolSettings& s) noexcept {
    hash.add(std::uint64_t(s.first));
    eachToolNumber(s, [&](double v) { hash.add(v); });
}

}  // namespace stylet::haptics
