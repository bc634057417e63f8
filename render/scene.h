// What one frame shows. A plain struct: what is absent costs nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "patient/patient.h"
#include "patient/tool_displacement.h"

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

// What lies beyond the plane dot(normal, p) = offset_m of the deformed patient is cut away.
struct CutPlane {
    Vec3 normal{0.0, 1.0, 0.0};
    double offset_m = 0.0;
};
inline constexpr int kMostCutPlanes = 4;

// What the procedure leaves on the skin. Fixed to the tissue: it breathes with the patient.
enum class MarkKind : std::uint8_t {
    incision,  // along `along`, half as long as `radius_m`
    puncture,  // the hole of a needle
    blood,     // a wet pool
    iodine     // disinfected skin
};
struct Mark {
    MarkKind kind = MarkKind::puncture;
    Vec3 reference_m{0.0};  // patient as the CT saw him
    double radius_m = 0.001;
    Vec3 along{0.0, 0.0, 1.0};  // unit: of an incision; where blood runs to
};
inline constexpr int kMostMarksShown = 24;  // the newest, where there are more

// A C-arm whose source and detector turn about its isocentre. Both angles 0: the source is below the table.
struct CArm {
    double orbital_rad = 0.0;     // > 0: the detector moves toward the patient's left
    double angulation_rad = 0.0;  // > 0: the detector moves toward the patient's head
    // What both turn about, patient frame. Absent: over the table's middle, beside the field.
    std::optional<Vec3> isocentre_m = std::nullopt;
    friend bool operator==(const CArm&, const CArm&) = default;
};

// What stands in the operating room around the table. Without the shell there is a plain backdrop.
struct RoomShown {
    bool shell = false;  // floor, walls, ceiling, doors and what is built in
    bool lamp =
        false;  // two heads on the ceiling; without them the light comes from far away and casts nothing
    bool ultrasound = false, xray_monitor = false, patient_monitor = false, trolley = false;
    std::optional<CArm> c_arm;
    // What the light that comes from the shell, or the backdrop, is multiplied by; neither patient nor tools.
    Vec3 shell_light{1.0};
    // Without the shell: alpha 0 where nothing is drawn, for a headset that one sees through.
    bool real = false;
};
// Everything in its place.
inline RoomShown wholeRoom() {
    return {true, true, true, true, true, true, CArm{}};
}

// What a screen of the room shows: sRGB with alpha unused, rows from the top. Uploaded when `revision`
// changes.
struct ScreenPicture {
    int width = 0, height = 0;           // 0: the screen is idle
    const std::uint8_t* rgba = nullptr;  // only read while the frame is drawn
    std::uint64_t revision = 0;
    // A layer beneath the eyes' pictures shows it too: where the glass is seen their alpha is 0.
    bool beneath = false;
};
// The glass of a screen in the stage: its middle, +x right, +y up, +z toward who looks at it.
struct ScreenPlace {
    Pose stage_from_screen;
    double width_m = 0.0, height_m = 0.0;
};
using ScreenPlaces = std::array<ScreenPlace, 3>;  // ultrasound machine, X-ray monitor, patient monitor
inline constexpr int kMostScreenPixels = 512;     // of either edge

// Which of the room's screens somebody sees: only for those a picture need be made.
struct ScreensSeen {
    bool ultrasound = false, xray = false, monitor = false;
};

// A path from the skin to a duct, coloured by how good it is.
struct ShownPath {
    Vec3 entry_m{0.0}, target_m{0.0};  // patient frame, deformed
    double quality = 1.0;              // 0 to 1
};

struct RenderScene {
    Pose stage_from_patient;
    patient::Surrogate breath;
    Look look = Look::reveal;
    bool table = true;
    std::vector<CutPlane> cuts;  // the first kMostCutPlanes
    std::vector<Mark> marks;
    // What a tool has displaced (ToolDisplacement::table(); must outlive the frame). Null: nothing presses.
    const patient::DisplacementTable* tool = nullptr;
    std::optional<Pose> patient_from_needle;
    std::optional<std::array<Vec3, 2>> reference_path_m;  // entry and target, patient frame, deformed
    std::vector<ShownPath> paths;
    std::optional<Pose> patient_from_probe,
        patient_from_scalpel;                 // what touches is at the origin, the hand at +z
    std::optional<Pose> patient_from_finger;  // tip of a gloved right hand's finger; +y: the back of the hand
    RoomShown room;
    // The middle of the access field on the skin, patient as the CT saw him: there the lamp shines, the drape
    // opens.
    std::optional<Vec3> field_m;
    bool drape = false;  // sterile drape with an opening around the field
    ScreenPicture ultrasound_screen, xray_screen, monitor_screen;
};

// Each skip can be switched off; the picture stays the same, only the work grows.
struct Skips {
    bool empty_space = true;  // bricks that the transfer function leaves transparent, with distances
    bool early_termination = true;
    bool depth_bounds = true;   // rays end at opaque geometry
    bool still_breath = true;   // no deformation where the patient is as the CT saw him
    bool idle_tool = true;      // no look-up of a tool's displacement while nothing presses
    bool unseen_parts = true;   // things of the room outside both eyes' pyramids
    bool still_shadows = true;  // the lamp's shadow map stays when nothing in it moved
};

// Fewer rays away from the optical axis; tangents of the angle beyond which 4 and 16 pixels share one.
struct Foveation {
    float quarter = 0.55f, sixteenth = 1.0f;
};

// Who marches the volume. Automatic: the processor, where it is Vulkan's device too (volume/march.h is a
// tenth to two thirds faster there than volume.comp: `render.volume`).
enum class VolumePath : std::uint8_t { automatic, gpu, processor };

struct RenderSettings {
    // Of the smallest spacing. Knob of render.ray_step: the cheapest whose worst tile keeps 40 dB.
    float ray_step_voxels = 2.0f;
    // Of the target's resolution, 0.1 to 1: what the volume is marched at.
    float layer_scale = 1.0f;
    std::optional<Foveation> foveation = std::nullopt;
    bool close_up = true;   // no more rays than three a voxel, when the head is close
    bool far_steps = true;  // no step shorter than a pixel is wide
    VolumePath volume_path = VolumePath::automatic;
    Skips skips = {};
    bool count = false;  // fill in the counters of RenderStats (some atomic additions a ray)
    float near_m = 0.05f, far_m = 20.0f;
};

// Counters of the last frame (both eyes). All but the times, layer_scale, the frames and the last two stay 0
// without RenderSettings::count.
struct RenderStats {
    double gpu_ms = 0.0;                      // all of the frame
    double opaque_ms = 0.0, volume_ms = 0.0;  // its parts
    double layer_scale = 0.0;                 // as it was drawn
    std::uint64_t samples = 0, rays = 0;
    std::uint64_t skipped_bricks = 0;  // leaps over empty bricks
    std::uint64_t terminated_rays = 0, depth_bounded_rays = 0;
    std::uint64_t still_frames = 0;      // 1 when the frame went without deformation
    std::uint64_t idle_tool_frames = 0;  // 1 when it went without a tool's displacement
    std::uint64_t culled_parts = 0;      // things of the room that no eye could see
    std::uint64_t kept_shadows = 0;      // 1 when the lamp's shadow map was still right
};

}  // namespace stylet::render
