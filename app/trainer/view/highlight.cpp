#include "app/trainer/view/highlight.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/tool_pose.h"
#include "app/trainer/view/access_tubes.h"
#include "app/training/evidence.h"

namespace stylet::trainer {

using haptics::Tool;
using render::Highlight;
using training::Act;

namespace {

using Highlights = std::vector<Highlight>;

// Rings: around a place on the skin, the end of an instrument, the probe, and a place on the instrument
// table.
constexpr double kSkinRing_m = 0.012, kRibRing_m = 0.016, kEndRing_m = 0.012, kProbeRing_m = 0.045,
                 kTableRing_m = 0.10;
constexpr double kArrow_m = 0.04, kRoomArrow_m = 0.15;
constexpr double kAboveSkin_m = 0.002;  // so that a curved skin does not cover the ring
constexpr double kPlaceRing_m = 0.036, kAbovePlace_m = 0.006;  // around the probe that stands there
constexpr double kBesideProbe_m = 0.040, kAboveFace_m = 0.020, kBehindProbe_m = 0.15;
constexpr double kBeyondEnd_m = 0.02;  // from an instrument's end to an arrow
constexpr double kInPlane_m = 0.004;   // a duct this near lies in the picture's plane
constexpr double kSkinSearch_m = 0.08, kSkinSample_m = 0.001;
const Vec3 kStraightDown{0.0, -1.0, 0.0};
// Above the equipment, room frame.
constexpr double kTableTop_m = 0.90, kUltrasoundTop_m = 1.50, kMonitorTop_m = 0.24;

Highlight inRoom(const Vec3& thing, double up_m, double ring_m = 0.0) {
    return {true, thing + Vec3(0.0, up_m, 0.0), kStraightDown, ring_m, kRoomArrow_m};
}
Highlight ring(const Vec3& at_m, const Vec3& along, double ring_m) {
    return {.at_m = at_m, .along = along, .ring_m = ring_m};
}
// From a place toward a direction, or with `ends_there` from before the place to it.
Highlight arrow(const Vec3& at_m, const Vec3& along, bool ends_there = true) {
    return {.at_m = ends_there ? at_m : at_m + kArrow_m * along, .along = along, .arrow_m = kArrow_m};
}

}  // namespace

// The places at one tick, patient frame.
class PromptPlaces::AtTick {
  public:
    AtTick(const PromptPlaces& places, const FrameState& seen)
        : places_(places),
          seen_(seen),
          tick_(seen.tick),
          entry_m_(deformed(places.path_.entry_reference_m)),
          target_m_(deformed(places.path_.target_reference_m)),
          inward_(glm::normalize(target_m_ - entry_m_)) {}

    Vec3 deformed(const Vec3& reference_m) const {
        return patient::deformedFromReference(places_.patient_->package().motion, tick_.breath, reference_m);
    }

    Highlight onSkin(const Vec3& skin_m, double ring_m) const {
        return ring(skin_m - kAboveSkin_m * inward_, inward_, ring_m);
    }
    Highlights entry() const { return {onSkin(entry_m_, kSkinRing_m), arrow(entry_m_, inward_)}; }
    Highlights rib(const std::optional<Vec3>& reference_m) const {
        if (!reference_m) return entry();
        const Vec3 at_m = deformed(*reference_m);
        return {onSkin(at_m, kRibRing_m), arrow(at_m, inward_)};
    }
    // Where the parked probe's guide meets the skin, else the path's entry.
    Highlights cutPlace() const {
        return {onSkin(tick_.probe_parked ? guideOnSkin() : entry_m_, kSkinRing_m)};
    }

