#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "app/trainer/display/frames.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/view/equipment_pictures.h"
#include "app/trainer/view/pictures.h"
#include "app/trainer/view/scene.h"
#include "app/trainer/window/mirror.h"
#include "render/render.h"

namespace stylet::trainer {

namespace {

PictureTotals totalsOf(const FrameLoop& loop) {
    const FrameTotals from = loop.totals();
    PictureTotals totals = from;
    totals.skips = {
        {"still_frames", from.sum.still_frames},    {"idle_tool_frames", from.sum.idle_tool_frames},
        {"culled_parts", from.sum.culled_parts},    {"kept_shadows", from.sum.reused_shadows},
        {"panels_drawn", from.panels_drawn},        {"unseen_panels", from.unseen_panels},
        {"unseen_screens", from.equipment.unseen},  {"frozen_scans", from.equipment.frozen},
        {"still_scans", from.equipment.still_scans}};
    totals.scans = from.equipment.scans, totals.xray_pictures = from.equipment.xray_pictures;
    totals.ultrasound_ms = from.equipment.ultrasound_ms, totals.xray_ms = from.equipment.xray_ms;
    if (from.sum.rays > 0)  // only if rays were counted
        totals.skips.insert(totals.skips.begin(), {{"skipped_bricks", from.sum.skipped_bricks},
                                                   {"terminated_rays", from.sum.terminated_rays},
                                                   {"depth_bounded_rays", from.sum.depth_bounded_rays}});
    return totals;
}

// The frame loop of a headset and, if requested, its mirror window.
class HeadsetDisplay final : public Display {
  public:
    HeadsetDisplay(const patient::Patient& patient, const PictureSettings& settings,
                   const patient::PlannedPath& path)
        : frames_(patient, settings, path) {}
    void openMirror(const patient::Patient& patient, const PictureSettings& settings,
                    const patient::PlannedPath& path) {
        try {
            MirrorSettings mirror{.pictures = settings};
            if (!settings.pipeline_cache.empty())
                mirror.pipeline_cache = settings.pipeline_cache.parent_path() / "window-pipelines.bin";
            window_.emplace(patient, path, mirror);
            frames_.mirrorTo(window_->channels());
        } catch (const WindowError& e) {
            printMessage(fmt::format("no mirror window: {}", e.what()));
        }
    }
    bool frame(const FrameState& seen, const patient::ContrastTable* contrast,
               const std::string& moment) override {
        return frames_.frame(seen, contrast, moment);
    }
    PictureTotals totals() const override {
        PictureTotals both = totalsOf(frames_);
        if (window_) both.validation_messages += window_->validationMessages();
        return both;
    }
    Attention attention() const override { return frames_.attention(); }
    void follow(LiveUpdates live) override { frames_.follow(std::move(live)); }

  private:
    std::optional<Mirror> window_;  // outlives the frame loop, which writes to it
    FrameLoop frames_;
};

// Draws stereo pictures for a fixed head pose that leans over the entry.
struct StillHead {
    StillHead(const patient::Patient& patient_in, const patient::PlannedPath& path_in,
              const std::filesystem::path& assets)
        : patient(patient_in),
          path(path_in),
          field(fieldOf(path)),
          renderer(gpu, {}, assets),
          stage_from_patient(stageFromPatient(patient, field)) {
        renderer.setPatient(patient);
    }

    // Returns the views of both eyes of a head. Each eye sees a square around `middle`. `half` is the tangent
    // of half its view angle.
    std::array<render::View, 2> eyesOf(const Pose& head, const Vec3& middle, double half) const {
        std::array<render::View, 2> eyes;
        for (const int side : {0, 1}) {
            Pose eye = head;
            eye.position_m += head.direction({(side - 0.5) * kMockEyeDistance_m, 0.0, 0.0});
            const Vec3 seen = eye.inverse() * middle;
            const double x = seen.x / -seen.z, y = seen.y / -seen.z;
            eyes[std::size_t(side)] = {eye, float(std::atan(x - half)), float(std::atan(x + half)),
                                       float(std::atan(y + half)), float(std::atan(y - half))};
        }
        return eyes;
    }

    std::array<render::View, 2> eyeViews(const StereoShot& shot) const {
        Pose head = stageFromHead(stage_from_patient, field, 0.0);
        const Vec3 entry = stage_from_patient * field.entry_m;
        if (shot.distance_m) {
            head.position_m = entry + *shot.distance_m * glm::normalize(head.position_m - entry);
            return eyesOf(head, entry, kCloseUpTangent);
        }
        if (shot.across_the_room)
            return eyesOf(stageFromEyes(kDoor_m, kOverTable_m), kOverTable_m, kCloseUpTangent);
        const Grid& grid = patient.grid();
        const Vec3 middle_patient = 0.5 * (grid.origin_m + grid.centre(grid.dims - 1));
        const Vec3 middle = stage_from_patient * middle_patient;
        const Vec3 size_m = grid.spacing_m * Vec3(grid.dims);
        if (shot.section) head = stageFromEyes(stage_from_patient * (middle_patient + kFromTheFeet), middle);
        const double away = -(head.inverse() * middle).z;
        return eyesOf(head, middle, kRoom * 0.5 * std::max(size_m.x, size_m.z) / away);
    }

