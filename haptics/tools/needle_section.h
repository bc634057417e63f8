// The needle inside one voxel: handles the border in front of it, then moves it by this voxel's share of the
// travel (model, section 3). Private to needle.cpp, which does motion and tissue look-up. The four phases
// are here.
#pragma once

#include "haptics/tools/needle.h"
#include "haptics/tools/tenting.h"

namespace stylet::haptics {

enum class Direction { advance, withdraw, sideways };

class SectionSolver {
  public:
    SectionSolver(NeedleState& state, const NeedleSettings& settings, const patient::Patient& patient,
                  NeedleEvents& events, const Incisions& incisions) noexcept
        : s_(state), settings_(settings), patient_(patient), events_(events), incisions_(incisions) {}

    // Haptics thread. Enters the voxel `sample` at `at_reference_m` and moves `travel_m` along the axis
    // inside it.
    void run(const patient::TissueSample& sample, const Vec3& at_reference_m, double travel_m,
             Direction) noexcept;
    // Haptics thread. Returns the axial force of the current state.
    double force() const noexcept;
    // True if the tip left a tissue or a tenting border in this step, even if only at a voxel corner before
    // re-entering the same tissue. The force may have stepped.
    bool hasLeft() const noexcept { return has_left_; }

  private:
    // Entering a voxel.
    bool onRigid() const noexcept;
    bool isFront(const patient::TissueSample&) const noexcept;
    void arrive(const patient::TissueSample&, const Vec3& at_reference_m, Direction) noexcept;
    void arriveHeld(const patient::TissueSample&, const Vec3& at_reference_m, Direction) noexcept;

    // Borders.
    Border borderTo(const patient::TissueSample&, const Vec3& at_reference_m) const noexcept;
    bool holds(const Border&, double force_n) const noexcept;
    bool isCut(const Border&) const noexcept;
    bool isIncised(const Border&) const noexcept;
    void meet(const Border&) noexcept;
    void startTenting(const Border&, double force_n) noexcept;
    void enter(const Border&, double force_n, NeedleEventKind) noexcept;
    void changeTissue(Tissue, std::uint8_t label, double force_n) noexcept;
    void stepBack() noexcept;
    void release(const patient::TissueSample&) noexcept;
    void cut() noexcept;
    void fold() noexcept;
    void queue(const Border&) noexcept;
    void remember(const Border&) noexcept;

    // Motion.
    void advance(double travel_m) noexcept;
    void withdraw(double travel_m) noexcept;
    void pass(double travel_m) noexcept;

    // Track.
    void setFlags(const patient::TissueSample&) noexcept;
    void undoFlags() noexcept;
    void endTrack() noexcept;

    const patient::TissueRow& row(Tissue t) const noexcept { return patient_.row(t); }
    TentingCurve curve() const noexcept;
    void report(NeedleEventKind, const Border&, double before_n, double after_n) noexcept;

    NeedleState& s_;
    const NeedleSettings& settings_;
    const patient::Patient& patient_;
    NeedleEvents& events_;
    const Incisions& incisions_;
    bool has_left_ = false;
};

}  // namespace stylet::haptics
