// Computes the section of the needle's path inside one voxel (model, section 3): handles the border at the
// voxel's entry, then moves the needle by the voxel's share of the travel. Implements the four phases.
// Private to needle.cpp, which computes the motion and looks up the tissue.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "base/traversal.h"
#include "haptics/tools/needle.h"
#include "haptics/tools/tenting.h"

namespace stylet::haptics {

using patient::Role;
using patient::TissueRow;
using patient::TissueSample;

// Depths that differ by less than this are equal: the sum of a path's sections rounds differently from its
// length.
inline constexpr double kSamePlace_m = 1e-9;
// Air within this depth of the track's start is outside the body.
inline constexpr double kSurface_m = 1e-6;

// The needle is outside the body. Its cut borders remain.
inline void endTrack(NeedleState& s) noexcept {
    s.phase = Phase::outside;
    s.tissue = Tissue::air;
    s.label = 0;
    s.extension_m = 0.0;
    s.depth_m = 0.0;
    s.track = {};
    s.past_skin_depth_m = s.past_fascia_depth_m = 0.0;
    s.queued_count = 0;
    s.bone_over_tenting = false;
}

// Appends to a list of fixed size. A full list loses its oldest entry.
template <typename T, std::size_t N>
void pushBack(std::array<T, N>& list, int& count, const std::type_identity_t<T>& entry) noexcept {
    if (std::size_t(count) == N) {
        std::copy(list.begin() + 1, list.end(), list.begin());
        --count;
    }
    list[std::size_t(count++)] = entry;
}

enum class Direction { advance, withdraw, sideways };

class SectionSolver {
  public:
    // `into_reference`: the direction of the shaft, into the body, in the reference frame.
    SectionSolver(NeedleState& state, const NeedleSettings& settings, const patient::Patient& patient,
                  NeedleEvents& events, const Incisions& incisions, const Vec3& into_reference) noexcept
        : s_(state),
          settings_(settings),
          patient_(patient),
          events_(events),
          incisions_(incisions),
          into_reference_(into_reference) {}

    // Haptics thread. Enters `voxel` at `at_reference_m` and moves `travel_m` along the axis inside it.
    void run(const Index3& voxel, const Vec3& at_reference_m, double travel_m, Direction direction) noexcept {
        // A withdrawal enters tissue that the needle met before it set the flags.
        if (direction == Direction::withdraw) clearFlags(kSamePlace_m);
        const TissueSample sample = patient_.at(voxel, s_.track);
        if (s_.phase == Phase::outside && sample.tissue == Tissue::air) return;
        if (!staysOnBone(voxel, direction)) {
            if (direction != Direction::withdraw) {
                setFlags(sample);
                if (sample.tissue == Tissue::air && !s_.track.past_skin)
                    return leaveFold(sample, at_reference_m);
            }
            arrive(sample, at_reference_m, direction);
            if (s_.phase == Phase::outside) return;
        }
        if (travel_m > 0.0) advance(travel_m);
        if (travel_m < 0.0) withdraw(travel_m);
        clearFlags(-kSamePlace_m);
        const bool outside = s_.tissue == Tissue::air && (s_.depth_m <= kSurface_m || !s_.track.past_skin);
        if (direction != Direction::advance && s_.phase == Phase::pass && outside) {
            report(NeedleEventKind::withdrawn,
                   Border{at_reference_m, Tissue::skin, Tissue::air, 0, s_.depth_m}, 0.0, 0.0);
            leaveTrack();
        }
    }

    // Haptics thread. Returns the axial force of the current state.
    double force() const noexcept {
        if (s_.phase == Phase::outside) return 0.0;
        if (s_.phase == Phase::pass || s_.tenting.depth_m < 0.0)
            return row(s_.tissue).stiffness_n_per_m * s_.extension_m;
        const double f = curve().force_n(s_.tenting.depth_m);
        return onRigid() ? std::min(f, std::max(settings_.max_force_n, s_.tenting.a0_n)) : f;
    }

    // True if the tip left a tissue or a tenting border in this step, even if only at a voxel corner before
    // re-entering the same tissue. The force may have jumped.
    bool hasLeft() const noexcept { return has_left_; }

  private:
    const TissueRow& row(Tissue t) const noexcept { return patient_.row(t); }
    TentingCurve curve() const noexcept {
        return tentingCurve(row(s_.tenting.border.to), s_.tenting.a0_n, settings_.a1_share);
    }

    // ---- Entering a voxel ----

