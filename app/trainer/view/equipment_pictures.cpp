#include "app/trainer/view/equipment_pictures.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "app/trainer/stores/console.h"

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr double kSpeed_m_per_s = 1540.0;
constexpr int kFinePixels = 384, kCoarsePixels = 256;  // edge of the X-ray picture: on a GPU; on a processor

render::UltrasoundSettings settingsOf(const training::UltrasoundState& machine) {
    render::UltrasoundSettings s;
    s.depth_m = machine.depth_m;
    s.frequency_hz = machine.frequency_hz;
    s.focus_m = machine.focus_m;
    s.gain_db = machine.gain_db;
    std::copy(machine.tgc_db.begin(), machine.tgc_db.end(), s.tgc_db.begin());
    s.freeze = machine.freeze;
    if (machine.doppler) s.doppler = {.from_share = 0.25, .to_share = 0.75, .from_m = 0.03, .to_m = 0.12};
    s.width = UltrasoundScreen::kWidth, s.height = UltrasoundScreen::kHeight;
    return s;
}

// Runs `work` and returns true if it throws. The caller then switches that machine off; the room and the
// other machine are not affected.
template <typename Work>
bool fails(const char* machine, const Work& work) {
    try {
        work();
        return false;
    } catch (const std::runtime_error& e) {
        printMessage(fmt::format("no {} pictures: {}", machine, e.what()));
        return true;
    }
}

}  // namespace

EquipmentTotals& EquipmentTotals::operator+=(const EquipmentTotals& more) {
    scans += more.scans, frozen += more.frozen, still_scans += more.still_scans;
    xray_pictures += more.xray_pictures, unseen += more.unseen;
    ultrasound_ms += more.ultrasound_ms, xray_ms += more.xray_ms;
    return *this;
}

EquipmentPictures::EquipmentPictures(const render::Gpu& gpu, render::DeformedPatient& patient,
                                     const std::filesystem::path& assets)
    : gpu_(&gpu),
      patient_(&patient),
      ultrasound_assets_(assets / "ultrasound"),
      acoustics_(render::loadAcoustics(ultrasound_assets_ / "tissues.toml")) {}

EquipmentPictures::~EquipmentPictures() = default;

void EquipmentPictures::show(const ImagingInput& m, const render::VisibleScreens& seen) {
    totals_.unseen += (seen.ultrasound ? 0u : 1u) + (seen.xray ? 0u : 1u);
    if (m.equipment.xray.pulses != pulse_.equipment.xray.pulses) {
        pulse_ = m;
        if (!seen.xray) pulse_.tool = nullptr;  // the table will be outdated when the pulse is drawn
    }
    if (!seen.ultrasound && !seen.xray) return;
    pose(m);
    if (seen.ultrasound && !ultrasound_broken_) ultrasound_broken_ = fails("ultrasound", [&] { scan(m); });
    if (seen.xray && !xray_broken_) xray_broken_ = fails("X-ray", [&] { expose(m); });
}

void EquipmentPictures::pose(const ImagingInput& m) {
    patient_->breathe(m.breath, patient_->atRest(m.breath));
    patient_->press(m.tool);
}

void EquipmentPictures::save(const std::filesystem::path& folder, const std::string& name) const {
    if (scanned_ > 0) ultrasound_screen_.savePng(folder / (name + "_ultrasound.png"));
    if (shown_pulses_) xray_screen_.savePng(folder / (name + "_xray.png"));
}

const render::Transducer& EquipmentPictures::transducerFor(const UltrasoundProbe& probe) {
    if (!transducer_ || probe_ != probe) {
        transducer_ =
            render::withFace(render::loadTransducer(ultrasound_assets_ / (probe.transducer + ".toml")),
                             probe.length_m, probe.curvature_m);
        probe_ = probe;
    }
    return *transducer_;
}