    // The place of a probe whose guide lies on the path, turned about the path as the probe is now.
    Highlights probePlace() const {
        const Pose needle_from_probe = toolPoseFromNeedle({}, Tool::probe, places_.guide_);
        const Pose needle = tick_.patient_from_tool * needle_from_probe.inverse();
        const Quat swing = rotationBetween(needle.direction({0.0, 0.0, -1.0}), inward_);
        const Pose probe = Pose{swing * needle.rotation, entry_m_} * needle_from_probe;
        const Vec3 in = probe.direction({0.0, 0.0, -1.0});
        return {ring(probe.position_m - kAbovePlace_m * in, in, kPlaceRing_m), arrow(probe.position_m, in)};
    }
    Highlights aroundProbe() const {
        const Vec3 out = probeOut();
        return {ring(probeFace() + kAboveFace_m * out, out, kProbeRing_m)};
    }
    // Away from the skin.
    Highlights offSkin() const {
        return {arrow(probeFace() + kBehindProbe_m * probeOut(), probeOut(), false)};
    }
    // Along the skin, toward the duct: across the picture's plane, or along it.
    Highlights toDuct() const {
        const Pose patient_from_probe = probePose();
        const Vec3 duct = patient_from_probe.inverse() * target_m_;
        const Vec3 side = std::fabs(duct.y) > kInPlane_m ? Vec3(0.0, std::copysign(1.0, duct.y), 0.0)
                                                         : Vec3(std::copysign(1.0, duct.x), 0.0, 0.0);
        return {shift(patient_from_probe.direction(side))};
    }
    // The guide's line, and the direction in which it must be shifted to meet the duct.
    Highlights toGuideLine() const {
        const Pose rail = railPose();
        const Vec3 in = rail.direction({0.0, 0.0, -1.0});
        const Vec3 off_m = target_m_ - rail.position_m, across_m = off_m - in * glm::dot(off_m, in);
        Highlight line{.at_m = guideOnSkin(), .along = in, .arrow_m = places_.guide_.length_m};
        if (!(glm::length(across_m) > 0.0)) return {line};
        return {line, shift(glm::normalize(across_m))};
    }
    // The guide's upper end, and the direction of the rail.
    Highlights railEnd() const {
        const Pose rail = railPose();
        const Vec3 end_m = rail * Vec3(0.0, 0.0, places_.guide_.length_m);
        const Vec3 in = rail.direction({0.0, 0.0, -1.0});
        return {ring(end_m, in, kSkinRing_m), arrow(end_m, in)};
    }

    Highlights toolTip() const {
        const Vec3 out = tick_.patient_from_tool.direction({0.0, 0.0, 1.0});
        const Vec3 tip_m = tick_.patient_from_tool.position_m;
        return {ring(tip_m, out, kEndRing_m), arrow(tip_m + kBeyondEnd_m * out, out, false)};
    }
    Highlights needleEntry() const {
        const Pose& needle = tick_.patient_from_needle;
        const Vec3 out = needle.direction({0.0, 0.0, 1.0});
        return {ring(needle.position_m + (tick_.depth_m + kAboveSkin_m) * out, out, kSkinRing_m)};
    }
    Highlights hub() const { return {ring(hubPlace(), hubOut(), kEndRing_m)}; }
    Highlights drawNeedle() const {
        return {ring(hubPlace(), hubOut(), kEndRing_m),
                arrow(hubPlace() + kBeyondEnd_m * hubOut(), hubOut(), false)};
    }

    // Wire, dilator and drain outside the body lie on the straight track.
    Highlights access() const { return {ring(outsideEnd(), trackInward(), kEndRing_m)}; }
    Highlights pushAccess() const {
        return {arrow(outsideEnd() - kBeyondEnd_m * trackInward(), trackInward())};
    }
    Highlights pullAccess() const {
        return {arrow(outsideEnd() - kBeyondEnd_m * trackInward(), -trackInward(), false)};
    }

    static Highlights table() { return {inRoom(render::kTrolley, kTableTop_m, kTableRing_m)}; }
    // An instrument that is in use already is not on the table.
    Highlights take(bool in_use, const Highlights& place) const { return in_use ? place : table(); }

  private:
    Pose probePose() const {
        return tick_.probe_parked ? tick_.patient_from_probe
                                  : tick_.patient_from_tool * haptics::kStylusFromProbe;
    }
    Pose railPose() const { return probePose() * places_.guide_.probe_from_guide; }
    Vec3 probeFace() const { return probePose().position_m; }
    Vec3 probeOut() const { return probePose().direction({0.0, 0.0, -1.0}); }
    Highlight shift(const Vec3& along) const {
        return arrow(probeFace() + kAboveFace_m * probeOut() + kBesideProbe_m * along, along, false);
    }
    Vec3 guideOnSkin() const {
        const Pose rail = railPose();
        const patient::MotionModel& motion = places_.patient_->package().motion;
        for (double deep_m = 0.0; deep_m < kSkinSearch_m; deep_m += kSkinSample_m) {
            const Vec3 at_m = rail * Vec3(0.0, 0.0, -deep_m);
            const Vec3 reference_m = patient::referenceFromDeformed(motion, tick_.breath, at_m);
            if (places_.patient_->at(reference_m, {true, false}).tissue != patient::Tissue::air) return at_m;
        }
        return entry_m_;
    }
    Vec3 hubOut() const { return tick_.patient_from_needle.direction({0.0, 0.0, 1.0}); }
    Vec3 hubPlace() const { return tick_.patient_from_needle * Vec3(0.0, 0.0, seen_.needle.length_m); }
    Vec3 trackInward() const {
        return glm::normalize(deformed(tick_.access.base_m) - deformed(tick_.access.entry_m));
    }
    // Of the wire, dilator or drain; the needle's hub while it surrounds the wire.
    Vec3 outsideEnd() const {
        if (tick_.access.needle_in) return hubPlace();
        return deformed(tick_.access.entry_m) - kTubeOutside_m * trackInward();
    }