    bool onRigid() const noexcept {
        return s_.phase == Phase::tenting && s_.tenting.depth_m >= 0.0 && isRigid(row(s_.tenting.border.to));
    }

    // True if the tip presses on bone before and after entering `voxel`: borders behind the bone's surface
    // are then ignored. A withdrawal ends at the surface: rounding may leave the tip just behind it. If
    // another border was tenting when the tip met the bone, withdraw() restores that one. Sideways the tip
    // leaves only where no bone lies between it and the depth of the surface. Otherwise a tip that is pushed
    // through the voxels of a rib would slip into the tissue behind it.
    bool staysOnBone(const Index3& voxel, Direction direction) const noexcept {
        if (!onRigid()) return false;
        if (direction == Direction::withdraw)
            return s_.bone_over_tenting || s_.tenting.depth_m > kSamePlace_m;
        if (direction == Direction::advance) return true;
        const Vec3 tip_m = patient_.grid().centre(voxel);
        VoxelWalk w(patient_.grid(), tip_m, tip_m - s_.tenting.depth_m * into_reference_);
        while (!w.done() && !isRigid(row(patient_.at(w.voxel(), s_.track).tissue)))
            w.next();
        return !w.done();
    }

    bool isCurrentTissue(const TissueSample& x) const noexcept {
        if (s_.phase != Phase::tenting) return x.tissue == s_.tissue && x.label == s_.label;
        return x.tissue == lastBorder().to && x.label == lastBorder().to_label;
    }

    void arrive(const TissueSample& x, const Vec3& at_reference_m, Direction direction) noexcept {
        const bool into_bone =
            direction == Direction::advance && s_.phase == Phase::pass && isRigid(row(x.tissue));
        if (isCurrentTissue(x) && !into_bone) return;
        if (s_.phase == Phase::tenting) return arriveWhileTenting(x, at_reference_m, direction);

        const Border border = borderTo(x, at_reference_m);
        const bool backward = s_.phase == Phase::outside && direction == Direction::withdraw;
        if (backward && border.to == Tissue::skin && s_.fold_count > 0) {
            --s_.fold_count;  // into a skin fold that the shaft passes through
            enter(border, force(), NeedleEventKind::entry);
        } else if (direction == Direction::advance || s_.phase == Phase::outside) {
            reachBorder(border);
        } else if (direction == Direction::sideways) {
            enter(border, force(), NeedleEventKind::sideways);
        } else {
            changeTissue(x.tissue, x.label, force());
        }
    }

    void arriveWhileTenting(const TissueSample& x, const Vec3& at_reference_m, Direction direction) noexcept {
        const bool membrane = row(s_.tenting.border.to).membrane;
        const double f = force();
        if (s_.queued_count > 0 && direction == Direction::withdraw) {
            --s_.queued_count;
            return;
        }
        const bool before_border = s_.depth_m <= s_.tenting.border.depth_m + kSamePlace_m;
        const bool slipped_out =
            direction == Direction::sideways && membrane && x.tissue == s_.tenting.border.from;
        if (s_.queued_count == 0 && direction == Direction::advance && before_border) {
            // The border's tissue had no depth here (a voxel corner). Handle the new tissue as if the tip
            // were still in front of that border.
            abandonTenting();
            return arrive(x, at_reference_m, direction);
        }
        if (s_.queued_count == 0 && (direction == Direction::withdraw || before_border || slipped_out))
            return release(x);

        const Border border = borderTo(x, at_reference_m);
        if (direction == Direction::sideways && !membrane) {
            s_.queued_count = 0;
            s_.bone_over_tenting = false;
            enter(border, f, NeedleEventKind::sideways);
        } else if (direction == Direction::advance && isRigid(row(x.tissue))) {
            s_.under_bone = s_.tenting;
            s_.bone_over_tenting = true;
            startTenting(border, f);
        } else if (membrane || border.from == border.to) {
            if (direction == Direction::sideways) report(NeedleEventKind::sideways, border, f, f);
            queue(border);
        } else {
            // The tip left the tissue on its far side: stop the tenting. The next border starts from the
            // force clamped to friction.
            enter(s_.tenting.border, f, NeedleEventKind::entry);
            handleQueuedBorders();
            reachBorder(border);
        }
    }

    // ---- Borders ----

    Border borderTo(const TissueSample& x, const Vec3& at_reference_m) const noexcept {
        const Tissue from = s_.phase == Phase::tenting ? lastBorder().to : s_.tissue;
        return {at_reference_m, from, x.tissue, x.label, s_.depth_m};
    }

