// Dynamic resolution: how many pixels the volume layer may have for the frame to keep to the runtime's
// budget.
#pragma once

namespace stylet::render {

struct GovernorSettings {
    double budget_ms = 11.1;  // of a frame, as the runtime paces it
    double aimed = 0.85;      // share of it: the rest is room for what changes from frame to frame
    float least = 0.35f;      // of the target's resolution: what lies below is not worth looking at
    float step = 0.0625f;     // scales are multiples of it: a picture that changes every frame shimmers
    int patience = 30;        // frames that must have had room before the resolution rises
};

// One frame after the other; the clock is the caller's.
class Governor {
  public:
    explicit Governor(const GovernorSettings& = {});

    float layerScale() const { return scale_; }  // for the next frame
    // What the last frame took, `volume_ms` of it in proportion to the pixels of the layer, drawn at
    // `drawn_scale` of the target: less than asked for where the head is close. Passed over: times that are
    // not positive numbers, and frames that no resolution could have saved.
    void took(double volume_ms, double rest_ms, double drawn_scale);

  private:
    GovernorSettings settings_;
    float scale_ = 1.0f;
    int calm_ = 0;  // frames in a row that had room for the next step
    int over_ = 0;  // frames in a row over the budget
};

}  // namespace stylet::render
