#include "app/trainer/view/notice.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace stylet::trainer {
namespace {

// Checks the size of the notice text and its panel in several headsets. The font size (one em) must be at
// least 0.4 degrees and 20 pixels. The panel must be less than 50 degrees wide, so that it does not fill the
// view.
TEST(Notice, CanBeReadInEveryHeadset) {
    struct Headset {
        const char* name;
        double width_px, left_deg, right_deg;
    };
    for (const Headset& h :
         {Headset{"Valve Index", 2468, -51.98, 51.53}, Headset{"Meta Quest 3", 2064, -54, 44},
          Headset{"narrow and coarse, as the demo's", 640, -35.5, 28.6},
          Headset{"as fine as the eye", 6000, -45, 45}}) {
        SCOPED_TRACE(h.name);
        const double degree = std::numbers::pi / 180.0;
        const double px_per_rad =
            h.width_px / (std::tan(h.right_deg * degree) - std::tan(h.left_deg * degree));
        const double letter = letterAngle_rad(px_per_rad);
        EXPECT_GE(letter, 0.4 * degree * (1.0 - 1e-12));
        EXPECT_GE(letter * px_per_rad, 20.0 * (1.0 - 1e-12));
        const double width_m = NoticePanel::width_m(1.0, letter);
        EXPECT_NEAR(width_m * NoticePanel::kLetter_px / NoticePanel::kWidth, std::tan(letter), 1e-12);
        EXPECT_LT(2.0 * std::atan(0.5 * width_m), 50.0 * degree);
    }
}

TEST(Notice, SaysWhyTheAttemptDoesNotGoOn) {
    Seen seen;
    seen.tick.stage = haptics::ForceStage::on;
    EXPECT_FALSE(noticeOf(seen, Attention::focused, "press Enter"));
    EXPECT_FALSE(noticeOf(seen, Attention::absent, "press Enter"));
    EXPECT_EQ(noticeOf(seen, Attention::away, "")->title, "Paused");
    seen.held = true, seen.to_return_m = 0.0123;
    EXPECT_NE(noticeOf(seen, Attention::focused, "")->lines[0].find("12 mm"), std::string::npos);
    seen.to_return_m = haptics::kNotThere_m;
    EXPECT_NE(noticeOf(seen, Attention::focused, "")->lines[0].find("not tracked"), std::string::npos);
    seen.held = false;
    seen.tick.stage = haptics::ForceStage::off;
    seen.tick.faults = haptics::kFaultOverSpeed;
    EXPECT_FALSE(noticeOf(seen, Attention::focused, "")) << "a script cannot re-arm";
    const Notice fault = *noticeOf(seen, Attention::focused, "press Enter");
    EXPECT_NE(fault.lines[0].find("1 m/s"), std::string::npos) << fault.lines[0];
    EXPECT_NE(fault.lines[1].find("press Enter"), std::string::npos);
    EXPECT_NE(noticeOf(RoomDoubt::lost, "press Enter").lines[1].find("stylet register"), std::string::npos);
    EXPECT_NE(noticeOf(RoomDoubt::moved, "press Enter").lines[0].find("press Enter"), std::string::npos);
}

// The longest notices fit the panel: no bright pixels touch its lower edge.
TEST(Notice, FitsItsPanel) {
    NoticePanel panel;
    for (const haptics::FaultText& fault : haptics::faultTexts()) {
        Seen seen;
        seen.tick.stage = haptics::ForceStage::off;
        seen.tick.faults = fault.bit;
        const auto notice = noticeOf(seen, Attention::focused, "the device's first button, or Enter here,");
        if (fault.bit == haptics::kFaultRingFull) continue;
        panel.show(*notice);
        for (std::size_t y = NoticePanel::kHeight - 12; y < NoticePanel::kHeight; ++y)
            for (std::size_t x = 0; x < NoticePanel::kWidth; ++x)
                ASSERT_LT(panel.rgba()[4 * (y * NoticePanel::kWidth + x)], 60) << fault.name;
    }
    const std::uint64_t revision = panel.revision();
    panel.show(noticeOf(RoomDoubt::lost, ""));
    EXPECT_EQ(panel.revision(), revision + 1);
    panel.show(noticeOf(RoomDoubt::lost, ""));
    EXPECT_EQ(panel.revision(), revision + 1) << "drawn only when it is another one";
}

}  // namespace
}  // namespace stylet::trainer
