#include "app/training/infiltration.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace stylet::training {

using haptics::TickOutput;
using patient::AnaestheticVolumes;
using patient::Tissue;

namespace {

constexpr double kPitch_m = 0.001;        // of a track's points
constexpr double kBesideTrack_m = 0.008;  // a depot further from the track does not numb it
constexpr double kWhealDepth_m = 0.006;   // below the skin
constexpr double kBeforeCapsule_m = 0.008, kPastCapsule_m = 0.002;
constexpr double kEndShare = 0.4;  // of a short track: each end has at most this share
constexpr double kAstray_m3 = 0.3e-6;
constexpr double kRailBeforeSkin_m = 0.060;

}  // namespace

WallTrack makeWallTrack(const patient::Patient& patient, const patient::Surrogate& breath, const Vec3& from_m,
                        const Vec3& inward, double length_m) {
    const patient::MotionModel& motion = patient.package().motion;
    WallTrack track;
    for (double at_m = 0.0; at_m <= length_m; at_m += kPitch_m) {
        const Vec3 p = patient::referenceFromDeformed(motion, breath, from_m + inward * at_m);
        const Tissue tissue = patient.at(p, {true, false}).tissue;
        if (track.empty() && tissue == Tissue::air) continue;
        track.push_back(p);
        if (tissue == Tissue::liver) return track;
    }
    return {};
}

double capsuleDepth_m(const patient::Patient& patient, const patient::PlannedPath& path) {
    const Vec3 way_m = path.target_m - path.entry_m;
    const double length_m = glm::length(way_m);
    const WallTrack track = makeWallTrack(patient, path.breath, path.entry_m, way_m / length_m, length_m);
    return track.empty() ? 0.0 : kPitch_m * double(track.size() - 1);
}

Infiltration::Infiltration(const patient::Patient& patient, const patient::PlannedPath& path)
    : patient_(&patient), length_m_(glm::length(path.target_m - path.entry_m)) {
    if (!(length_m_ > 0.0)) return;
    const Vec3 inward = (path.target_m - path.entry_m) / length_m_;
    tracks_[0].points = makeWallTrack(patient, path.breath, path.entry_m, inward, length_m_);
}

void Infiltration::update(const TickOutput& now, const AttemptFold& fold,
                          const haptics::GuideSettings& guide) {
    if (now.probe_parked && !parked_) {
        const Pose rail = now.patient_from_probe * guide.probe_from_guide;
        tracks_[1] = {makeWallTrack(*patient_, now.breath, rail.position_m, rail.direction({0, 0, -1}),
                                    kRailBeforeSkin_m + length_m_)};
    }
    parked_ = now.probe_parked;
    const bool was_outside = place_ == TrackPlace::outside;
    findPlace(now);
    addInjected(now, fold.anaesthetic().volumes());
    judgeInjection(fold.anaesthetic().volumes(), fold.equipment().anaesthetic_m3_per_s > 0.0);
    const bool outside = place_ == TrackPlace::outside;
    if (was_outside && !outside) at_entry_m3_ = last_.tissue_m3;
    // The needle is drawn out: the step was tried.
    if (!was_outside && outside && last_.tissue_m3 > at_entry_m3_ && !done()) refusal_ = missing();
}

Refusal Infiltration::missing() const noexcept {
    if (fuller().skin_m3 < kWheal_m3) return Refusal::skinNotNumb;
    return fuller().capsule_m3 < kCapsuleDepot_m3 ? Refusal::capsuleNotNumb : Refusal::none;
}

std::pair<double, double> Infiltration::depotAtTip_m3() const noexcept {
    if (place_ == TrackPlace::skin) return {tracks_[at_].skin_m3, kWheal_m3};
    if (place_ == TrackPlace::capsule) return {tracks_[at_].capsule_m3, kCapsuleDepot_m3};
    return {};
}

