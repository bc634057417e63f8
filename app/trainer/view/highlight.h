// Where the tutor's current prompt points: marks in the patient and in the room.
#pragma once

#include <optional>
#include <vector>

#include "app/trainer/session/frame_state.h"
#include "app/training/tutor.h"
#include "haptics/tools/guide.h"
#include "patient/planning/planning.h"
#include "render/scene/scene.h"

namespace stylet::trainer {

// Places that an attempt's prompts speak of.
class PromptPlaces {
  public:
    // The patient must outlive this object.
    PromptPlaces(const patient::Patient&, const patient::PlannedPath&, const haptics::GuideSettings&);
    // Marks the place of an act at a tick. Empty for an act without a place.
    std::vector<render::Highlight> highlights(training::Act, const FrameState&) const;

  private:
    class AtTick;

    const patient::Patient* patient_;
    patient::PlannedPath path_;
    haptics::GuideSettings guide_;
    std::optional<Vec3> upper_rib_m_, lower_rib_m_;  // on the skin, reference patient
};

}  // namespace stylet::trainer
