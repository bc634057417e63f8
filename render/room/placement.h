// Poses of the room's equipment. All follow from the patient's pose, the access field and the C-arm's
// angles.
#pragma once

#include <glm/mat4x4.hpp>

#include "render/scene/scene.h"
#include "render/volume/patient_volume.h"

namespace stylet::render {

// Pose of the table's top: under the trunk, touching the back.
Pose patientFromTable(const PatientVolume&);

struct Lamp {
    Vec3 stage_m{0.0};     // middle of the lamp, stage
    Vec3 field_m{0.0};     // point that it shines at, stage
    Pose stage_from_head;  // shines along -z
};

struct Placement {
    Pose stage_from_room;   // upright; origin on the floor below the table's middle
    Pose stage_from_table;  // top of the pad
    double table_height_m = 1.0;
    Lamp lamp;
};

// Direction from the field to the lamp, patient frame: over the right flank.
extern const Vec3 kLampFromField;
inline constexpr double kLampDistance_m = 1.08;

// `volume` may be null: then the table's middle is the patient's origin.
Placement computePlacement(const RenderScene&, const PatientVolume* volume);

// The three moving parts of the C-arm.
struct CArmPoses {
    Pose stage_from_stand, stage_from_carriage, stage_from_arc;
};
// Axes of a patient who lies straight: right, up, head.
Pose stageFromIsocentre(const RenderScene&, const CArm&, const Placement&);
CArmPoses cArmPoses(const RenderScene&, const CArm&, const Placement&);

// Elbow of a chain of two links of these lengths from `from` to `to`, in a horizontal plane. If `to` is out
// of reach, the chain is straight.
glm::dvec2 findElbow(const glm::dvec2& from, const glm::dvec2& to, double first_m, double second_m);

glm::dmat4 scaled(glm::dmat4, const Vec3& scale);
// Maps z from 0 to 1 to the line from a to b, and the unit circle about z to `radius_m`.
glm::dmat4 tubeBetween(const Vec3& a, const Vec3& b, double radius_m);

}  // namespace stylet::render
