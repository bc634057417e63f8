// The evidence of each step: what must have happened before a step counts as done, and why a step that was
// tried does not count. Derived from the ticks, one after another.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "app/training/infiltration.h"
#include "app/training/metric_table.h"

namespace stylet::training {

// Share of the needle's length in the body that lies in the ultrasound beam of a probe on the skin, 0 to 1.
double shareInBeam(const haptics::TickOutput&) noexcept;

// Share of the probe's face that must touch the skin for a picture that counts.
inline constexpr double kMinContact = 0.3;

// The skin over the rib that a finger can reach beside the path's entry, toward the head (+1) or the feet
// (-1): over the middle of the rib, reference patient. Nothing if there is no such rib.
std::optional<Vec3> skinOverRib(const patient::Patient&, const patient::PlannedPath&, double toward_head);

// Why the duct cannot be seen.
enum class View : std::uint8_t { shown, noContact, besidePlane, outsideSector, shadowed };

// What a step needs. The guide's metrics.md has the same list for users.
//   findGap   a finger presses on the path's intercostal space and on the rib at each side of it, where there
//             is one
//   findDuct  the target stays for a second in the picture of a probe that touches the skin
//   anaesthetise  local anaesthetic in the skin at the entry and at the liver's capsule, on the later track
//   incise    a cut of 3 to 15 mm through the skin, within 5 mm of the entry: the reference path's, or the
//             place where the parked probe's guide meets the skin
//   guide     the needle enters the body on the rail of the parked probe
//   advance   the tip is in the target duct in a breath-hold, the duct is in the picture, and the beam held
//             the needle for at least half of this insertion
//   aspirate  bile is drawn through the needle
//   contrast  medium in the ducts is seen under X-rays
//   wire      the guide wire lies 20 mm down a duct whose wall it has not pierced
//   dilate    the dilator has reached the duct over a wire that lies in it
//   drain     the wire is drawn back behind the drain's loop, which curls with its side holes in the ducts. A
//             wire that is passed through the drain again straightens the loop: the drain is then in its
//             place no longer
//   finalPicture  medium that was injected through the drain is seen in the ducts under X-rays
class Evidence {
  public:
    // `patient` must outlive this object.
    Evidence(const patient::Patient& patient, const patient::PlannedPath&, double dt_s);
    // Probe and guide of the attempt; without this call, the default ones.
    void setTools(const haptics::ToolSettings& tools) noexcept { tools_ = tools; }
    void setCourse(Course course) noexcept { course_ = course; }

    // Session thread. Processes the next tick. Returns the steps for which it has found the evidence, a bit
    // mask of 1 << Step. Of these, drain and finalPicture are lost again when the drain is straightened.
    std::uint32_t update(const haptics::TickOutput&, const TickFacts&, const AttemptFold&);
    // Why the step that the trainee just tried does not count; `none` if nothing was tried since the last
    // call.
    Refusal popRefusal() noexcept { return std::exchange(refusal_, Refusal::none); }
    // True if the skin at the entry is open too wide, which no further cut can mend.
    bool isIncisionSpoiled() const noexcept { return spoiled_incision_; }
    // Bile was drawn or medium was seen in the ducts in the newest insertion of the needle.
    bool provesDuct() const noexcept { return proven_; }
    // What the step still lacks at the newest tick. `none` if this is not known in more detail.
    Refusal missing(Step) const noexcept;
    // Of the needle's tip in the body wall. `outside` in a puncture.
    TrackPlace trackPlace() const noexcept { return infiltration_.place(); }
    std::pair<double, double> depotAtTip_m3() const noexcept { return infiltration_.depotAtTip_m3(); }

  private:
    enum class Beneath : std::uint8_t { nothing, gap, headwardRib, footwardRib };

    void palpate(const haptics::TickOutput&);
    Beneath findBeneath(const Vec3& reference_m) const noexcept;
    void look(const haptics::TickOutput&, const Vec3& target_m, const UltrasoundState&);
    View findView(const haptics::TickOutput&, const Vec3& target_m, const UltrasoundState&) const noexcept;
    void aim(const haptics::TickOutput&, const Vec3& target_m) noexcept;
    void judgeIncision(const haptics::TickOutput&);
    bool isAtEntry(const haptics::Incision&, const haptics::TickOutput&) const noexcept;
    void followInsertion(const haptics::TickOutput&, const TickFacts&);
    void judgePuncture(const haptics::TickOutput&, const TickFacts&, const UltrasoundState&);
    void judgeAnaesthesia(const haptics::TickOutput&, const AttemptFold&);
    void judgeAspiration(const AttemptFold&, bool infiltrates);
    void judgeContrast(const haptics::TickOutput&, const AttemptFold&);
    void judgeDrainage(const haptics::TickOutput&, double torn_m);
    void judgeDrain(const haptics::AccessOutput&, double torn_m);
    Refusal judgeHoles(const haptics::AccessOutput&) const noexcept;
    bool has(Step step) const noexcept { return (found_ & 1u << unsigned(step)) != 0; }
    void find(Step step) noexcept { found_ |= 1u << unsigned(step); }
    void lose(Step step) noexcept { found_ &= ~(1u << unsigned(step)); }

    const patient::Patient* patient_;
    patient::PlannedPath path_;
    haptics::ToolSettings tools_{};
    Course course_ = kDefaultCourse;
    double dt_s_;
    Infiltration infiltration_;
    Vec3 axis_reference_;
    bool needs_headward_ = false, needs_footward_ = false;

    std::uint32_t found_ = 0;
    Refusal refusal_ = Refusal::none;
    haptics::TickOutput previous_;
    std::uint64_t tick_count_ = 0, check_interval_ticks_ = 1;
    double gap_s_ = 0.0, headward_s_ = 0.0, footward_s_ = 0.0;  // pressed on each
    View view_ = View::noContact;
    double shown_s_ = 0.0;
    bool aimed_ = false;  // the guide's line met the duct in the newest breath-hold
    bool spoiled_incision_ = false;
    bool on_rail_ = false, beside_rail_ = false, refused_contrast_ = false;
    Refusal refused_puncture_ = Refusal::none;  // of this insertion
    Vec3 anchor_m_{0.0};
    double travel_m_ = 0.0, seen_m_ = 0.0;  // of the tip in this insertion; in the beam
    std::uint64_t pulses_ = 0, draws_ = 0;
    bool proven_ = false, refused_wire_ = false;  // of this insertion
    bool drain_proven_ = false;                   // as the wire was last drawn out
    Refusal holes_ = Refusal::none;               // why the straight drain in the hand would leak
    // Of the track, when the drain was last outside; infinite once a tear of this insertion was refused.
    double torn_m_ = 0.0;
    // Medium in the ducts as the needle was inserted; as the drain curled.
    double ducts_at_entry_m3_ = 0.0, ducts_at_curl_m3_ = 0.0;
};

}  // namespace stylet::training
