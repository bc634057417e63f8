// Fluoroscopy: what the C-arm's screen shows of the patient as he is now, and what the pulse cost him.
//
// Beer-Lambert through the breathing, pressed patient (rays.comp), instruments and contrast added; the
// exposure that the brightness control gives; quantum and electronic noise; the screen's curve (screen.comp).
// Conventions of the screen, as angiography systems show it: dense is dark; the picture is seen from the
// detector, the patient's head above, his left on the right at both angles 0.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "render/fluoroscopy/beam.h"
#include "render/fluoroscopy/exposure.h"
#include "render/fluoroscopy/shapes.h"
#include "render/gpu.h"
#include "render/scene.h"
#include "render/volume/deformed_patient.h"

namespace stylet::patient {
struct ContrastTable;  // patient/contrast.h
}

namespace stylet::render {

// What happens now. The patient's breath and what presses on him: DeformedPatient.
struct FluoroscopyInput {
    CArm arm;                     // its angles
    Pose patient_from_isocentre;  // table height and travel; its axes at 0 are a straight patient's
    Collimation collimation;
    bool pedal = false;   // up: no radiation, the last picture stays
    double time_s = 0.0;  // pulses are counted from 0
    std::span<const XrayShape> shapes = {};
    const patient::ContrastTable* contrast = nullptr;  // null: none
};

// Each can be switched off: the same picture of the same patient, for more work. (That a still patient is not
// deformed is the word of whoever breathes DeformedPatient.)
struct FluoroscopySkips {
    bool between_pulses = true;   // the picture of a pulse is made once
    bool collimated_rays = true;  // no ray behind the blades
    bool empty_cells = true;      // no samples in air
    bool idle_tool = true;        // none of a tool while nothing presses
    bool kept_contrast = true;    // what the rays sample is written anew only when the contrast has changed
};

struct FluoroscopySettings {
    int pixels = 256;  // a side of the detector, 1 to 2048
    double detector_m = 0.300;
    double pulse_rate_hz = 7.5;
    DoseSettings dose;
    double electronic_quanta = 4.0;  // rms, a pixel
    double curve = 2.2;              // slope of the screen's S over the logarithm of the quanta
    double evened = 0.65;            // share of the slow part of that logarithm that the screen takes out
    bool dense_is_dark = true;
    std::uint32_t seed = 1;
    // The CT ends somewhere, the patient does not: beyond its first and last slice he goes on as they are.
    double beyond_ends_m = 0.15;
    // Knobs (stylet-bench --only imaging.fluoroscopy).
    double voxel_m = 0.001;    // of the volume that rays sample, at the finest
    double step_m = 0.002;     // from sample to sample
    double stretch_m = 0.012;  // from one look at the motion to the next
    int block = 2;             // 1, 2 or 4: rays a side that share these looks
    FluoroscopySkips skips;
    bool count = false;  // fill in the counters (some atomic additions a ray)
};

struct FluoroscopyStats {
    std::string_view reason;  // why there is no picture: empty when there is one
    bool live = false;        // this call made a picture: radiation was on
    bool held = false;        // an earlier picture is shown: last-image hold, or between pulses
    std::int64_t pulse = -1;  // of the picture shown
    Exposure exposure;        // of this call: zero unless live
    // Counters of this call; the second row only with FluoroscopySettings::count.
    int pedal_up = 0, pulses_kept = 0, still_pictures = 0, idle_tool_pictures = 0, kept_contrast = 0;
    std::uint64_t samples = 0, empty_stretches = 0, collimated_rays = 0;
};

// Frame thread. Throws GpuError, vk::SystemError; a bad input is no error: a black picture and a reason.
class Fluoroscopy {
  public:
    // Both must outlive it. Makes and loads what it needs with the first picture.
    Fluoroscopy(const Gpu&, DeformedPatient&);
    ~Fluoroscopy();
    Fluoroscopy(const Fluoroscopy&) = delete;
    Fluoroscopy& operator=(const Fluoroscopy&) = delete;

    // Makes the picture of the pulse that `time_s` lies in, where there is one to be made, and waits for it.
    // Nothing of ours is allocated after the first picture of a size, but for a contrast table of another.
    FluoroscopyStats image(const FluoroscopyInput&, const FluoroscopySettings&);

    // The last picture; width 0 before the first call. Valid until the next image().
    ScreenPicture picture() const;
    // Line integrals behind each pixel of the last live picture, rows from the top.
    std::span<const float> paths() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