const Infiltration::Track& Infiltration::fuller() const noexcept {
    const auto counted_m3 = [](const Track& t) {
        return std::min(t.skin_m3, kWheal_m3) + std::min(t.capsule_m3, kCapsuleDepot_m3);
    };
    return counted_m3(tracks_[1]) > counted_m3(tracks_[0]) ? tracks_[1] : tracks_[0];
}

void Infiltration::findPlace(const TickOutput& now) noexcept {
    place_ = TrackPlace::outside;
    if (now.phase == haptics::Phase::outside || now.access.open) return;
    // The fuller track goes first: the tutor leads along it.
    const std::size_t first = &fuller() == &tracks_[0] ? 0 : 1;
    for (const std::size_t track : {first, 1 - first}) {
        place_ = placeOn(tracks_[track].points, now.tip_reference_m);
        at_ = track;
        if (place_ != TrackPlace::aside) return;
    }
    if (now.tissue == Tissue::liver) place_ = TrackPlace::beyond;
}

TrackPlace Infiltration::placeOn(const WallTrack& track, const Vec3& tip_m) noexcept {
    if (track.size() < 2) return TrackPlace::aside;
    std::size_t nearest = track.size();
    double beside_m = kBesideTrack_m;
    for (std::size_t i = 0; i < track.size(); ++i)
        if (const double d = glm::distance(track[i], tip_m); d < beside_m) nearest = i, beside_m = d;
    if (nearest == track.size()) return TrackPlace::aside;
    const Vec3 inward = glm::normalize(track.back() - track.front());
    const double past_m = glm::dot(tip_m - track.back(), inward);
    if (past_m > kPastCapsule_m) return TrackPlace::beyond;
    const double length_m = kPitch_m * double(track.size() - 1), depth_m = kPitch_m * double(nearest);
    if (depth_m <= std::min(kWhealDepth_m, kEndShare * length_m)) return TrackPlace::skin;
    return length_m - depth_m <= std::min(kBeforeCapsule_m, kEndShare * length_m) ? TrackPlace::capsule
                                                                                  : TrackPlace::wall;
}

void Infiltration::addInjected(const TickOutput& tick, const AnaestheticVolumes& now) {
    const double tissue_m3 = now.tissue_m3 - last_.tissue_m3;
    last_ = now;
    for (Track& track : tracks_) {
        const TrackPlace place =
            place_ == TrackPlace::outside ? place_ : placeOn(track.points, tick.tip_reference_m);
        if (place == TrackPlace::skin) track.skin_m3 += tissue_m3;
        if (place == TrackPlace::capsule) track.capsule_m3 += tissue_m3;
    }
    if (place_ == TrackPlace::aside) aside_m3_ += tissue_m3;
    if (place_ == TrackPlace::beyond) beyond_m3_ += tissue_m3;
}

// At most one refusal for each injection, as soon as it is known.
void Infiltration::judgeInjection(const AnaestheticVolumes& now, bool flows) {
    if (flows && !std::exchange(flows_, flows)) {
        at_start_ = now;
        aside_at_start_m3_ = aside_m3_;
        beyond_at_start_m3_ = beyond_m3_;
        refused_ = false;
    }
    flows_ = flows;
    if (now.injected_m3 > kUsualAnaesthetic_m3 && !std::exchange(too_much_, true)) {
        refusal_ = Refusal::tooMuchAnaesthetic;
        refused_ = true;
    }
    if (!flows || refused_) return;
    const double aside_m3 = aside_m3_ - aside_at_start_m3_, beyond_m3 = beyond_m3_ - beyond_at_start_m3_;
    const Refusal why = now.vessels_m3 - at_start_.vessels_m3 >= kAstray_m3 ? Refusal::anaestheticInVessel
                        : now.lost_m3 - at_start_.lost_m3 >= kAstray_m3     ? Refusal::anaestheticLost
                        : aside_m3 + beyond_m3 < kAstray_m3                 ? Refusal::none
                        : beyond_m3 > aside_m3                              ? Refusal::anaestheticBeyond
                                                                            : Refusal::anaestheticAside;
    refused_ = why != Refusal::none;
    if (refused_) refusal_ = why;
}

}  // namespace stylet::training