    render::RenderScene makeScene(const StereoShot& shot) const {
        const patient::MotionModel& motion = patient.package().motion;
        render::RenderScene scene;
        scene.stage_from_patient = stage_from_patient;
        scene.look = shot.closed ? render::Look::closed : render::Look::reveal;
        scene.breath = shot.breath;
        scene.patient_from_needle = shot.patient_from_needle;
        scene.tool = shot.tool;
        scene.marks = makeMarks(shot.wounds, scene.look, path.entry_reference_m);
        // Cut away the side toward the feet, so that the operator looks at the cut surface.
        if (shot.section) scene.cuts = {{Vec3(0.0, 0.0, -1.0), -path.entry_m.z}};
        addRoom(scene, field);
        for (const patient::PlannedPath& good : shot.paths)
            scene.paths.push_back({good.entry_m, good.target_m, good.quality});
        if (!shot.closed && shot.paths.empty())
            scene.reference_path_m = {
                patient::deformedFromReference(motion, shot.breath, path.entry_reference_m),
                patient::deformedFromReference(motion, shot.breath, path.target_reference_m)};
        return scene;
    }

    std::array<EyePicture, 2> draw(const StereoShot& shot) {
        std::array<EyePicture, 2> eyes;
        const std::array<render::Image, 2> images = renderer.drawToImages(
            makeScene(shot), eyeViews(shot), std::uint32_t(shot.pixels), std::uint32_t(shot.pixels));
        for (std::size_t eye = 0; eye < 2; ++eye)
            eyes[eye] = {shot.pixels, shot.pixels, rgbOf(images[eye].rgba)};
        return eyes;
    }

    // Direction of the viewpoint for a cut: from the feet, the operator's side and above.
    static constexpr Vec3 kFromTheFeet{0.22, 0.30, -0.50};
    static constexpr Vec3 kDoor_m{1.7, 1.75, 1.5}, kOverTable_m{-0.1, 1.05, -0.55};
    static constexpr double kRoom = 1.2;            // size of the picture relative to the patient
    static constexpr double kCloseUpTangent = 0.7;  // tangent of half the view angle
    const patient::Patient& patient;
    const patient::PlannedPath path;
    const OperativeField field;
    render::Gpu gpu{render::GpuSettings{}};
    render::Renderer renderer;
    const Pose stage_from_patient;
};

// Draws the equipment pictures only, without a room.
struct StillEquipment {
    StillEquipment(const patient::Patient& patient, const std::filesystem::path& assets)
        : deformed(gpu, patient), pictures(gpu, deformed, assets) {}
    render::Gpu gpu{render::GpuSettings{}};
    render::DeformedPatient deformed;
    EquipmentPictures pictures;
};

EyePicture pictureOf(const render::ScreenPicture& screen) {
    return {screen.width, screen.height,
            rgbOf({screen.rgba, std::size_t(4) * std::size_t(screen.width) * std::size_t(screen.height)})};
}

}  // namespace

std::unique_ptr<Display> openPictures(const patient::Patient& patient, const patient::PlannedPath& path,
                                      const PictureSettings& settings, std::string& why_not) {
    // A wrong look file ends the program. It is a mistake in the command line, not a missing GPU.
    if (!settings.config.look_file.empty()) render::loadLook(settings.config.look_file);
    try {
        auto display = std::make_unique<HeadsetDisplay>(patient, settings, path);
        if (settings.config.mirror) display->openMirror(patient, settings, path);
        return display;
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return nullptr;
    }
}

std::optional<EquipmentView> openEquipment(const patient::Patient& patient,
                                           const std::filesystem::path& assets, std::string& why_not) {
    try {
        const auto equipment = std::make_shared<StillEquipment>(patient, assets);
        return EquipmentView{[equipment](const ImagingInput& m) {
                                 equipment->pictures.show(m, {.ultrasound = true});
                                 return pictureOf(equipment->pictures.ultrasoundScreen());
                             },
                             [equipment](const ImagingInput& m) {
                                 equipment->pictures.show(m, {.xray = true});
                                 return pictureOf(equipment->pictures.xrayScreen());
                             },
                             equipment->gpu.name()};
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

std::optional<StereoView> openStereo(const patient::Patient& patient, const patient::PlannedPath& path,
                                     const std::filesystem::path& assets, std::string& why_not) {
    try {
        const auto head = std::make_shared<StillHead>(patient, path, assets);
        return StereoView{[head](const StereoShot& shot) { return head->draw(shot); }, head->gpu.name()};
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

}  // namespace stylet::trainer
