// How the scripted expert does each step of the procedure, on the trainee's patient and path. Shown beside
// the trainee's own tool on request.
#pragma once

#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/attempt/commands.h"
#include "app/trainer/session/frame_state.h"
#include "app/trainer/stores/console.h"
#include "app/training/difficulty.h"

namespace stylet::trainer {

class Demonstration {
  public:
    // Computes the expert's whole attempt: assets/scenarios/procedure.toml or drainage.toml.
    Demonstration(const patient::Patient&, const patient::PlannedPath&, training::Course, const MakeTouch&);
    // The expert's tool at a time after the beginning of a step, with a short rest after the step's end; then
    // it begins again. It follows the breath of the patient that is shown. Nothing if no part of the step is
    // shown; describeMissing() says why.
    std::optional<GhostTool> at(training::Step, double t_s, const patient::Surrogate& breath) const;
    // One sentence, without a period: why a step is not shown. Empty if it is.
    std::string describeMissing(training::Step) const;
    // Length of a step, without the rest.
    double length_s(training::Step) const;

    static constexpr double kSample_s = 0.02, kRest_s = 0.6;

  private:
    struct Sample {
        haptics::Tool tool = haptics::Tool::needle;
        Pose patient_from_tool;
        Vec3 tip_reference_m{0.0};
        std::size_t access = 0;  // index in `accesses_`; of wire, dilator and drain
    };
    const patient::MotionModel* motion_;
    std::array<std::vector<Sample>, training::kStepCount> samples_{};
    std::vector<haptics::AccessOutput> accesses_;
    std::uint32_t steps_done_ = 0;  // bit mask of 1 << Step
};

// Adds the demonstration of the current step to the frames while the trainee wants it. Session thread.
class ExpertBeside {
  public:
    // `make` runs once, on a thread of its own, when the demonstration is first wanted.
    explicit ExpertBeside(std::function<Demonstration()> make, Say say = printMessage)
        : make_(std::move(make)), say_(std::move(say)) {}
    // Starts or ends the demonstration. Returns what the user should know.
    std::string toggle(const training::DifficultyRules&);
    // Call with every state. Ends the demonstration if the difficulty does not allow it. If a step is not
    // shown, tells the user why: once on the terminal, and for kNoteShown_s in the frames.
    void addTo(FrameState&, const training::DifficultyRules&, double tick_s);

    static constexpr double kNoteShown_s = 8.0;

  private:
    std::function<Demonstration()> make_;
    Say say_;
    std::future<Demonstration> future_;
    std::optional<Demonstration> made_;
    bool shown_ = false;
    std::optional<training::Step> step_;  // nothing before the first state that shows it
    std::string missing_;                 // of this step
    std::uint64_t since_tick_ = 0;
};

}  // namespace stylet::trainer
