// Dynamic resolution: chooses the volume layer's resolution so that frames stay within the runtime's frame
// budget.
#pragma once

namespace stylet::render {

struct GovernorSettings {
    double budget_ms = 11.1;  // frame budget at the runtime's frame rate
    double target_share =
        0.85;                 // target share of the budget; the rest is headroom for changes between frames
    float min_scale = 0.35f;  // lowest share of the target's resolution; below it the picture is useless
    float step = 0.0625f;     // scales are multiples of this: a resolution that changes every frame shimmers
    int patience = 30;        // frames in a row with headroom after which the resolution rises
};

// Called once per frame, with times that the caller measured.
class Governor {
  public:
    explicit Governor(const GovernorSettings& = {});

    float layerScale() const { return scale_; }  // for the next frame
    // Reports the last frame. `volume_ms` is the part of its time that grows with the layer's pixels.
    // `drawn_scale` is the scale at which the layer was drawn; it is below layerScale() when the head is
    // close. Ignores invalid times, and frames whose `other_ms` alone exceeds the target.
    void reportFrame(double volume_ms, double other_ms, double drawn_scale);

  private:
    GovernorSettings settings_;
    float scale_ = 1.0f;
    int frames_with_headroom_ = 0;  // frames in a row with headroom for the next step
    int frames_over_budget_ = 0;    // frames in a row over the budget
};

}  // namespace stylet::render
