// Screens of the ultrasound machine and the X-ray monitor. Each has a picture and text beside it. Frame
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "app/report/canvas.h"
#include "render/scene/scene.h"

namespace stylet::trainer {

class EquipmentScreen {
  public:
    static constexpr int kWidth = 512, kHeight = 384;

    EquipmentScreen() : canvas_(kWidth, kHeight, {0.0, 0.0, 0.0}) {}
    render::ScreenPicture shown() const;  // valid until the next draw; width 0 before the first
    void savePng(const std::filesystem::path& file) const { canvas_.savePng(file); }

  protected:
    // Draws the picture centred in the first `width` columns. Text lines start at x = `left`, `pitch`
    // pixels apart.
    void begin(const render::ScreenPicture&, double width, double left, double pitch);
    void badge(const std::string&, const report::Colour&);
    void line(const std::string& what, const std::string& value);
    void notice(std::string_view);  // text in the middle of the picture
    void end();

    report::Canvas canvas_;

  private:
    std::vector<std::uint8_t> rgb_, rgba_;
    double width_ = kWidth, left_ = 0.0, pitch_ = 20.0, next_line_ = 0.0;
    std::uint64_t revision_ = 0;
};

struct UltrasoundReadout {
    std::string probe;
    double depth_m = 0.0, frequency_hz = 0.0, gain_db = 0.0;
    std::array<double, 8> tgc_db{};  // gains in order of depth, from the skin down
    bool doppler = false, frozen = false;
    double nyquist_m_per_s = 0.0;
    std::string_view reason;  // why there is no picture
};
// Screen with the text in the corners, which the fan-shaped picture leaves black.
class UltrasoundScreen : public EquipmentScreen {
  public:
    void draw(const render::ScreenPicture&, const UltrasoundReadout&);
};

struct XrayReadout {
    render::CArm arm;
    double pulse_rate_hz = 0.0, fluoroscopy_s = 0.0, dose_area_gy_m2 = 0.0, contrast_m3 = 0.0;
    bool live = false;  // radiation is on
    std::string_view reason;
    friend bool operator==(const XrayReadout&, const XrayReadout&) = default;
};
class XrayScreen : public EquipmentScreen {
  public:
    static constexpr int kPicture = kHeight;  // edge of the square picture at the left [px]
    void draw(const render::ScreenPicture&, const XrayReadout&);
};

}  // namespace stylet::trainer
