#include "app/trainer/view/equipment_screens.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

namespace stylet::trainer {
namespace {

constexpr report::Colour kScreenBlack{0.0, 0.0, 0.0}, kScreenWords{0.78, 0.83, 0.86},
    kScreenQuiet{0.45, 0.51, 0.55}, kColumn{0.035, 0.045, 0.055}, kLive{0.98, 0.78, 0.16},
    kHeld{0.35, 0.85, 1.0}, kProbeMark{0.36, 0.67, 0.73};

// Minutes and seconds, such as "4:07".
std::string minutes(double seconds) {
    const long whole = std::lround(std::max(0.0, seconds));
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

// Names the side on which the detector is, as angiography systems do: the patient's left or right, the head
// or the feet.
std::string angle(double rad, const char* positive, const char* negative) {
    const long deg = std::lround(rad * 57.29577951308232);
    return fmt::format("{}\u00b0 {}", std::labs(deg), deg < 0 ? negative : positive);
}

}  // namespace

render::ScreenPicture EquipmentScreen::shown() const {
    if (revision_ == 0) return {};
    return {kWidth, kHeight, rgba_.data(), revision_};
}

void EquipmentScreen::begin(const render::ScreenPicture& picture, double width, double left, double pitch) {
    width_ = width, left_ = left, pitch_ = pitch, next_line_ = 46.0;
    canvas_.rectangle(0, 0, kWidth, kHeight, kScreenBlack);
    if (width < kWidth) canvas_.rectangle(width, 0, kWidth - width, kHeight, kColumn);
    if (picture.width == 0 || !picture.rgba) return;
    const std::size_t pixels = std::size_t(picture.width) * std::size_t(picture.height);
    rgb_.resize(3 * pixels);
    for (std::size_t i = 0; i < pixels; ++i)
        std::copy_n(picture.rgba + 4 * i, 3, rgb_.data() + 3 * i);
    const double scale = std::min(width / picture.width, double(kHeight) / picture.height);
    canvas_.clip(0, 0, width, kHeight);
    canvas_.image(0.5 * (width - scale * picture.width), 0.5 * (kHeight - scale * picture.height),
                  picture.width, picture.height, rgb_, scale);
    canvas_.unclip();
}

void EquipmentScreen::badge(const std::string& text, const report::Colour& colour) {
    canvas_.text({left_, 24.0}, text, {17, colour, report::Align::left, true});
}

void EquipmentScreen::line(const std::string& what, const std::string& value) {
    canvas_.text({left_, next_line_}, what, {10.5, kScreenQuiet});
    canvas_.text({left_, next_line_ + 13.0}, value, {13, kScreenWords});
    next_line_ += pitch_;
}

void EquipmentScreen::notice(std::string_view text) {
    canvas_.text({0.5 * width_, 0.55 * kHeight}, std::string(text),
                 {17, kScreenWords, report::Align::centre});
}

void EquipmentScreen::end() {
    canvas_.pixels(rgba_);
    ++revision_;
}

void UltrasoundScreen::draw(const render::ScreenPicture& picture, const UltrasoundReadout& r) {
    begin(picture, kWidth, 10.0, 27.0);
    notice(r.reason);
    badge(r.frozen ? "FROZEN" : "LIVE", r.frozen ? kHeld : kLive);
    line(r.probe, fmt::format("{:.1f} MHz", 1e-6 * r.frequency_hz));
    line("depth", fmt::format("{:.0f} cm", 100.0 * r.depth_m));
    line("gain", fmt::format("{:+.0f} dB", r.gain_db));
    if (r.doppler) line("colour", fmt::format("\u00b1{:.0f} cm/s", 100.0 * r.nyquist_m_per_s));
    // The left of the picture is the side of the probe that has the ridge and the needle guide. The mark has
    // the guide's colour.
    canvas_.disc({0.23 * kWidth, 18.0}, 6.0, kProbeMark);
    // The TGC sliders, from the skin down.
    constexpr double kMiddle = kWidth - 46.0, kReach = 34.0, kMax_db = 20.0;
    canvas_.text({kMiddle, 22.0}, "TGC", {10.5, kScreenQuiet, report::Align::centre});
    for (std::size_t i = 0; i < r.tgc_db.size(); ++i) {
        const double y = 32.0 + 10.0 * double(i);
        canvas_.line({kMiddle - kReach, y}, {kMiddle + kReach, y}, 1.0, kScreenQuiet.faded(0.5));
        canvas_.disc({kMiddle + kReach * std::clamp(r.tgc_db[i] / kMax_db, -1.0, 1.0), y}, 3.0, kScreenWords);
    }
    end();
}

void XrayScreen::draw(const render::ScreenPicture& picture, const XrayReadout& r) {
    begin(picture, kPicture, kPicture + 12.0, 36.0);
    notice(r.reason);
    badge(r.live ? "X-RAY ON" : "LIH", r.live ? kLive : kHeld);
    line("rotation", angle(r.arm.orbital_rad, "LAO", "RAO"));
    line("angulation", angle(r.arm.angulation_rad, "CRA", "CAU"));
    line("pulses", fmt::format("{:.1f} /s", r.pulse_rate_hz));
    line("fluoroscopy", minutes(r.fluoroscopy_s));
    line("dose area", fmt::format("{:.2f} Gy cm\u00b2", 1e4 * r.dose_area_gy_m2));
    line("contrast", fmt::format("{:.1f} ml", 1e6 * r.contrast_m3));
    end();
}

}  // namespace stylet::trainer