void EquipmentPictures::scan(const ImagingInput& m) {
    if (scanned_ == 0 && !m.patient_from_probe) return;  // the probe was never used
    const training::UltrasoundState& machine = m.equipment.ultrasound;
    const render::UltrasoundSettings settings = settingsOf(machine);
    // Duration of a scan: for each line, sound travels to the largest depth and back.
    const double scan_s = settings.lines * 2.0 * settings.depth_m / kSpeed_m_per_s;
    if (scanned_ > 0 && m.time_s >= last_scan_s_ && m.time_s < last_scan_s_ + scan_s) return;
    // A frozen picture or a probe in the air gives no new picture.
    const bool idle = settings.freeze || !m.patient_from_probe;
    if (idle && was_idle_ && settings == scanned_as_) return;
    last_scan_s_ = m.time_s, was_idle_ = idle, scanned_as_ = settings;
    if (!ultrasound_) ultrasound_.emplace(*gpu_, *patient_, acoustics_);
    if (machine.doppler && !flow_) {
        flow_ = patient::makeVesselFlow(patient_->patient());
        ultrasound_->setFlow(&*flow_);
    }
    const render::Transducer& transducer = transducerFor(m.probe);
    const auto begin = SteadyClock::now();
    render::UltrasoundInput input;
    input.patient_from_probe = m.patient_from_probe;
    input.patient_from_needle = m.patient_from_needle;
    input.needle = m.needle;
    input.tubes = m.tubes;
    for (const patient::Stain& depot : m.depots)
        input.depots.push_back({depot.centre_m, patient::depotRadius_m(depot.volume_m3)});
    input.guide_m = m.guide_m;
    input.time_s = m.time_s;
    input.number = scanned_;
    const render::UltrasoundStats stats = ultrasound_->image(input, settings, transducer);
    totals_.ultrasound_ms += msSince(begin);
    ++scanned_;
    if (stats.reason.empty() && stats.frozen_pictures == 0) ++totals_.scans;
    totals_.frozen += stats.frozen_pictures;
    totals_.still_scans += stats.still_pictures;
    if (stats.frozen_pictures == 0) {  // a frozen picture keeps the settings it was scanned with
        readout_.probe = transducer.name;
        readout_.depth_m = machine.depth_m;
        readout_.frequency_hz =
            std::clamp(machine.frequency_hz, transducer.lowest_frequency_hz, transducer.highest_frequency_hz);
        readout_.doppler = machine.doppler;
        readout_.nyquist_m_per_s = settings.doppler ? settings.doppler->nyquist_m_per_s : 0.0;
    }
    readout_.gain_db = machine.gain_db;
    readout_.tgc_db = machine.tgc_db;
    readout_.frozen = machine.freeze;
    readout_.reason = stats.reason;
    ultrasound_screen_.draw(ultrasound_->picture(), readout_);
}

// If a pulse occurs while nobody views the screen, it is drawn when somebody does. Its picture shows the
// state at the pulse, but with the current contrast medium.
void EquipmentPictures::expose(const ImagingInput& m) {
    if (m.equipment.xray.pulses == 0) return;
    const training::XrayState& machine = pulse_.equipment.xray;
    const render::CArm arm{machine.rotation_rad, machine.angulation_rad};
    if (shown_pulses_ != machine.pulses) {
        if (!fluoroscopy_) fluoroscopy_.emplace(*gpu_, *patient_);
        if (pulse_.breath != m.breath || pulse_.tool != m.tool) pose(pulse_);
        shapes_.clear();
        if (pulse_.patient_from_needle)
            render::addNeedle(*pulse_.patient_from_needle, pulse_.needle, true, shapes_);
        if (pulse_.patient_from_probe)
            render::addProbe(*pulse_.patient_from_probe * haptics::kStylusFromProbe.inverse(),
                             pulse_.probe.length_m, shapes_);
        if (pulse_.patient_from_scalpel) render::addScalpel(*pulse_.patient_from_scalpel, shapes_);
        if (pulse_.patient_from_finger) render::addFinger(*pulse_.patient_from_finger, shapes_);
        for (const CurvedTube& tube : pulse_.tubes)
            render::addTube(tube, shapes_);
        const double half_m = 0.5 * machine.field_m;
        render::FluoroscopySettings settings;
        settings.pixels = gpu_->isSoftware() ? kCoarsePixels : kFinePixels;
        settings.pulse_rate_hz = machine.pulses_per_s;
        const auto begin = SteadyClock::now();
        const render::FluoroscopyStats stats =
            fluoroscopy_->image({.arm = arm,
                                 .patient_from_isocentre = pulse_.patient_from_isocentre,
                                 .collimation = {half_m, half_m, half_m, half_m},
                                 .pedal = true,
                                 .time_s = double(machine.pulses) / machine.pulses_per_s,
                                 .shapes = shapes_,
                                 .contrast = m.contrast},
                                settings);
        totals_.xray_ms += msSince(begin);
        if (stats.live) ++totals_.xray_pictures;
        xray_reason_ = stats.reason;
    }
    // Rounded to the digits on the screen: smaller changes do not redraw it.
    const auto whole = [](double value, double step) { return step * std::round(value / step); };
    const XrayReadout now{.arm = arm,
                          .pulse_rate_hz = m.equipment.xray.pulses_per_s,
                          .fluoroscopy_s = whole(m.dose.fluoroscopy_s, 1.0),
                          .dose_area_gy_m2 = whole(m.dose.dose_area_gy_m2, 1e-6),
                          .contrast_m3 = whole(m.dose.contrast_m3, 1e-7),
                          .live = m.equipment.xray.pedal,
                          .reason = xray_reason_};
    if (shown_pulses_ == machine.pulses && now == xray_readout_) return;
    shown_pulses_ = machine.pulses;
    xray_readout_ = now;
    xray_screen_.draw(fluoroscopy_->picture(), now);
}

}  // namespace stylet::trainer
