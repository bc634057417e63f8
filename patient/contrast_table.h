// The picture of the contrast medium: a table of added attenuation, kept up to date by what has changed.
#pragma once

#include <cstdint>
#include <vector>

#include "patient/contrast.h"

namespace stylet::patient {

struct ContrastTableSettings {
    double visible_m3 = 2e-8;  // less that moved since the last time changes no picture; 0: every drop does
};

class ContrastPainter {
  public:
    explicit ContrastPainter(const ContrastTableSettings& settings = {}) : settings_(settings) {}

    // Any one thread. What has changed since the last call; false, and `changes` as they were, where nothing
    // visible has. Some milliseconds where the box is a new one, else a fraction of one.
    bool paint(const Contrast&, ContrastChanges& changes);
    // The next picture is handed out whole: what was handed out before may be lost.
    void startAnew();
    std::uint64_t skipped() const noexcept { return skipped_; }  // calls without a visible change

  private:
    // The voxels around a stain's centre, as far as it reaches.
    struct Ball {
        double reach_m = 0.0;
        std::vector<std::uint32_t> offsets;  // in the patient's grid
        std::vector<double> way_m;
        FillOrder order;
        Index3 low{0}, high{0};
    };
    // Attenuation by voxel of the patient's grid, ascending.
    struct Lit {
        std::uint32_t offset = 0;
        float added_per_m = 0.0f;
    };
    bool visiblyMoved(const Contrast&);
    void reachOut(const Contrast&);
    bool fitBox(const Contrast&);
    void light(const Contrast&);
    void lightDucts(const Contrast&);
    void lightStains(const Contrast&);
    void lightPlumes(const Contrast&);
    void endRegion();
    void handOut(const Grid&, ContrastChanges&) const;

    ContrastTableSettings settings_;
    std::vector<double> shown_state_;  // volumes of everything, as of the last picture
    std::vector<Ball> balls_;          // one a stain
    Index3 low_{0}, high_{-1};         // of the box, in the patient's grid
    Grid box_;
    std::vector<Lit> now_, shown_, merged_;  // being made, last handed out, scratch
    std::size_t region_ = 0;                 // where in now_ the newest list begins
    std::uint64_t revision_ = 0, skipped_ = 0;
};

}  // namespace stylet::patient
