// CT slices at the tool tip: axial, coronal and sagittal, deformed by the breath.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "app/report/canvas.h"
#include "app/report/slices.h"
#include "app/trainer/session/frame_state.h"
#include "app/trainer/window/layout.h"

namespace stylet::trainer {

// Use from one thread only.
class SliceView {
  public:
    // The patient must outlive this object.
    explicit SliceView(const patient::Patient& patient) : patient_(&patient) {}

    // Fills a canvas of that size.
    void draw(report::Canvas&, int width, int height, const FrameState&);

    // Directions and scale of the slice at a pixel of the last drawing, in the patient frame.
    struct Spot {
        Vec3 right{0.0}, down{0.0};
        double m_per_pixel = 0.0;
    };
    std::optional<Spot> at(double x, double y) const;

  private:
    struct Cell {
        Rect rect;
        report::SlicePlane plane;
        double m_per_pixel = 0.0;
        report::Point pixelOf(const Vec3& p_m) const;
    };
    void place(int width, int height, const Vec3& tip_m);
    void drawTool(report::Canvas&, const Cell&, const Pose& patient_from_tool, double length_m) const;

    const patient::Patient* patient_;
    std::optional<Vec3> middle_m_;  // centre of the slices; moves only when the tip gets too far away from it
    std::array<Cell, 3> cells_{};
};

}  // namespace stylet::trainer
