#include "app/trainer/window/metrics.h"

#include <gtest/gtest.h>

#include "app/trainer/window/mirror_feed.h"

namespace stylet::trainer {
namespace {

using haptics::Tool;

StateUpdate pressedWith(Tool tool, double force_n) {
    StateUpdate state;
    state.seen.tick.tool = tool;
    if (haptics::isNeedleTool(tool))
        state.seen.tick.force_n = force_n;
    else
        state.seen.tick.tool_force.force_n = {0.0, 0.6 * force_n, 0.8 * force_n};
    return state;
}

std::vector<std::uint8_t> drawn(const StateUpdate& state) {
    constexpr int kWidth = 400, kHeight = 300;
    report::Canvas canvas(kWidth, kHeight, {});
    Metrics().draw(canvas, kWidth, kHeight, state, true);
    std::vector<std::uint8_t> rgba;
    canvas.pixels(rgba);
    return rgba;
}

// The numbers and their curve show the force of the tool in hand, as the guide panel does.
TEST(Metrics, TheForceIsThatOfTheToolInHand) {
    for (const Tool tool : {Tool::finger, Tool::probe, Tool::needle, Tool::dilator}) {
        EXPECT_NE(drawn(pressedWith(tool, 3.05)), drawn(pressedWith(tool, 0.0)))
            << haptics::kToolNames[std::size_t(tool)];
        MirrorChannels channels;
        publishState(channels, pressedWith(tool, 3.05));
        FrameSample sample;
        ASSERT_TRUE(channels.samples.pop(sample));
        EXPECT_NEAR(sample.force_n, 3.05, 1e-12) << haptics::kToolNames[std::size_t(tool)];
        EXPECT_EQ(sample.other_n, sample.force_n) << "no second segmentation";
    }
}

// Only a needle's force is compared on a second segmentation.
TEST(Metrics, AFingerHasNoForceOnAnotherSegmentation) {
    for (const Tool tool : {Tool::finger, Tool::needle}) {
        StateUpdate state = pressedWith(tool, 3.0);
        state.seen.truth.known = true;
        state.seen.truth.partial_n = 2.5;
        MirrorChannels channels;
        publishState(channels, state);
        FrameSample sample;
        ASSERT_TRUE(channels.samples.pop(sample));
        EXPECT_EQ(sample.other_n, tool == Tool::needle ? 2.5 : sample.force_n);
    }
}

}  // namespace
}  // namespace stylet::trainer
