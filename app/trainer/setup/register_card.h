// Picture of the registration wizard, shown in front of the user's eyes: instructions, progress, and a sketch
// of the workspace with its points.
#pragma once

#include <cstdint>
#include <vector>

#include "app/report/canvas.h"
#include "xr/registration/registration.h"

namespace stylet::trainer {

class RegisterCard {
  public:
    static constexpr int kWidth = 1100, kHeight = 560;
    static constexpr double kLetter_px = 34.0;  // em size of its smallest text

    RegisterCard();
    // Redraws only if something changed.
    void show(const xr::registration::WizardText&, const xr::registration::WizardSketch&);
    const std::vector<std::uint8_t>& rgba() const { return rgba_; }
    std::uint64_t revision() const { return revision_; }
    const report::Canvas& canvas() const { return canvas_; }

  private:
    void write(const xr::registration::WizardText&);
    void drawSpace(const xr::registration::WizardSketch&);

    report::Canvas canvas_;
    std::string shown_;  // content drawn last, for comparison
    std::vector<std::uint8_t> rgba_;
    std::uint64_t revision_ = 0;
};

}  // namespace stylet::trainer
