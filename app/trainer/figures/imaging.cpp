#include "app/trainer/figures/imaging.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>

#include <glm/gtc/quaternion.hpp>

#include "app/installation.h"
#include "app/report/film.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/imaging_input.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/trainer/view/contacts.h"
#include "app/trainer/view/pictures.h"
#include "base/folder_linux.h"
#include "patient/contrast/contrast_table.h"

namespace stylet::trainer {
namespace {

constexpr double kPressed_m = 0.008;  // depth to which the probe's face is pressed into the skin
constexpr double kShort_m = 0.012;    // distance between tip and duct, for an advancing needle
constexpr double kDeep_m = 0.060, kShallow_m = 0.030,
                 kDeepest_m = 0.100;  // depths along a scan line: of ribs; of ducts and vessels
constexpr int kRolls = 24;
constexpr std::size_t kPathsTried = 12;
constexpr double kHalfFan_rad = std::numbers::pi / 6;

// A probe pose on the skin whose picture contains a planned path.
struct Placed {
    Pose patient_from_tool;  // stylus frame: +z out of the body
    double touching = 0.0;   // share of the probe's face that touches the skin
    double blocked = 0.0;    // share of the scan lines that hit bone
    double tubes = 0.0;      // share of the picture that shows a duct or vessel
};

// Tissue at a point of the reference CT. This is sufficient to find a window between ribs.
patient::Tissue tissueInReference(const patient::Patient& patient, const Vec3& reference_m) {
    return patient.at(reference_m, patient::TrackFlags{true, false}).tissue;
}

// Turns the probe about the path by `roll_rad`, then lowers it along its own axis until its face is pressed
// in.
Placed place(const patient::Patient& patient, const haptics::TouchMap& touch,
             const patient::PlannedPath& path, double roll_rad) {
    const Vec3 axis = glm::normalize(path.target_reference_m - path.entry_reference_m);
    const Pose rolled =
        needlePose(path.entry_reference_m, axis) * Pose{glm::angleAxis(roll_rad, Vec3(0, 0, 1)), Vec3(0.0)};
    Placed placed{toolPoseFromNeedle(rolled, haptics::Tool::probe, haptics::GuideSettings{})};
    const haptics::ProbeSettings face;
    constexpr int kPoints = 17;
    const auto facePoint = [&](int i) {
        const double x = face.length_m * (double(i) / (kPoints - 1) - 0.5);
        const double back = face.curvature_m - std::sqrt(face.curvature_m * face.curvature_m - x * x);
        return placed.patient_from_tool * Vec3(x, 0.0, back);
    };
    const auto level = [&](int i) { return haptics::touchAt(touch, facePoint(i)).level_m; };
    const Vec3 outward = placed.patient_from_tool.direction({0.0, 0.0, 1.0});
    for (int step = 0; step < 8; ++step) {
        double deepest_m = level(0);
        for (int i = 1; i < kPoints; ++i)
            deepest_m = std::min(deepest_m, level(i));
        placed.patient_from_tool.position_m -= (deepest_m + kPressed_m) * outward;
    }
    for (int i = 0; i < kPoints; ++i) {
        placed.touching += level(i) < 0.0 ? 1.0 / kPoints : 0.0;
        const double angle = kHalfFan_rad * (2.0 * i / (kPoints - 1) - 1.0);
        const Vec3 along = placed.patient_from_tool.direction({std::sin(angle), 0.0, -std::cos(angle)});
        bool bone = false;
        int tubes = 0, samples = 0;
        for (double d = 0.004; d < kDeepest_m && !bone; d += 0.002, ++samples) {
            const patient::Tissue tissue = tissueInReference(patient, facePoint(i) + d * along);
            bone = isSkeleton(tissue) && d < kDeep_m;
            if (d < kShallow_m || std::abs(i - kPoints / 2) > kPoints / 4) continue;
            tubes += tissue == patient::Tissue::duct || tissue == patient::Tissue::vessel ? 1 : 0;
        }
        placed.blocked += bone ? 1.0 / kPoints : 0.0;
        placed.tubes += bone ? 0.0 : double(tubes) / (samples * kPoints);
    }
    return placed;
}

// Best placement over all paths and roll angles. It shows the most ducts and vessels between the ribs or,
// with `across_ribs`, the most ribs.
struct Found {
    Placed placed;
    const patient::PlannedPath* path = nullptr;
};
Found bestPlace(const patient::Patient& patient, const haptics::TouchMap& touch,
                std::span<const patient::PlannedPath> paths, bool across_ribs) {
    Found best;
    double best_score = -1e9;
    for (const patient::PlannedPath& path : paths)
        for (int i = 0; i < kRolls; ++i) {
            const Placed tried = place(patient, touch, path, 2.0 * std::numbers::pi * i / kRolls);
            const double score = 2.0 * tried.touching +
                                 (across_ribs ? tried.blocked : 10.0 * tried.tubes - 2.0 * tried.blocked);
            if (score > best_score) best = {tried, &path}, best_score = score;
        }
    return best;
}

// One picture: a parked probe with or without a needle.
struct Shot {
    std::string caption;
    ImagingInput moment;
    std::optional<patient::DisplacementTable> pressed;
    std::optional<patient::ContrastTable> contrast;
};

struct Sheet {
    const patient::Patient& patient;
    const std::span<const patient::PlannedPath> paths;
    const haptics::TouchMap touch = haptics::makeTouchMap(patient);
    const Found between = bestPlace(patient, touch, paths, false);
    const patient::PlannedPath& path = *between.path;
    const Vec3 axis = glm::normalize(path.target_reference_m - path.entry_reference_m);

