#include "app/trainer/view/scene.h"

#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/alert.h"
#include "app/trainer/view/access_tubes.h"

namespace stylet::trainer {

namespace {

constexpr double kField_m = 0.115;   // radius of the disinfected skin; the drape's opening reaches 0.113
constexpr double kLightsOut = 0.35;  // share of the shell's light that the screens and the corridor leave

// Indexed by WoundKind.
constexpr std::array kWoundMarks{render::MarkKind::incision, render::MarkKind::puncture,
                                 render::MarkKind::blood};

}  // namespace

void loadSceneLook(render::Renderer& renderer, const AttemptConfig& config) {
    if (!config.look_file.empty()) renderer.setLook(sceneLook(config), render::loadLook(config.look_file));
}

void addRoom(render::RenderScene& scene, const OperativeField& field, const training::XrayState& xray) {
    scene.room = render::wholeRoom();
    if (xray.pulses > 0)
        scene.room.c_arm = render::CArm{xray.rotation_rad, xray.angulation_rad,
                                        xray.aimed_m ? isocentreFor(*xray.aimed_m) : field.isocentre_m};
    scene.field_m = field.entry_reference_m;
    scene.drape = scene.look == render::Look::closed && scene.cuts.empty();
}

void showTools(render::RenderScene& scene, const FrameState& seen) {
    const haptics::TickOutput& tick = seen.tick;
    if (haptics::isNeedleTool(tick.tool) || tick.access.needle_in)
        scene.patient_from_needle = tick.patient_from_needle;
    scene.needle = seen.needle;
    if (tick.tool == haptics::Tool::finger) scene.patient_from_finger = tick.patient_from_tool;
    if (tick.tool == haptics::Tool::scalpel) scene.patient_from_scalpel = tick.patient_from_tool;
    if (tick.tool == haptics::Tool::probe) scene.patient_from_probe = tick.patient_from_tool;
    scene.flat_probe = render::isFlatFace(seen.probe.length_m, seen.probe.curvature_m);
    if (tick.probe_parked)
        scene.patient_from_probe = tick.patient_from_probe * haptics::kStylusFromProbe.inverse();
}

void showGhost(render::RenderScene& scene, const FrameState& seen, const patient::MotionModel& motion) {
    using haptics::Tool;
    if (!seen.ghost_tool) return;
    const GhostTool& ghost = *seen.ghost_tool;
    if (ghost.access) {
        haptics::TickOutput tick;
        tick.tool = ghost.tool, tick.breath = seen.tick.breath, tick.access = *ghost.access;
        scene.ghost_tubes = accessTubes(tick, seen.access, motion, ghost.length_m);
        return;
    }
    scene.ghost = {ghost.tool == Tool::probe     ? render::GhostKind::probe
                   : ghost.tool == Tool::scalpel ? render::GhostKind::scalpel
                   : ghost.tool == Tool::finger  ? render::GhostKind::finger
                                                 : render::GhostKind::needle,
                   ghost.patient_from_tool};
    // A needle is thin: its line is easier to follow.
    if (scene.ghost->kind == render::GhostKind::needle)
        scene.paths.push_back({ghost.patient_from_tool * Vec3(0.0, 0.0, ghost.length_m),
                               ghost.patient_from_tool.position_m, 1.0});
}

void showMonitor(render::RenderScene& scene, const BreathMonitor& monitor) {
    if (monitor.revision() > 0)
        scene.monitor_screen = {BreathMonitor::kWidth, BreathMonitor::kHeight, monitor.rgba().data(),
                                monitor.revision()};
}

std::vector<render::Mark> makeMarks(const std::vector<Wound>& wounds, render::Look look,
                                    const Vec3& field_reference_m) {
    std::vector<render::Mark> marks;
    if (look == render::Look::closed)
        marks.push_back({render::MarkKind::iodine, field_reference_m, kField_m, {0.0, 0.0, 1.0}});
    for (const Wound& wound : wounds)
        marks.push_back({kWoundMarks[std::size_t(wound.kind)], wound.reference_m, wound.size_m, wound.along});
    return marks;
}

SceneMaker::SceneMaker(const patient::Patient& patient, const patient::PlannedPath& path,
                       const OperativeField& field, render::Look look, const PressInput& press,
                       const training::DifficultyRules& rules)
    : patient_(&patient),
      path_(path),
      field_(field),
      stage_from_patient_(trainer::stageFromPatient(patient, field)),
      look_(look),
      tick_s_(press.tick_s),
      rules_(rules),
      places_(patient, path, press.tools.guide),
      press_(patient, press) {}

render::RenderScene SceneMaker::makeScene(const FrameState& seen) {
    const haptics::TickOutput& shown = seen.tick;
    monitor_.update(tick_s_ * double(shown.tick), shown.breath, shown.breath_held, seen.progress.pain);
    render::RenderScene scene;
    scene.stage_from_patient = stage_from_patient_;
    scene.stage_from_patient.position_m = stage_from_patient_ * shown.patient_moved_m;
    scene.breath = shown.breath;
    scene.look = rules_.open_look ? look_ : render::Look::closed;
    scene.marks = makeMarks(seen.wounds, scene.look, field_.entry_reference_m);
    scene.tool = press_.shown(shown);
    addRoom(scene, field_, seen.equipment.xray);
    scene.room.lamp_lit = !seen.lights_out;
    if (rules_.colours) scene.room.shell_light = shellLight(seen.glow);
    if (seen.lights_out) scene.room.shell_light *= kLightsOut;
    showTools(scene, seen);
    scene.tubes = accessTubes(shown, seen.access, patient_->package().motion, seen.needle.length_m);
    showMonitor(scene, monitor_);
    showGhost(scene, seen, patient_->package().motion);
    if (rules_.next_step)
        scene.highlights = places_.highlights(training::nextAct(seen.progress, shown, seen.equipment), seen);
    if (!rules_.path) return scene;
    const patient::MotionModel& model = patient_->package().motion;
    scene.reference_path_m = {patient::deformedFromReference(model, shown.breath, path_.entry_reference_m),
                              patient::deformedFromReference(model, shown.breath, path_.target_reference_m)};
    return scene;
}

ImagingInput makeImagingInput(const FrameState& seen, const render::RenderScene& scene,
                              const render::Renderer& renderer, const patient::ContrastTable* contrast,
                              const haptics::GuideSettings& guide, double tick_s) {
    ImagingInput m = makeImagingInput(seen.tick, seen.needle, guide, tick_s);
    m.probe = seen.probe;
    m.tool = scene.tool;
    m.tubes = scene.tubes;
    m.depots = seen.depots;
    m.contrast = contrast;
    m.patient_from_isocentre = renderer.patientFromIsocentre(scene);
    m.equipment = seen.equipment, m.dose = seen.dose;
    return m;
}

}  // namespace stylet::trainer