    const Border& lastBorder() const noexcept {
        return s_.queued_count > 0 ? s_.queued[std::size_t(s_.queued_count - 1)] : s_.tenting.border;
    }

    bool isCut(const Border& border) const noexcept {
        const double reach2 = settings_.cut_reach_m * settings_.cut_reach_m;
        for (int i = 0; i < s_.cut_count; ++i) {
            const CutBorder& c = s_.cut[std::size_t(i)];
            const Vec3 d = c.reference_m - border.reference_m;
            if (c.to == border.to && glm::dot(d, d) <= reach2) return true;
        }
        return false;
    }

    bool willTent(const Border& border, double force_n) const noexcept {
        const TissueRow& b = row(border.to);
        if (isRigid(b)) return true;
        return border.from != border.to && resists(b, force_n) && !isCut(border) && !isIncised(border);
    }

    // The body's surface is skin, or another tissue where the voxels at the surface contain no skin.
    bool isIncised(const Border& border) const noexcept {
        const bool surface = border.to == Tissue::skin || s_.phase == Phase::outside;
        return surface && incisions_.count > 0 &&
               isOpen(incisions_, border.reference_m, settings_.cut_reach_m);
    }

    void reachBorder(const Border& border) noexcept {
        const double f = force();
        if (willTent(border, f)) {
            startTenting(border, f);
        } else {
            enter(border, f, NeedleEventKind::entry);
        }
    }

    // Phase 1: the border starts tenting at the current tip.
    void startTenting(const Border& border, double force_n) noexcept {
        s_.phase = Phase::tenting;
        s_.tenting = {border, 0.0, force_n};
        report(NeedleEventKind::border, border, force_n, force_n);
    }

    // From now on the tip is in the tissue behind `border`.
    void enter(const Border& border, double force_n, NeedleEventKind kind) noexcept {
        changeTissue(border.to, border.to_label, force_n);
        // A border whose tenting ended because the needle slipped past it does not count as cut.
        if (kind != NeedleEventKind::entry || !resists(row(border.to), force_n)) storeCut(border);
        report(kind, border, force_n, force());
    }

    void changeTissue(Tissue tissue, std::uint8_t label, double force_n) noexcept {
        const TissueRow& b = row(tissue);
        has_left_ = has_left_ || tissue != s_.tissue;
        s_.phase = Phase::pass;
        s_.tissue = tissue;
        s_.label = label;
        s_.extension_m = b.stiffness_n_per_m > 0.0
                             ? clampToFriction(b, force_n, settings_.friction_scale) / b.stiffness_n_per_m
                             : 0.0;
    }

    // The needle was withdrawn from a tenting border: the tip is in the tissue in front of it, with the force
    // it had there.
    void abandonTenting() noexcept {
        if (s_.tissue == Tissue::air && !s_.bone_over_tenting && s_.depth_m <= kSurface_m)
            return leaveTrack();
        has_left_ = true;
        s_.bone_over_tenting = false;
        s_.phase = Phase::pass;
    }

    void release(const TissueSample& x) noexcept {
        abandonTenting();
        if (s_.phase == Phase::outside) return;
        if (x.tissue == s_.tissue) {
            s_.label = x.label;
        } else {
            changeTissue(x.tissue, x.label, row(s_.tissue).stiffness_n_per_m * s_.extension_m);
        }
    }

    // Phase 2: the puncture, exactly at d*.
    void cut() noexcept {
        enter(s_.tenting.border, row(s_.tenting.border.to).cut_force_n, NeedleEventKind::puncture);
        handleQueuedBorders();
    }

    // Handles, in order, the borders passed while another one was tenting. Each starts from the force that
    // the previous one left.
    void handleQueuedBorders() noexcept {
        const int count = s_.queued_count;
        s_.queued_count = 0;
        for (int i = 0; i < count; ++i) {
            const Border border = s_.queued[std::size_t(i)];
            bool left_behind = false;
            for (int j = i + 1; j < count; ++j) {
                const Border& later = s_.queued[std::size_t(j)];
                left_behind = left_behind || later.from != later.to;
            }
            const double f = force();
            if (willTent(border, f) && (row(border.to).membrane || !left_behind)) {
                startTenting(border, f);
                for (int j = i + 1; j < count; ++j)
                    queue(s_.queued[std::size_t(j)]);
                return;
            }
            enter(border, f, NeedleEventKind::entry);
        }
    }

    void queue(const Border& border) noexcept {
        if (s_.queued_count == kMaxQueuedBorders) report(NeedleEventKind::overflow, s_.queued[0], 0.0, 0.0);
        pushBack(s_.queued, s_.queued_count, border);
    }

