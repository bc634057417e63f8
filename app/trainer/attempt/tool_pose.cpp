#include "app/trainer/attempt/tool_pose.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace stylet::trainer {

Pose toolPoseFromNeedle(const Pose& patient_from_needle, haptics::Tool tool,
                        const haptics::GuideSettings& guide) {
    if (tool != haptics::Tool::probe) return patient_from_needle;
    const Pose& probe_from_guide = guide.probe_from_guide;
    const Vec3 in = probe_from_guide.direction({0, 0, -1});
    const double mouth_to_face_m = -probe_from_guide.position_m.z / in.z;
    const Pose guide_from_tip{{1, 0, 0, 0}, {0, 0, -mouth_to_face_m}};
    const Pose guide_from_stylus =
        guide_from_tip.inverse() * probe_from_guide.inverse() * haptics::kStylusFromProbe.inverse();
    return patient_from_needle * guide_from_stylus;
}

Pose needlePose(const Vec3& tip_m, const Vec3& axis) {
    // The roll about the shaft is free. Choose the needle's x axis perpendicular to the patient's long axis
    // (z), or to the front direction (y) if the shaft is nearly parallel to z.
    const Vec3 z = -axis;
    const Vec3 across = std::fabs(z.z) < 0.9 ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
    const Vec3 x = glm::normalize(glm::cross(across, z));
    return {glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)), tip_m};
}

Quat rotationBetween(const Vec3& from, const Vec3& to) {
    const Vec3 axis = glm::cross(from, to);
    const double twice_cosine = 1.0 + glm::dot(from, to);
    if (!(twice_cosine > 1e-9)) {  // opposite: about any axis across
        const Vec3 across = glm::cross(from, std::fabs(from.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0));
        return {0.0, glm::normalize(across)};
    }
    return glm::normalize(Quat{twice_cosine, axis.x, axis.y, axis.z});
}

}  // namespace stylet::trainer
