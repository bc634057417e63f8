// Renders the screens of the ultrasound machine and the C-arm. Pictures that nobody views are not computed.
// Frame thread.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/trainer/session/imaging_input.h"
#include "app/trainer/view/equipment_screens.h"
#include "patient/contrast/vessel_flow.h"
#include "render/render.h"

namespace stylet::trainer {

inline double msSince(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

struct EquipmentTotals {
    std::uint64_t scans = 0, frozen = 0, still_scans = 0;  // ultrasound
    std::uint64_t xray_pictures = 0, unseen = 0;           // unseen: skipped because nobody viewed the screen
    double ultrasound_ms = 0.0, xray_ms = 0.0;             // sums of wall time
    EquipmentTotals& operator+=(const EquipmentTotals&);
};

class EquipmentPictures {
  public:
    // Reads assets/ultrasound. Throws DataError. GPU resources are created with the first picture.
    EquipmentPictures(const render::Gpu&, render::DeformedPatient&, const std::filesystem::path& assets);
    ~EquipmentPictures();

    // Updates those screens that `seen` marks as visible.
    void show(const ImagingInput&, const render::VisibleScreens& seen);

    // Width 0 before the first picture.
    render::ScreenPicture ultrasoundScreen() const { return ultrasound_screen_.shown(); }
    render::ScreenPicture xrayScreen() const { return xray_screen_.shown(); }
    // Writes NAME_ultrasound.png and NAME_xray.png, each only if there is a picture. Throws
    // DataError.
    void save(const std::filesystem::path& folder, const std::string& name) const;
    const EquipmentTotals& totals() const { return totals_; }

  private:
    void pose(const ImagingInput&);
    // Throws DataError.
    const render::Transducer& transducerFor(const UltrasoundProbe&);
    void scan(const ImagingInput&);
    void expose(const ImagingInput&);

    const render::Gpu* gpu_;
    render::DeformedPatient* patient_;
    std::filesystem::path ultrasound_assets_;
    UltrasoundProbe probe_;
    std::optional<render::Transducer> transducer_;  // of `probe_`; loaded with the first picture
    render::AcousticTable acoustics_;
    std::optional<render::Ultrasound> ultrasound_;
    std::optional<render::Fluoroscopy> fluoroscopy_;
    std::optional<patient::VesselFlow> flow_;  // created for the first Doppler picture
    std::vector<render::XrayShape> shapes_;
    UltrasoundScreen ultrasound_screen_;
    XrayScreen xray_screen_;
    UltrasoundReadout readout_;
    render::UltrasoundSettings scanned_as_;
    std::uint64_t scanned_ = 0;
    bool was_idle_ = false;
    ImagingInput pulse_;  // state at the last X-ray pulse
    XrayReadout xray_readout_;
    std::string_view xray_reason_;
    std::optional<std::uint64_t> shown_pulses_;  // XrayState::pulses of the picture on the screen
    double last_scan_s_ = -1.0;
    bool ultrasound_broken_ = false, xray_broken_ = false;
    EquipmentTotals totals_;
};

}  // namespace stylet::trainer
