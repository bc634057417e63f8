#include "app/trainer/session/imaging_input.h"

namespace stylet::trainer {

ImagingInput makeImagingInput(const haptics::TickOutput& tick, const NeedleShape& needle,
                              const haptics::GuideSettings& guide, double tick_s) {
    ImagingInput m;
    m.time_s = tick_s * double(tick.tick);
    m.breath = tick.breath;
    m.needle = needle;
    if (tick.tool == haptics::Tool::probe)
        m.patient_from_probe = tick.patient_from_tool * haptics::kStylusFromProbe;
    if (tick.probe_parked) {
        m.patient_from_probe = tick.patient_from_probe;
        const Pose rail = tick.patient_from_probe * guide.probe_from_guide;
        m.guide_m = {rail.position_m, rail * Vec3(0.0, 0.0, -needle.length_m)};
    }
    if (haptics::isNeedleTool(tick.tool) || tick.access.needle_in)
        m.patient_from_needle = tick.patient_from_needle;
    if (tick.tool == haptics::Tool::scalpel) m.patient_from_scalpel = tick.patient_from_tool;
    if (tick.tool == haptics::Tool::finger) m.patient_from_finger = tick.patient_from_tool;
    return m;
}

}  // namespace stylet::trainer
