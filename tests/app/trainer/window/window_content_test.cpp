#include "app/trainer/window/window_content.h"

#include <gtest/gtest.h>

namespace stylet::trainer {
namespace {

// The pedal decides, not the age of the picture: the machine shows the last image after the pedal is
// released.
TEST(ScreenCaption, XrayIsLiveOnlyWhileThePedalIsPressed) {
    training::Equipment equipment;
    equipment.xray.pedal = true;
    EXPECT_EQ(screenCaption(WindowView::xray, equipment, 0.1), "X-ray \u00b7 live");
    equipment.xray.pedal = false;
    EXPECT_EQ(screenCaption(WindowView::xray, equipment, 0.1), "X-ray \u00b7 last image held");
}

TEST(ScreenCaption, AFrozenUltrasoundIsNotLive) {
    training::Equipment equipment;
    EXPECT_EQ(screenCaption(WindowView::ultrasound, equipment, 0.1), "ultrasound \u00b7 live");
    equipment.ultrasound.freeze = true;
    EXPECT_EQ(screenCaption(WindowView::ultrasound, equipment, 0.1), "ultrasound \u00b7 frozen");
}

// Whoever looked at it: instructor and trainee see the same picture.
TEST(ScreenCaption, AnOldPictureHasItsAge) {
    training::Equipment equipment;
    equipment.xray.pedal = true;
    for (const WindowView view : {WindowView::ultrasound, WindowView::xray}) {
        EXPECT_EQ(screenCaption(view, equipment, 6.2), std::string(nameOf(view)) + " \u00b7 drawn 6 s ago");
        EXPECT_EQ(screenCaption(view, equipment, std::nullopt), nameOf(view));
    }
}

TEST(ScreenCaption, AMissingPictureSaysWhatIsMissing) {
    training::Equipment equipment;
    EXPECT_EQ(missingPictureText(WindowView::ultrasound, equipment), "the probe has not touched yet");
    EXPECT_EQ(missingPictureText(WindowView::xray, equipment), "the pedal has not been pressed yet");
    equipment.xray.pulses = 1;
    EXPECT_EQ(missingPictureText(WindowView::xray, equipment), "preparing \u2026");
}

}  // namespace
}  // namespace stylet::trainer
