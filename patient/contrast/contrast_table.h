// Computes a table of added attenuation from the contrast medium and updates it incrementally.
#pragma once

#include <cstdint>
#include <vector>

#include "patient/contrast/contrast.h"

namespace stylet::patient {

struct ContrastTableSettings {
    // total change since the last picture below which nothing is updated; 0: every change counts
    double visible_m3 = 2e-8;
};

class ContrastPainter {
  public:
    explicit ContrastPainter(const ContrastTableSettings& settings = {}) : settings_(settings) {}

    // Any thread, but only one at a time. Writes the changes since the last call to `changes`. Returns false
    // and leaves `changes` alone if nothing visible has changed. Takes a few milliseconds when the box
    // changes, otherwise less than one.
    bool paint(const Contrast&, ContrastChanges& changes);
    // The next paint() will write the complete table. Call it if earlier changes may have been lost.
    void reset();
    std::uint64_t skipped() const noexcept { return skipped_; }  // calls without a visible change

  private:
    // The voxels around a stain's centre, out to the stain's extent.
    struct Ball {
        double reach_m = 0.0;
        std::vector<std::uint32_t> offsets;  // in the patient's grid
        std::vector<double> path_m;
        FillOrder order;
        Index3 low{0}, high{0};
    };
    // Attenuation of one voxel of the patient's grid. Lists are sorted by offset.
    struct VoxelAttenuation {
        std::uint32_t offset = 0;
        float added_per_m = 0.0f;
    };
    bool hasVisibleChange(const Contrast&);
    void growBalls(const Contrast&);
    bool fitBox(const Contrast&);
    void collectAttenuation(const Contrast&);
    void collectDucts(const Contrast&);
    void collectStains(const Contrast&);
    void collectPlumes(const Contrast&);
    void mergeRegion();
    void writeChanges(const Grid&, ContrastChanges&) const;

    ContrastTableSettings settings_;
    std::vector<double> shown_state_;  // all volumes as of the last picture
    std::vector<Ball> balls_;          // one per stain
    Index3 low_{0}, high_{-1};         // the box in the patient's grid
    Grid box_;
    std::vector<VoxelAttenuation> current_, shown_, merged_;  // in progress, last returned, scratch
    std::size_t region_ = 0;                                  // start of the newest list in current_
    std::uint64_t revision_ = 0, skipped_ = 0;
};

}  // namespace stylet::patient