    Shot makeShot(const std::string& caption, const std::optional<Pose>& patient_from_tool,
                  const std::optional<Pose>& patient_from_needle) const {
        haptics::TickOutput tick;
        tick.breath = patient.package().motion.reference;
        tick.tool = patient_from_needle ? haptics::Tool::needle : haptics::Tool::probe;
        if (patient_from_needle) tick.patient_from_needle = *patient_from_needle;
        if (patient_from_tool) {
            tick.probe_parked = true;
            tick.patient_from_probe = *patient_from_tool * haptics::kStylusFromProbe;
        }
        Shot shot{caption, makeImagingInput(tick, {}, {}, 0.001), {}, {}};
        if (!patient_from_tool) shot.moment.patient_from_probe.reset();
        shot.moment.guide_m.reset();
        ToolPress press(patient, {.touch = &touch});
        for (int i = 0; i < 8; ++i)
            if (const patient::DisplacementTable* table = press.shown(tick)) shot.pressed = *table;
        return shot;
    }

    // Needle pose along the path. The tip is `before_m` short of the target and offset by `beside_m`.
    Pose needleAt(double before_m, const Vec3& beside_m) const {
        return needlePose(path.target_reference_m - before_m * axis + beside_m, axis);
    }

    std::vector<Shot> scans() const;
    std::vector<Shot> exposures() const;
    patient::ContrastTable injected(const Vec3& tip_m, double ml) const;
};

std::vector<Shot> Sheet::scans() const {
    const Pose& window = between.placed.patient_from_tool;
    const Pose across = bestPlace(patient, touch, paths, true).placed.patient_from_tool;
    const Vec3 elevation = window.direction({0.0, 1.0, 0.0});
    // The needle crosses the image plane at one point, beside the target.
    const Vec3 slanted = glm::normalize(0.35 * axis + elevation);
    std::vector<Shot> shots;
    shots.push_back(makeShot("between the ribs: liver, portal branch and bile duct", window, {}));
    shots.push_back(makeShot("the same, colour Doppler", window, {}));
    shots.back().moment.equipment.ultrasound.doppler = true;
    shots.push_back(makeShot("across the ribs: their shadows", across, {}));
    shots.push_back(makeShot("needle in the plane", window, needleAt(kShort_m, Vec3(0.0))));
    shots.push_back(makeShot("needle beside the plane, 8 mm", window, needleAt(kShort_m, 0.008 * elevation)));
    shots.push_back(makeShot("needle across the plane", window,
                             needlePose(path.target_reference_m + 0.010 * slanted, slanted)));
    return shots;
}

patient::ContrastTable Sheet::injected(const Vec3& tip_m, double ml) const {
    patient::Contrast contrast(patient);
    constexpr double kRate_m3_per_s = 1e-6, kDt_s = 0.01;
    for (double t_s = 0.0; t_s < ml; t_s += kDt_s)
        contrast.step({.tip_reference_m = tip_m, .rate_m3_per_s = kRate_m3_per_s}, kDt_s);
    patient::ContrastChanges all;
    patient::ContrastTable table;
    if (patient::ContrastPainter().paint(contrast, all)) patient::apply(all, table);
    return table;
}

std::vector<Shot> Sheet::exposures() const {
    const Vec3 target = path.target_reference_m;
    const Pose needle = needleAt(0.0, Vec3(0.0));
    std::vector<Shot> shots;
    const auto add = [&](const std::string& caption, const std::optional<Pose>& held) -> Shot& {
        shots.push_back(makeShot(caption, {}, held));
        ImagingInput& m = shots.back().moment;
        m.patient_from_isocentre.position_m = fieldOf(path).isocentre_m;
        m.equipment.xray.pedal = true;
        m.equipment.xray.pulses = shots.size();
        return shots.back();
    };
    const auto inject = [&](Shot& shot, const Vec3& tip_m, double ml) {
        shot.contrast = injected(tip_m, ml);
        shot.moment.dose.contrast_m3 = 1e-6 * ml;
    };
    add("before", {});
    add("the needle in the duct", needle);
    inject(add("cholangiography, 3 ml", needle), target, 3.0);
    inject(add("cholangiography, 12 ml", needle), target, 12.0);
    Shot& oblique = add("12 ml, 30\u00b0 LAO, the field closed to 16 cm", needle);
    inject(oblique, target, 12.0);
    oblique.moment.equipment.xray.rotation_rad = std::numbers::pi / 6;
    oblique.moment.equipment.xray.field_m = 0.16;
    const Vec3 wrong = target - 0.018 * axis;
    inject(add("a wrong tip: the liver stained by 4 ml", needlePose(wrong, axis)), wrong, 4.0);
    return shots;
}

}  // namespace

int imaging(const ImagingOptions& options) {
    requireFolder(options.out, "--out");
    const OpenedPatient opened = openPatient(options.source);
    const patient::Patient patient(opened.package);
    const std::vector<patient::PlannedPath> paths =
        goodPaths(patient, opened.folder, opened.package.motion.reference);
    std::string why_not;
    const auto equipment = openEquipment(patient, assetsFolder(), why_not);
    if (!equipment) throw EnvironmentError("no pictures can be drawn: " + why_not);
    const Sheet sheet{patient, std::span(paths).first(std::min(paths.size(), kPathsTried))};
    const auto write = [&](std::vector<Shot> shots, const auto& picture, const std::string& name) {
        std::vector<report::FilmFrame> frames;
        for (Shot& shot : shots) {
            shot.moment.time_s = double(frames.size());  // a new time for each picture
            if (shot.pressed) shot.moment.tool = &*shot.pressed;
            if (shot.contrast) shot.moment.contrast = &*shot.contrast;
            EyePicture screen = picture(shot.moment);
            frames.push_back({screen.width, screen.height, std::move(screen.rgb), shot.caption});
        }
        report::writeFilm(frames, opened.package.name + ", " + name, options.out, name);
        std::printf("%s\n", (options.out / (name + ".png")).c_str());
    };
    write(sheet.scans(), equipment->ultrasound, "ultrasound");
    write(sheet.exposures(), equipment->xray, "fluoroscopy");
    std::printf("on %s\n", equipment->gpu.c_str());
    return 0;
}

}  // namespace stylet::trainer
