// Input of the ultrasound and X-ray pictures at one instant: poses, contrast medium and equipment settings.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/training/dose.h"
#include "app/training/equipment.h"
#include "base/curved_tube.h"
#include "haptics/haptics.h"
#include "patient/contrast/contrast.h"
#include "patient/displacement/tool_displacement.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// The ultrasound probe of an attempt. Its face is the one that is felt (haptics::ProbeSettings).
struct UltrasoundProbe {
    std::string transducer = "convex";  // name of its acoustic part, a file in assets/ultrasound
    double length_m = 0.060, curvature_m = 0.060;
    friend bool operator==(const UltrasoundProbe&, const UltrasoundProbe&) = default;
};

// Poses are in the patient frame and refer to the deformed anatomy.
struct ImagingInput {
    double time_s = 0.0;
    patient::Surrogate breath;
    const patient::DisplacementTable* tool = nullptr;  // tissue displacement by tools; null: none
    std::optional<Pose> patient_from_probe;            // probe frame: +z into the body
    // Same convention as RenderScene: the origin is the contact point, and +z points to the hand.
    std::optional<Pose> patient_from_needle, patient_from_scalpel, patient_from_finger;
    NeedleShape needle;
    UltrasoundProbe probe{};
    std::vector<CurvedTube> tubes{};                   // guide wire, dilator and drain
    std::vector<patient::Stain> depots{};              // of local anaesthetic
    std::optional<std::array<Vec3, 2>> guide_m;        // line on which the guide keeps the needle
    const patient::ContrastTable* contrast = nullptr;  // null: none injected
    Pose patient_from_isocentre;                       // pose of the C-arm's isocentre
    training::Equipment equipment;
    training::DoseLedger dose;
};

// Fills in all values that a tick contains. Tubes, tool displacement, contrast medium, isocentre, equipment
// state and dose keep their defaults.
ImagingInput makeImagingInput(const haptics::TickOutput&, const NeedleShape&, const haptics::GuideSettings&,
                              double tick_s);

}  // namespace stylet::trainer
