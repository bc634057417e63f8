// Fluoroscopy: the picture on the C-arm's screen, and the dose of each pulse.
//
// rays.comp computes Beer-Lambert line integrals through the breathing, displaced patient and adds
// instruments and contrast. The brightness control sets the exposure. screen.comp adds quantum and
// electronic noise and applies the screen's curve.
// Conventions of the screen, as in angiography systems: dense is dark. The picture is seen from the
// detector, with the patient's head at the top and the patient's left on the right at both angles 0.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "render/fluoroscopy/beam.h"
#include "render/fluoroscopy/exposure.h"
#include "render/fluoroscopy/shapes.h"
#include "render/gpu/gpu.h"
#include "render/scene/scene.h"
#include "render/volume/deformed_patient.h"

namespace stylet::patient {
struct ContrastTable;  // patient/contrast/contrast.h
}

namespace stylet::render {

// Input of one picture. The patient's breath and the tool's displacement come from DeformedPatient.
struct FluoroscopyInput {
    CArm arm;                     // orbital and angulation angles
    Pose patient_from_isocentre;  // includes table height and travel; axes as in beam.h
    Collimation collimation;
    bool pedal = false;   // false: no radiation, the last picture stays
    double time_s = 0.0;  // pulses are counted from 0
    std::span<const XrayShape> shapes = {};
    const patient::ContrastTable* contrast = nullptr;  // null: none
};

// Work that can be skipped. Switching a skip off costs time but does not change the picture. (The caller of
// DeformedPatient::breathe() decides whether a still patient is deformed.)
struct FluoroscopySkips {
    bool between_pulses = true;      // compute the picture of a pulse once
    bool collimated_rays = true;     // no ray behind the blades
    bool empty_cells = true;         // no samples in air
    bool idle_tool = true;           // no look-up of a tool's displacement while no tool presses
    bool unchanged_contrast = true;  // rewrite the sampled volume only when the contrast has changed
};

struct FluoroscopySettings {
    int pixels = 256;  // per side of the detector, 1 to 2048
    double detector_m = 0.300;
    double pulse_rate_hz = 7.5;
    DoseSettings dose;
    double electronic_quanta = 4.0;  // rms per pixel
    double curve = 2.2;              // slope of the screen's S-curve over the logarithm of the quanta
    double flattening = 0.65;        // share of the logarithm's low-frequency part that is removed
    bool dense_is_dark = true;
    std::uint32_t seed = 1;
    // The CT's first and last slices are repeated for this length beyond its ends.
    double beyond_ends_m = 0.15;
    // Quality settings (stylet-bench --only imaging.fluoroscopy).
    double voxel_m = 0.001;    // finest voxel of the volume that rays sample
    double step_m = 0.002;     // from sample to sample
    double segment_m = 0.012;  // length along a ray between two look-ups of the motion
    int block = 2;             // rays per side of a block that shares these look-ups: 1, 2 or 4
    FluoroscopySkips skips;
    bool count = false;  // fill in the counters (some atomic additions per ray)
};

struct FluoroscopyStats {
    std::string_view reason;       // why there is no picture; empty if there is one
    bool live = false;             // this call computed a picture: radiation was on
    bool last_image_held = false;  // an earlier picture is shown: last-image hold, or between pulses
    std::int64_t pulse = -1;       // of the picture shown
    Exposure exposure;             // of this call: zero unless live
    // Counters of this call; the second row only with FluoroscopySettings::count.
    int pedal_up = 0, reused_pulses = 0, still_pictures = 0, idle_tool_pictures = 0, unchanged_contrast = 0;
    std::uint64_t samples = 0, empty_segments = 0, collimated_rays = 0;
};

// Frame thread. Throws GpuError, vk::SystemError. Invalid input does not throw: it gives a black picture
// and a reason.
class Fluoroscopy {
  public:
    // Both must outlive this object. Resources are created and loaded with the first picture.
    Fluoroscopy(const Gpu&, DeformedPatient&);
    ~Fluoroscopy();
    Fluoroscopy(const Fluoroscopy&) = delete;
    Fluoroscopy& operator=(const Fluoroscopy&) = delete;

    // Computes the picture of the pulse that contains `time_s`, if one is due, and waits for it. Allocates
    // nothing after the first picture of a size, except for a contrast table of a new size.
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
