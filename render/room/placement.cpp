#include "render/room/placement.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

namespace stylet::render {
namespace {

constexpr double kMinTableHeight_m = 0.2;
constexpr double kIsocentreAbovePad_m = 0.12;

Pose upright(const Vec3& position_m, const Vec3& forward) {
    const Vec3 z = glm::normalize(Vec3(forward.x, 0.0, forward.z) + Vec3(0.0, 0.0, 1e-9));
    const Vec3 y(0.0, 1.0, 0.0);
    return {glm::quat_cast(glm::dmat3(glm::cross(y, z), y, z)), position_m};
}

Lamp lampOver(const Vec3& field_stage, const Vec3& lamp_from_field) {
    const Vec3 z = lamp_from_field;
    const Vec3 flat = glm::cross(Vec3(0.0, 1.0, 0.0), z);
    const Vec3 x = glm::length(flat) > 1e-3 ? glm::normalize(flat) : Vec3(1.0, 0.0, 0.0);
    const Vec3 at = field_stage + kLampDistance_m * z;
    return {at, field_stage, {glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)), at}};
}

}  // namespace

const Vec3 kLampFromField = glm::normalize(Vec3(0.45, 0.9, 0.15));

Pose patientFromTable(const PatientVolume& volume) {
    const Grid& grid = volume.patient().grid();
    const Vec3 middle = grid.origin_m + 0.5 * grid.spacing_m * Vec3(grid.dims - 1);
    return {Quat(1, 0, 0, 0), Vec3(middle.x, volume.backHeight(), middle.z)};
}

Placement computePlacement(const RenderScene& scene, const PatientVolume* volume) {
    Placement placed;
    placed.stage_from_table = scene.stage_from_patient * (volume ? patientFromTable(*volume) : Pose{});
    const Vec3 table = placed.stage_from_table.position_m;
    placed.table_height_m = std::max(kMinTableHeight_m, table.y);
    placed.stage_from_room =
        upright({table.x, 0.0, table.z}, placed.stage_from_table.direction({0.0, 0.0, 1.0}));
    const Vec3 beside = placed.stage_from_table * Vec3(0.16, 0.10, 0.0);
    const Vec3 field = scene.field_m ? scene.stage_from_patient * *scene.field_m : beside;
    placed.lamp = lampOver(field, scene.stage_from_patient.direction(kLampFromField));
    return placed;
}

Pose stageFromIsocentre(const RenderScene& scene, const CArm& arm, const Placement& placed) {
    const Pose room_from_stage = placed.stage_from_room.inverse();
    if (arm.isocentre_m)
        return {placed.stage_from_room.rotation, scene.stage_from_patient * *arm.isocentre_m};
    Vec3 isocentre = room_from_stage * placed.stage_from_table.position_m;
    isocentre.y = placed.table_height_m + kIsocentreAbovePad_m;
    if (scene.field_m) isocentre.z = (room_from_stage * (scene.stage_from_patient * *scene.field_m)).z;
    return placed.stage_from_room * Pose{{1.0, 0.0, 0.0, 0.0}, isocentre};
}

CArmPoses cArmPoses(const RenderScene& scene, const CArm& arm, const Placement& placed) {
    const Pose standing = stageFromIsocentre(scene, arm, placed);
    const Pose turned = standing * Pose{glm::angleAxis(arm.angulation_rad, Vec3(1.0, 0.0, 0.0)), Vec3(0.0)};
    const Pose slid{glm::angleAxis(arm.orbital_rad, Vec3(0.0, 0.0, 1.0)), Vec3(0.0)};
    return {standing, turned, turned * slid};
}

glm::dvec2 findElbow(const glm::dvec2& from, const glm::dvec2& to, double first_m, double second_m) {
    const glm::dvec2 way = to - from;
    const double reach = std::max(glm::length(way), 1e-6);
    const glm::dvec2 along = way / reach;
    const double d = std::min(reach, first_m + second_m);
    const double near =
        std::clamp((d * d + first_m * first_m - second_m * second_m) / (2.0 * d), -first_m, first_m);
    const double off = std::sqrt(std::max(0.0, first_m * first_m - near * near));
    return from + near * along + off * glm::dvec2(-along.y, along.x);
}

glm::dmat4 scaled(glm::dmat4 m, const Vec3& scale) {
    for (int axis = 0; axis < 3; ++axis)
        m[axis] *= scale[axis];
    return m;
}

glm::dmat4 tubeBetween(const Vec3& a, const Vec3& b, double radius_m) {
    const Vec3 along = b - a;
    const Vec3 axis = glm::normalize(along);
    const Vec3 side =
        glm::normalize(glm::cross(std::fabs(axis.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0), axis));
    glm::dmat4 m(1.0);
    m[0] = glm::dvec4(side * radius_m, 0.0);
    m[1] = glm::dvec4(glm::cross(axis, side) * radius_m, 0.0);
    m[2] = glm::dvec4(along, 0.0);
    m[3] = glm::dvec4(a, 1.0);
    return m;
}

}  // namespace stylet::render
