// What ultrasound and X-ray can see of one moment, and how their machines are set.
#pragma once

#include <array>
#include <optional>

#include "app/training/dose.h"
#include "app/training/machines.h"
#include "haptics/haptics.h"
#include "patient/contrast.h"
#include "patient/planning.h"
#include "patient/tool_displacement.h"

namespace stylet::trainer {

// Poses in the patient frame, deformed.
struct MachineMoment {
    double time_s = 0.0;
    patient::Surrogate breath;
    const patient::DisplacementTable* tool = nullptr;  // what tools displace; null: nothing
    std::optional<patient::Pose> patient_from_probe;   // probe frame: +z into the body
    // As RenderScene has them: what touches is at the origin, the hand at +z.
    std::optional<patient::Pose> patient_from_needle, patient_from_scalpel, patient_from_finger;
    std::optional<std::array<patient::Vec3, 2>> guide_m;  // the line that the guide holds a needle on
    const patient::ContrastTable* contrast = nullptr;     // null: none was injected
    patient::Pose patient_from_isocentre;                 // of the C-arm
    training::Machines machines;
    training::DoseLedger dose;
};

// But for displacement, contrast, machines and dose, which a tick does not know.
MachineMoment momentOf(const haptics::TickOutput&, const haptics::GuideSettings&, double tick_s);

// Where the C-arm is wheeled to: the target and the hilum in one picture, little beside the patient.
patient::Vec3 isocentreFor(const patient::PlannedPath&);

}  // namespace stylet::trainer
