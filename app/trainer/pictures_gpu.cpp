#include <algorithm>
#include <cmath>
#include <memory>

#include "app/trainer/frames.h"
#include "app/trainer/pictures.h"
#include "render/render.h"

namespace stylet::trainer {

namespace {

PictureTotals totalsOf(const FrameLoop& loop) {
    const FrameTotals from = loop.totals();
    PictureTotals totals;
    totals.frames = from.frames;
    totals.rendered = from.rendered;
    totals.validation_messages = from.validation_messages;
    totals.median_frame_ms = from.median_frame_ms;
    totals.runtime = from.runtime;
    totals.gpu = from.gpu;
    totals.skips = {{"skipped_bricks", from.sum.skipped_bricks},
                    {"terminated_rays", from.sum.terminated_rays},
                    {"depth_bounded_rays", from.sum.depth_bounded_rays},
                    {"still_frames", from.sum.still_frames}};
    return totals;
}

// Both eyes of the operator as he leans over the entry, the patient filling their pictures.
struct StillHead {
    StillHead(const patient::Patient& patient_in, const patient::PlannedPath& path_in,
              const std::filesystem::path& assets)
        : patient(patient_in), path(path_in), renderer(gpu, {}, assets) {
        scene.stage_from_patient = stageFromPatient(patient, path);
        const patient::Pose head = stageFromHead(scene.stage_from_patient, path, 0.0);
        views = {viewFrom(head, -0.5 * kMockEyeDistance_m), viewFrom(head, 0.5 * kMockEyeDistance_m)};
        renderer.setPatient(patient);
    }

    // An eye so far to the right of the head's middle.
    render::View viewFrom(const patient::Pose& head, double right_m) const {
        const patient::Grid& grid = patient.grid();
        const patient::Vec3 middle = 0.5 * (grid.origin_m + grid.centre(grid.dims - 1));
        const patient::Vec3 size_m = grid.spacing_m * patient::Vec3(grid.dims);
        patient::Pose eye = head;
        eye.position_m += head.direction({right_m, 0.0, 0.0});
        const patient::Vec3 seen = eye.inverse() * (scene.stage_from_patient * middle);
        const double x = seen.x / -seen.z, y = seen.y / -seen.z;
        const double half = kRoom * 0.5 * std::max(size_m.x, size_m.z) / -seen.z;
        return {eye, float(std::atan(x - half)), float(std::atan(x + half)), float(std::atan(y + half)),
                float(std::atan(y - half))};
    }

    std::array<EyePicture, 2> draw(const patient::Surrogate& breath) {
        const patient::MotionModel& motion = patient.package().motion;
        scene.breath = breath;
        scene.reference_path_m = {patient::deformedFromReference(motion, breath, path.entry_reference_m),
                                  patient::deformedFromReference(motion, breath, path.target_reference_m)};
        std::array<EyePicture, 2> eyes;
        const std::array<render::Image, 2> images =
            renderer.drawToImages(scene, views, kEyePixels, kEyePixels);
        for (std::size_t eye = 0; eye < 2; ++eye) {
            eyes[eye] = {int(kEyePixels), int(kEyePixels), {}};
            for (std::size_t i = 0; i < images[eye].rgba.size(); ++i)
                if (i % 4 != 3) eyes[eye].rgb.push_back(images[eye].rgba[i]);
        }
        return eyes;
    }

    static constexpr std::uint32_t kEyePixels = 640;
    static constexpr double kRoom = 1.2;  // of the picture to the patient
    const patient::Patient& patient;
    const patient::PlannedPath path;
    render::Gpu gpu{render::GpuSettings{}};
    render::Renderer renderer;
    render::RenderScene scene;
    std::array<render::View, 2> views;
};

}  // namespace

std::optional<Pictures> openPictures(const patient::Patient& patient, const patient::PlannedPath& path,
                                     const PictureSettings& settings, std::string& why_not) {
    FrameSettings frame_settings;
    frame_settings.assets = settings.assets;
    frame_settings.capture_dir = settings.capture_folder;
    frame_settings.validation = settings.validation;
    frame_settings.virtual_clock = settings.virtual_clock;
    try {
        // Shared because a std::function must be copyable; there is one owner.
        const auto loop = std::make_shared<FrameLoop>(patient, frame_settings, path);
        return Pictures{[loop](const haptics::TickOutput& shown, const std::string& moment) {
                            return loop->frame(shown, moment);
                        },
                        [loop] { return totalsOf(*loop); }, [loop] { return loop->focused(); }};
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

std::optional<StereoView> openStereo(const patient::Patient& patient, const patient::PlannedPath& path,
                                     const std::filesystem::path& assets, std::string& why_not) {
    try {
        const auto head = std::make_shared<StillHead>(patient, path, assets);
        return StereoView{[head](const patient::Surrogate& breath) { return head->draw(breath); },
                          head->gpu.name()};
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

}  // namespace stylet::trainer
