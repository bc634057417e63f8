// What one frame shows. A plain struct: what is absent costs nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "patient/patient.h"

namespace stylet::render {

using patient::Pose;
using patient::Vec3;

// An OpenXR view: pose in the stage, tangents' angles in radians (left and down negative), as the runtime
// gave them.
struct View {
    Pose stage_from_eye;
    float angle_left = -0.7f, angle_right = 0.7f, angle_up = 0.7f, angle_down = -0.7f;
};

// How the patient looks: `closed` shows the skin, `reveal` a translucent body with ducts, vessels and ribs.
enum class Look : std::uint8_t { closed, reveal };

struct RenderScene {
    Pose stage_from_patient;
    patient::Surrogate breath;
    Look look = Look::reveal;
    bool table = true;
    std::optional<Pose> patient_from_needle;
    std::optional<std::array<Vec3, 2>> reference_path_m;  // entry and target, patient frame, deformed
};

// Each skip can be switched off; the picture stays the same, only the work grows.
struct Skips {
    bool empty_space = true;  // bricks that the transfer function leaves transparent, with distances
    bool early_termination = true;
    bool depth_bounds = true;  // rays end at opaque geometry
    bool still_breath = true;  // no deformation where the patient is as the CT saw him
};

struct RenderSettings {
    // Of the smallest spacing. Knob of render.ray_step: the cheapest whose worst tile keeps 40 dB.
    float ray_step_voxels = 2.0f;
    Skips skips = {};
    bool count = false;  // fill in the counters of RenderStats (some atomic additions a ray)
    float near_m = 0.05f, far_m = 20.0f;
};

// Counters of the last frame (both eyes). All but gpu_ms and still_frames stay 0 without
// RenderSettings::count.
struct RenderStats {
    double gpu_ms = 0.0;
    std::uint64_t samples = 0, rays = 0;
    std::uint64_t skipped_bricks = 0;  // leaps over empty bricks
    std::uint64_t terminated_rays = 0, depth_bounded_rays = 0;
    std::uint64_t still_frames = 0;  // 1 when the frame went without deformation
};

}  // namespace stylet::render
