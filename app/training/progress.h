// How far an attempt has come, for whoever shows or tells it: panel, sound, console, report. Derived from the
// ticks (procedure.h), never hashed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

namespace stylet::training {

// Of the procedure, in order.
//   findGap   the finger has pressed on the space between the ribs through which the reference path runs
//   findDuct  the target duct has stood in the ultrasound picture, with no rib or gas before it
//   incise    the skin is open at the path's entry
//   guide     the needle has snapped into the guide
//   advance   the target duct is cut
//   contrast  medium in the ducts has been seen under X-rays
enum class Step : std::uint8_t { findGap, findDuct, incise, guide, advance, contrast, done };
inline constexpr int kStepCount = int(Step::done);
std::string_view stepName(Step) noexcept;  // "find the space between the ribs"

// What the needle is in that it should not be.
enum class Struck : std::uint8_t { nothing, bone, vessel, lung, otherOrgan };
inline constexpr int kStruckCount = 5;
std::string_view struckName(Struck) noexcept;

// Trivially copyable: it travels in snapshots. As of one tick, patient frame.
struct Progress {
    Step step = Step::findGap;       // the first that is not done
    std::uint32_t steps_done = 0;    // bit 1 << Step
    std::uint32_t out_of_order = 0;  // steps done before one that comes earlier
    double elapsed_s = 0.0;          // since the first tick
    // Of the needle, or of the tool in hand where that is no needle: its tip beside the reference path as the
    // breath carries it, its shaft against it, its tip to the target.
    double off_path_m = 0.0, off_angle_rad = 0.0, to_target_m = 0.0;
    // The needle's tip to the border of the nearest risk structure; infinite outside the body, and further
    // from the path than is looked (surroundings.h).
    double clearance_m = std::numeric_limits<double>::infinity();
    Struck striking = Struck::nothing;  // now
    Struck last_struck = Struck::nothing;
    std::uint32_t risk_hits = 0, near_misses = 0;  // so far
    bool success = false;                          // the target duct is cut
    double total = 0.0;                            // of the score so far, 0 to 100 (score.h)
};
static_assert(std::is_trivially_copyable_v<Progress>);

// Every kind of event that there is; the guide's records.md says what each tells (a test compares them). The
// last seven are not the procedure's: what an instructor did, then a rest suggested, and from where a retry
// began.
inline constexpr std::array<std::string_view, 15> kEventKinds{
    "tool",     "step",  "contact",  "risk",    "near_miss",  "cut",  "breath", "fault",
    "injected", "pause", "bookmark", "comment", "difficulty", "rest", "retry"};
constexpr bool isEventKind(std::string_view kind) {
    return std::find(kEventKinds.begin(), kEventKinds.end(), kind) != kEventKinds.end();
}

// Something that happened, for log, record and report.
struct SessionEvent {
    std::uint64_t tick = 0;
    std::string kind;  // one of kEventKinds
    std::string text;
};

}  // namespace stylet::training
