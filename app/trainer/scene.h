// From what the trainer knows to what the renderer shows.
#pragma once

#include <vector>

#include "app/trainer/contacts.h"
#include "app/trainer/machine_moment.h"
#include "app/trainer/monitor.h"
#include "app/trainer/seen.h"
#include "app/trainer/wounds.h"
#include "app/training/difficulty.h"
#include "render/render.h"

namespace stylet::trainer {

// The room around the table, the access field and, with the closed skin, the drape.
// The C-arm comes over the target with its first pulse.
void furnish(render::RenderScene&, const patient::PlannedPath&, const training::XrayState& = {});

// What a tick's hand holds and where the probe was left.
void showTools(render::RenderScene&, const haptics::TickOutput&);

void showMonitor(render::RenderScene&, const BreathMonitor&);

// The wounds, and with the closed skin the disinfected field around the planned entry.
std::vector<render::Mark> marksOf(const std::vector<Wound>&, render::Look, const patient::PlannedPath&);

// The room and its patient as ticks find them, for one who draws. One thread.
class SceneMaker {
  public:
    // The patient and the map must outlive it.
    // `hints`: the reference path, and what the room's light says.
    SceneMaker(const patient::Patient&, const patient::PlannedPath&, render::Look, const haptics::TouchMap*,
               double tick_s, const training::Hints& hints);
    // Another difficulty, from now on.
    void help(const training::Hints& hints) { hints_ = hints; }
    // With the breath monitor's screen, not the machines'. Valid until the next call.
    render::RenderScene sceneOf(const Seen&);
    const patient::Pose& stageFromPatient() const { return stage_from_patient_; }

  private:
    const patient::Patient* patient_;
    patient::PlannedPath path_;
    patient::Pose stage_from_patient_;
    render::Look look_;
    double tick_s_;
    training::Hints hints_;
    ToolPress press_;
    BreathMonitor monitor_;
};

// What the machines can see of what a scene shows. `contrast` as in MachineMoment.
MachineMoment momentOf(const Seen&, const render::RenderScene&, const render::Renderer&,
                       const patient::ContrastTable* contrast, const haptics::GuideSettings&, double tick_s);

}  // namespace stylet::trainer