    void storeCut(const Border& border) noexcept {
        if (border.from == border.to || border.to == Tissue::air || isCut(border)) return;
        if (s_.cut_count == kMaxCutBorders) report(NeedleEventKind::overflow, border, 0.0, 0.0);
        pushBack(s_.cut, s_.cut_count, {border.reference_m, border.to});
        s_.cuts.add(border.reference_m, std::uint64_t(border.to));
    }

    // ---- Motion ----

    void advance(double travel_m) noexcept {
        while (s_.phase == Phase::tenting) {
            TentingBorder& h = s_.tenting;
            if (h.depth_m < 0.0) {  // still in front of the border
                if (travel_m < -h.depth_m) {
                    h.depth_m += travel_m;
                    return pass(travel_m);
                }
                travel_m += h.depth_m;
                pass(-h.depth_m);
                h.depth_m = 0.0;
                h.a0_n = row(s_.tissue).stiffness_n_per_m * s_.extension_m;
            }
            const double to_cut_m = std::max(0.0, curve().cut_depth_m - h.depth_m);
            if (travel_m < to_cut_m) {
                h.depth_m += travel_m;
                s_.depth_m += travel_m;
                return;
            }
            h.depth_m += to_cut_m;
            s_.depth_m += to_cut_m;
            travel_m -= to_cut_m;
            cut();
        }
        pass(travel_m);
    }

    void withdraw(double travel_m) noexcept {
        while (s_.phase == Phase::tenting) {
            TentingBorder& h = s_.tenting;
            if (h.depth_m + travel_m >= 0.0) {
                h.depth_m += travel_m;
                s_.depth_m += travel_m;
                return;
            }
            if (h.depth_m > 0.0) {
                travel_m += h.depth_m;
                s_.depth_m -= h.depth_m;
                h.depth_m = 0.0;
            }
            if (!s_.bone_over_tenting) {
                h.depth_m += travel_m;
                break;
            }
            s_.bone_over_tenting = false;
            h = s_.under_bone;
        }
        pass(travel_m);
    }

    // Phase 3, Eqs. 6-8.
    void pass(double travel_m) noexcept {
        const TissueRow& t = row(s_.tissue);
        s_.depth_m += travel_m;
        if (t.stiffness_n_per_m <= 0.0) return;
        const double l_max = frictionLimit(t, settings_.friction_scale) / t.stiffness_n_per_m;
        s_.extension_m = std::clamp(s_.extension_m + travel_m, -l_max, l_max);
    }

    // ---- The track ----

    void setFlags(const TissueSample& x) noexcept {
        const patient::TrackFlags after = patient_.flagsAfterEntering(x, s_.track);
        if (after.past_skin && !s_.track.past_skin) s_.past_skin_depth_m = s_.depth_m;
        if (after.past_fascia && !s_.track.past_fascia) s_.past_fascia_depth_m = s_.depth_m;
        s_.track = after;
    }

    // Clears each flag that was set deeper than the tip. With a positive tolerance, also one that was set at
    // the tip's depth.
    void clearFlags(double tolerance_m) noexcept {
        if (s_.depth_m < s_.past_skin_depth_m + tolerance_m) s_.track.past_skin = false;
        if (s_.depth_m < s_.past_fascia_depth_m + tolerance_m) s_.track.past_fascia = false;
    }

    // The needle has passed through a fold or a corner of skin and is in the air behind it.
    void leaveFold(const TissueSample& air, const Vec3& at_reference_m) noexcept {
        report(NeedleEventKind::withdrawn, borderTo(air, at_reference_m), force(), 0.0);
        ++s_.fold_count;
        leaveTrack();
    }

    void leaveTrack() noexcept {
        has_left_ = true;
        endTrack(s_);
    }

    void report(NeedleEventKind kind, const Border& border, double before_n, double after_n) noexcept {
        const patient::Label* label = patient_.label(border.to_label);
        Role role = label ? label->role : row(border.to).role;
        if (!label && border.to == Tissue::air && s_.track.past_skin) role = Role::risk;
        events_.add({kind, role, border, s_.depth_m - border.depth_m, before_n, after_n});
    }

    NeedleState& s_;
    const NeedleSettings& settings_;
    const patient::Patient& patient_;
    NeedleEvents& events_;
    const Incisions& incisions_;
    Vec3 into_reference_;
    bool has_left_ = false;
};

}  // namespace stylet::haptics