    const PromptPlaces& places_;
    const FrameState& seen_;
    const haptics::TickOutput& tick_;
    Vec3 entry_m_, target_m_, inward_;
};

PromptPlaces::PromptPlaces(const patient::Patient& patient, const patient::PlannedPath& path,
                           const haptics::GuideSettings& guide)
    : patient_(&patient),
      path_(path),
      guide_(guide),
      upper_rib_m_(training::skinOverRib(patient, path, 1.0)),
      lower_rib_m_(training::skinOverRib(patient, path, -1.0)) {}

std::vector<Highlight> PromptPlaces::highlights(Act act, const FrameState& seen) const {
    const AtTick at(*this, seen);
    const haptics::AccessOutput& access = seen.tick.access;
    switch (act) {
        case Act::selectFinger:
        case Act::selectProbe:
        case Act::selectScalpel:
        case Act::selectGuide:
        case Act::selectSyringe:
            return at.table();
        case Act::pressGap:
            return at.entry();
        case Act::pressUpperRib:
            return at.rib(upper_rib_m_);
        case Act::pressLowerRib:
            return at.rib(lower_rib_m_);
        case Act::placeProbe:
            return at.probePlace();
        case Act::shiftProbe:
            return at.toDuct();
        case Act::turnProbe:
        case Act::holdProbeStill:
        case Act::parkProbe:
            return at.aroundProbe();
        case Act::liftProbe:
            return at.offSkin();
        case Act::aimGuide:
            return at.toGuideLine();
        case Act::cut:
        case Act::enterWheal:
        case Act::enterSkin:
            return at.cutPlace();
        case Act::snapNeedle:
            return at.railEnd();
        case Act::advance:
            return {inRoom(render::kUltrasound, kUltrasoundTop_m)};
        case Act::liftOff:
            return at.toolTip();
        case Act::withdrawToRetry:
        case Act::withdrawNeedle:
        case Act::pullNeedleBack:
        case Act::withdrawNumbingNeedle:
            return at.drawNeedle();
        case Act::seekDuct:
        case Act::pushToCapsule:
            return at.needleEntry();
        case Act::aspirate:
        case Act::inject:
        case Act::numbSkin:
        case Act::numbCapsule:
            return at.hub();
        case Act::pressPedal:
        case Act::releasePedal:
            return {inRoom(render::kXrayMonitor, kMonitorTop_m)};
        case Act::holdBreath:
            return {inRoom(render::kPatientMonitor, kMonitorTop_m)};
        case Act::selectNeedle:
            return at.take(access.needle_in, at.hub());
        case Act::selectWire:
        case Act::selectDilator:
        case Act::selectDrain: {
            const bool in_use = act == Act::selectWire      ? access.wire_in
                                : act == Act::selectDilator ? access.dilator_m > 0.0
                                                            : access.drain != haptics::DrainState::none;
            return at.take(in_use, in_use ? at.access() : Highlights{});
        }
        case Act::feedWire:
        case Act::pushDilator:
        case Act::pushDrain:
        case Act::shiftDrainIn:
        case Act::straightenDrain:
            return at.pushAccess();
        case Act::pullWireBack:
        case Act::withdrawDilator:
        case Act::withdrawDrain:
        case Act::shiftDrainOut:
        case Act::withdrawWire:
        case Act::clearDrain:
            return at.pullAccess();
        case Act::rewireDrain:
        case Act::injectDrain:
            return at.access();
        default:
            return {};  // stopInjecting, finish
    }
}

}  // namespace stylet::trainer
