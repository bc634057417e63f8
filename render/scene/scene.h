// Content of one frame, as plain structs. Absent parts cost nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/curved_tube.h"
#include "base/needle_shape.h"
#include "patient/displacement/tool_displacement.h"
#include "patient/patient.h"
#include "render/scene/frame_shared.h"

namespace stylet::render {

// An OpenXR view as the runtime reports it: pose in the stage, and the angles of the field of view in
// radians (left and down negative).
struct View {
    Pose stage_from_eye;
    float angle_left = -0.7f, angle_right = 0.7f, angle_up = 0.7f, angle_down = -0.7f;
};

// How the patient looks: `closed` shows the skin, `reveal` a translucent body with ducts, vessels and ribs.
enum class Look : std::uint8_t { closed, reveal };

// Tissue of the deformed patient with dot(normal, p) > offset_m is cut away.
struct CutPlane {
    Vec3 normal{0.0, 1.0, 0.0};
    double offset_m = 0.0;
};
inline constexpr int kMaxCutPlanes = gpu::kMaxCuts;

// A mark that the procedure leaves on the skin. It is fixed to the tissue and moves with the breath.
enum class MarkKind : std::uint8_t {
    incision,  // runs along `along`; `radius_m` is half its length
    puncture,  // the hole of a needle
    blood,     // a wet pool
    iodine     // disinfected skin
};
struct Mark {
    MarkKind kind = MarkKind::puncture;
    Vec3 reference_m{0.0};  // reference patient (as in the CT)
    double radius_m = 0.001;
    Vec3 along{0.0, 0.0, 1.0};  // unit vector: direction of an incision, or in which blood runs
};
inline constexpr int kMaxMarksShown = gpu::kMaxMarks;  // only the newest are shown

// A C-arm whose source and detector turn about its isocentre. Both angles 0: the source is below the table.
struct CArm {
    double orbital_rad = 0.0;     // > 0: the detector moves toward the patient's left
    double angulation_rad = 0.0;  // > 0: the detector moves toward the patient's head
    // Isocentre, patient frame. Absent: above the table's middle, beside the access field.
    std::optional<Vec3> isocentre_m = std::nullopt;
    friend bool operator==(const CArm&, const CArm&) = default;
};

// Equipment shown in the operating room. Without the shell there is a plain backdrop.
struct RoomContents {
    bool shell = false;  // floor, walls, ceiling, doors and built-in fixtures
    // Two heads on the ceiling. Without them the light comes from far away and casts no shadows.
    bool lamp = false;
    bool ultrasound = false, xray_monitor = false, patient_monitor = false, trolley = false;
    std::optional<CArm> c_arm;
    // Multiplies the light of the shell or the backdrop. Does not affect patient and tools.
    Vec3 shell_light{1.0};
    bool lamp_lit = true;  // false: the lamps give no light; ambient light stays. Ignored without lamps.
    // Without the shell: leave alpha 0 where nothing is drawn, for a see-through headset.
    bool real = false;
};
// The room with all of its equipment.
inline RoomContents wholeRoom() {
    return {true, true, true, true, true, true, CArm{}};
}

// Picture on a screen of the room: sRGB with alpha unused, rows from the top. Uploaded when `revision`
// changes.
struct ScreenPicture {
    int width = 0, height = 0;           // 0: the screen is idle
    const std::uint8_t* rgba = nullptr;  // only read while the frame is drawn
    std::uint64_t revision = 0;
    // A composition layer beneath the eye images shows the picture as well. The eye images then have alpha
    // 0 where the glass is visible.
    bool beneath = false;
};
// The glass of a screen: size, and pose of its middle with +x right, +y up, +z toward the viewer.
struct ScreenPlace {
    Pose stage_from_screen;
    double width_m = 0.0, height_m = 0.0;
};
using ScreenPlaces = std::array<ScreenPlace, 3>;  // ultrasound machine, X-ray monitor, patient monitor
inline constexpr int kMaxScreenPixels = gpu::kScreenPixels;  // of either edge

// Which of the room's screens are visible. Only these need a picture.
struct VisibleScreens {
    bool ultrasound = false, xray = false, monitor = false;
};

// A path from the skin to a duct, coloured by how good it is.
struct ShownPath {
    Vec3 entry_m{0.0}, target_m{0.0};  // patient frame, deformed
    double quality = 1.0;              // 0 to 1
};

// Points out a place to a trainee: a ring around it, an arrow that ends there, or both. It glows and casts no
// shadow.
struct Highlight {
    bool in_room = false;        // in the room's frame, else in the patient's (deformed)
    Vec3 at_m{0.0};              // middle of the ring, tip of the arrow
    Vec3 along{0.0, 0.0, -1.0};  // unit vector: axis of the ring, direction of the arrow
    double ring_m = 0.0;         // radius; 0: no ring
    double arrow_m = 0.0;        // length; 0: no arrow
};
// Places of the equipment in the room's frame, m: y up from the floor, the table's middle at the origin, z
// toward the patient's head. The operator stands at +x.
inline constexpr Vec3 kUltrasound{0.86, 0.0, 0.92}, kTrolley{0.98, 0.0, -0.80};
inline constexpr Vec3 kXrayMonitor{-0.92, 1.58, 0.62}, kPatientMonitor{-0.42, 1.58, 1.38};

// A tool that is not in the user's hand, drawn translucent. Its kinds have the poses of RenderScene's tools.
enum class GhostKind : std::uint8_t { needle, probe, scalpel, finger };
struct Ghost {
    GhostKind kind = GhostKind::needle;
    Pose patient_from_tool;
};

struct RenderScene {
    Pose stage_from_patient;
    patient::Surrogate breath;
    Look look = Look::reveal;
    bool table = true;
    std::vector<CutPlane> cuts;  // only the first kMaxCutPlanes are used
    std::vector<Mark> marks;
    // Displacement of the tissue by a tool (ToolDisplacement::table(); must outlive the frame). Null: no
    // tool presses.
    const patient::DisplacementTable* tool = nullptr;
    std::optional<Pose> patient_from_needle;
    NeedleShape needle;
    std::vector<CurvedTube> tubes;                        // guide wire, dilator and drain
    std::optional<std::array<Vec3, 2>> reference_path_m;  // entry and target, patient frame, deformed
    std::vector<ShownPath> paths;
    std::vector<Highlight> highlights;
    std::optional<Ghost> ghost;
    std::vector<CurvedTube> ghost_tubes;  // drawn like `ghost`
    std::optional<Pose> patient_from_probe,
        patient_from_scalpel;                 // contact end at the origin, handle toward +z
    bool flat_probe = false;                  // the probe is the linear one
    std::optional<Pose> patient_from_finger;  // tip of a gloved right hand's finger; +y: the back of the hand
    RoomContents room;
    // Middle of the access field on the skin, reference patient. The lamp points there, and the drape has
    // its opening there.
    std::optional<Vec3> field_m;
    bool drape = false;  // sterile drape with an opening around the field
    ScreenPicture ultrasound_screen, xray_screen, monitor_screen;
};

// Work that can be skipped. Switching a skip off costs time but does not change the picture.
struct Skips {
    bool empty_space = true;  // leap over bricks that the transfer function leaves transparent
    bool early_termination = true;
    bool depth_bounds = true;   // rays end at opaque geometry
    bool still_breath = true;   // no deformation while the breath is that of the CT
    bool idle_tool = true;      // no look-up of a tool's displacement while no tool presses
    bool unseen_parts = true;   // cull things of the room outside both eyes' view
    bool still_shadows = true;  // reuse the lamp's shadow map while nothing in it moves
};

// Foveated rendering. Beyond these angles from the optical axis (as tangents), 4 and 16 pixels share a ray.
struct Foveation {
    float quarter = 0.55f, sixteenth = 1.0f;
};

// Where the volume is ray-marched. Automatic: on the processor if Vulkan runs in software, because
// volume/march.h is a tenth to two thirds faster there than volume.comp (bench render.volume).
enum class VolumePath : std::uint8_t { automatic, gpu, processor };

struct RenderSettings {
    // Step along a ray, in units of the smallest voxel spacing. The default is the cheapest whose worst
    // tile keeps 40 dB (bench render.ray_step).
    float ray_step_voxels = 2.0f;
    // Resolution of the volume layer as a share of the target's, 0.1 to 1.
    float layer_scale = 1.0f;
    std::optional<Foveation> foveation = std::nullopt;
    bool close_up = true;   // at most about three rays per voxel when the head is close
    bool far_steps = true;  // no ray step shorter than a pixel is wide
    VolumePath volume_path = VolumePath::automatic;
    Skips skips = {};
    bool count = false;  // fill in the counters of RenderStats (some atomic additions per ray)
    float near_m = 0.05f, far_m = 20.0f;
};

// Counters of the last frame (both eyes). Without RenderSettings::count, the counters of samples, rays and
// bricks stay 0.
struct RenderStats {
    double gpu_ms = 0.0;                      // the whole frame
    double opaque_ms = 0.0, volume_ms = 0.0;  // its parts
    double layer_scale = 0.0;                 // scale at which the layer was drawn
    std::uint64_t samples = 0, rays = 0;
    std::uint64_t skipped_bricks = 0;  // leaps over empty bricks
    std::uint64_t terminated_rays = 0, depth_bounded_rays = 0;
    std::uint64_t still_frames = 0;      // 1 if the frame needed no deformation
    std::uint64_t idle_tool_frames = 0;  // 1 if the frame needed no tool displacement
    std::uint64_t culled_parts = 0;      // things of the room outside both eyes' view
    std::uint64_t reused_shadows = 0;    // 1 if the lamp's shadow map was reused
};

}  // namespace stylet::render
