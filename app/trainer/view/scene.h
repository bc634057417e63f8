// Builds the renderer's scene from the state of an attempt.
#pragma once

#include <vector>

#include "app/trainer/attempt/config.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/frame_state.h"
#include "app/trainer/session/imaging_input.h"
#include "app/trainer/session/wounds.h"
#include "app/trainer/view/contacts.h"
#include "app/trainer/view/highlight.h"
#include "app/trainer/view/monitor.h"
#include "app/training/difficulty.h"
#include "render/render.h"

namespace stylet::trainer {

inline render::Look sceneLook(const AttemptConfig& config) {
    return config.closed_look ? render::Look::closed : render::Look::reveal;
}

// If the configuration names a look file, loads it in place of the configured look. Throws DataError.
void loadSceneLook(render::Renderer&, const AttemptConfig&);

// Adds to the scene the room and the disinfected field around the field's entry. The closed look also gets
// the drape, unless the scene has cut planes. From the first X-ray pulse on, also adds the C-arm, over the
// needle that was in the body when the pedal was pressed.
void addRoom(render::RenderScene&, const OperativeField&, const training::XrayState& = {});

// Adds the tool in use and the parked probe.
void showTools(render::RenderScene&, const FrameState&);

// Adds the expert's tool, `seen.ghost_tool`.
void showGhost(render::RenderScene&, const FrameState& seen, const patient::MotionModel&);

void showMonitor(render::RenderScene&, const BreathMonitor&);

// Marks of the wounds. With closed skin, also the mark of the disinfected field.
std::vector<render::Mark> makeMarks(const std::vector<Wound>&, render::Look, const Vec3& field_reference_m);

// Builds the scene of room and patient for a tick. Use from one thread only.
class SceneMaker {
  public:
    // The patient and the touch map must outlive this object. `rules` selects whether the reference path and
    // the place of the tutor's prompt are shown, and whether the room light shows alerts. They may change;
    // the field stays where it is.
    SceneMaker(const patient::Patient&, const patient::PlannedPath&, const OperativeField&, render::Look,
               const PressInput&, const training::DifficultyRules& rules);
    // Changes the rules to those of another difficulty.
    void help(const training::DifficultyRules& rules) { rules_ = rules; }
    // Returns the scene for a state of the attempt. It includes the screen of the breath monitor, but not the
    // screens of ultrasound and X-ray. The scene refers to data of this object and is valid until the next
    // call.
    render::RenderScene makeScene(const FrameState&);
    const Pose& stageFromPatient() const { return stage_from_patient_; }

  private:
    const patient::Patient* patient_;
    patient::PlannedPath path_;
    OperativeField field_;
    Pose stage_from_patient_;
    render::Look look_;
    double tick_s_;
    training::DifficultyRules rules_;
    PromptPlaces places_;
    ToolPress press_;
    BreathMonitor monitor_;
};

// Input of the equipment pictures for a scene. `contrast`: see ImagingInput.
ImagingInput makeImagingInput(const FrameState&, const render::RenderScene&, const render::Renderer&,
                              const patient::ContrastTable* contrast, const haptics::GuideSettings&,
                              double tick_s);

}  // namespace stylet::trainer
