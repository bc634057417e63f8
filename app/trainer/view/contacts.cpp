#include "app/trainer/view/contacts.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace stylet::trainer {
namespace {

using haptics::TickOutput;
using haptics::Tool;
using patient::ToolContact;

// Contact ids. A contact has the same id in every tick.
constexpr int kNeedleId = 0, kBladeId = 1, kFingerId = 2, kProbeId = 3, kParkedId = 8, kColumns = 5;
static_assert(kParkedId + kColumns <= patient::kMaxContacts && kProbeId + kColumns <= kParkedId);

constexpr double kNeedle_m = 0.004, kMaxSideways_m = 0.005, kMaxPressed_m = 0.020;
constexpr double kSkinShare = 0.5;  // the skin around the shaft moves by this fraction of the tip's drag
constexpr double kColumnStep_m = 0.012;

void addContact(ToolContacts& contacts, const ToolContact& c) {
    assert(contacts.count < patient::kMaxContacts);
    contacts.list[std::size_t(contacts.count++)] = c;
}

void addBall(ToolContacts& contacts, int id, const Vec3& tool_m, const Vec3& moved_m, double radius_m) {
    const Vec3 tissue_m = tool_m - moved_m;
    addContact(contacts, {id, tissue_m, tissue_m, moved_m, moved_m, radius_m});
}

// Before the puncture the skin moves with the tip. After it the needle drags the tissue along its shaft: by
// the full amount at the tip, by kSkinShare of it at the skin.
void addNeedle(ToolContacts& contacts, const TickOutput& out, const patient::Patient& patient) {
    if (out.phase == haptics::Phase::outside) return;
    const Vec3 inward = -out.patient_from_needle.direction(Vec3(0.0, 0.0, 1.0));
    const Vec3 tip_m = out.patient_from_needle.position_m;
    const Vec3 axial_m = out.extension_m * inward;
    if (out.phase == haptics::Phase::tenting && out.tissue == patient::Tissue::air)
        return addBall(contacts, kNeedleId, tip_m, axial_m, kNeedle_m);
    Vec3 sideways_m =
        tip_m - patient::deformedFromReference(patient.package().motion, out.breath, out.tip_reference_m);
    sideways_m -= glm::dot(sideways_m, inward) * inward;
    const double off_m = glm::length(sideways_m);
    if (off_m > kMaxSideways_m) sideways_m *= kMaxSideways_m / off_m;
    const Vec3 moved_m = axial_m + sideways_m, skin_moved_m = kSkinShare * axial_m;
    const Vec3 entry_m = tip_m - out.depth_m * inward;
    addContact(contacts, {kNeedleId, entry_m, tip_m - moved_m, skin_moved_m, moved_m, kNeedle_m});
}

// Displacement of the skin under a point of the tool's surface; zero if the point does not touch the skin.
Vec3 skinMovedBy(const Vec3& point_m, const TickOutput& out, const patient::Patient& patient,
                 const haptics::TouchMap& touch) {
    const Vec3 reference_m =
        patient::referenceFromDeformed(patient.package().motion, out.breath, patient::Side::outside, point_m);
    const haptics::TouchPoint at = haptics::touchAt(touch, reference_m);
    const double slope = glm::length(at.level_slope);
    if (!(at.level_m < 0.0) || !(slope > 0.0)) return Vec3(0.0);
    return -std::min(-at.level_m / slope, kMaxPressed_m) / slope * at.level_slope;
}

// Adds a capsule between each pair of neighbouring sample points of the probe's face.
void addProbe(ToolContacts& contacts, int id, const Pose& patient_from_tool, const TickOutput& out,
              const patient::Patient& patient, const PressInput& input) {
    const haptics::ProbeSettings& face = input.tools.probe;
    std::array<Vec3, kColumns> at_m, moved_m;
    for (int i = 0; i < kColumns; ++i) {
        const double x = (i - kColumns / 2) * kColumnStep_m;
        const double back = face.curvature_m - std::sqrt(face.curvature_m * face.curvature_m - x * x);
        const auto column = std::size_t(i);
        at_m[column] = patient_from_tool * Vec3(x, 0.0, back);
        moved_m[column] = skinMovedBy(at_m[column], out, patient, *input.touch);
    }
    for (std::size_t i = 0; i + 1 < std::size_t(kColumns); ++i) {
        const Vec3 &a = moved_m[i], &b = moved_m[i + 1];
        if (a != Vec3(0.0) || b != Vec3(0.0))
            addContact(contacts, {id + int(i), at_m[i] - a, at_m[i + 1] - b, a, b, 0.5 * face.width_m});
    }
}

}  // namespace

ToolContacts findContacts(const TickOutput& out, const patient::Patient& patient, const PressInput& input) {
    ToolContacts contacts;
    const Vec3 tip_m = out.patient_from_tool.position_m;
    if (haptics::isNeedleTool(out.tool)) addNeedle(contacts, out, patient);
    if (out.tool == Tool::scalpel && glm::length(out.tool_force.force_n) > 0.0)
        addBall(contacts, kBladeId, tip_m, -out.tool_force.force_n / input.tools.scalpel.stiffness_n_per_m,
                kNeedle_m);
    if (!input.touch) return contacts;
    if (out.tool == Tool::finger) {
        const Vec3 moved_m = skinMovedBy(tip_m, out, patient, *input.touch);
        if (moved_m != Vec3(0.0)) addBall(contacts, kFingerId, tip_m, moved_m, input.tools.finger.radius_m);
    }
    if (out.tool == Tool::probe && !out.probe_parked)
        addProbe(contacts, kProbeId, out.patient_from_tool, out, patient, input);
    if (out.probe_parked)
        addProbe(contacts, kParkedId, out.patient_from_probe * haptics::kStylusFromProbe.inverse(), out,
                 patient, input);
    return contacts;
}

ToolPress::ToolPress(const patient::Patient& patient, const PressInput& input)
    : patient_(&patient), input_(input), displacement_(patient) {}

const patient::DisplacementTable* ToolPress::shown(const TickOutput& out) {
    // A capture may be shown after a later tick. In that case, use a long time step.
    const bool onward = tick_ && out.tick >= *tick_;
    const double dt_s = onward ? double(out.tick - *tick_) * input_.tick_s : 1.0;
    tick_ = out.tick;
    const ToolContacts contacts = findContacts(out, *patient_, input_);
    return displacement_.update(contacts.all(), out.breath, dt_s) ? &displacement_.table() : nullptr;
}

}  // namespace stylet::trainer
