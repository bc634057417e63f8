#include "app/trainer/display/player.h"

#include <gtest/gtest.h>

#include "app/trainer/display/replay_show.h"

namespace stylet::trainer {
namespace {

TEST(Player, PlaysAtItsSpeedAndStopsAtTheEnd) {
    Player player(10.0);
    player.advance(1.0);
    EXPECT_EQ(player.state().at_s, 0.0);
    player.execute("toggle\n");
    player.advance(1.0);
    EXPECT_DOUBLE_EQ(player.state().at_s, 1.0);
    player.execute("speed 0.5\n");
    player.advance(1.0);
    EXPECT_DOUBLE_EQ(player.state().at_s, 1.5);
    player.execute("speed 16\n");
    player.advance(5.0);
    EXPECT_EQ(player.state().at_s, 10.0);
    EXPECT_FALSE(player.state().plays);
    player.execute("toggle\n");  // starts again at the beginning
    EXPECT_EQ(player.state().at_s, 0.0);
    EXPECT_TRUE(player.state().plays);
}

TEST(Player, IsScrubbedWithinItsLength) {
    Player player(8.0);
    player.execute("seek 0.25\nskip 1\n");
    EXPECT_DOUBLE_EQ(player.state().at_s, 3.0);
    player.execute("skip -100\n");
    EXPECT_EQ(player.state().at_s, 0.0);
    player.execute("seek 7\n");
    EXPECT_EQ(player.state().at_s, 8.0);
}

TEST(Player, IgnoresUnknownCommands) {
    Player player(8.0);
    for (const char* line : {"seek\n", "seek nan\n", "skip inf\n", "skip 1x\n", "speed 0\n", "speed -2\n",
                             "probe\n", "\n", " \n"})
        player.execute(line);
    EXPECT_EQ(player.state().at_s, 0.0);
    EXPECT_EQ(player.state().speed, 1.0);
    for (int i = 0; i < 20; ++i)
        player.execute("speed 2\n");
    EXPECT_EQ(player.state().speed, Player::kFastest);
}

TEST(TimelineTest, FindsTheNewestStateAndStaysWithinItsLimit) {
    for (const std::size_t ticks : {10u, 5000u, 1000000u}) {
        Timeline timeline(ticks);
        std::size_t kept = 0;
        for (std::uint64_t tick = 1; tick <= ticks; ++tick)
            timeline.add(tick, [&] {
                ++kept;
                FrameState seen;
                seen.tick.tick = tick;
                return seen;
            });
        EXPECT_LE(kept, Timeline::kMaxStates + 2);
        EXPECT_EQ(timeline.at(0.0).tick.tick, 1u);
        const std::uint64_t last = timeline.at(1e12).tick.tick;
        EXPECT_LE(ticks - last, ticks / Timeline::kMaxStates + 5);
        EXPECT_LE(timeline.at(double(ticks) / 2.0).tick.tick, ticks / 2);
    }
}

TEST(PlayerStick, ScrubSpeedGrowsWithDeflection) {
    PlayerStick stick;
    Player player(100.0);
    const auto pushed = [&](float right, double s) {
        const double before = player.state().at_s;
        for (int i = 0; i < int(100 * s); ++i)
            player.execute(stick.update(0, {right, 0.0f}, 0.01));
        return player.state().at_s - before;
    };
    player.execute("toggle\n");
    EXPECT_EQ(pushed(0.2f, 1.0), 0.0) << "a thumb at rest";
    EXPECT_TRUE(player.state().plays);
    EXPECT_NEAR(pushed(1.0f, 1.0), PlayerStick::kFastest_s, 1e-3);
    EXPECT_FALSE(player.state().plays) << "it stands where it is let go";
    const double slow_s = pushed(0.5f, 1.0);
    EXPECT_GT(slow_s, 0.5);
    EXPECT_LT(slow_s, 0.3 * PlayerStick::kFastest_s);
    EXPECT_NEAR(pushed(-0.5f, 1.0), -slow_s, 1e-3);
}

TEST(PlayerStick, AFlickChangesTheSpeedOnceAndAPressCountsOnce) {
    PlayerStick stick;
    Player player(100.0);
    const auto takes = [&](std::uint32_t buttons, float up, int times = 3) {
        for (int i = 0; i < times; ++i)
            player.execute(stick.update(buttons, {0.0f, up}, 0.01));
    };
    takes(1u, 0.0f);
    EXPECT_FALSE(player.state().plays) << "what is held as it begins was not pressed";
    takes(0u, 0.0f), takes(1u, 0.0f);
    EXPECT_TRUE(player.state().plays);
    takes(0u, 0.9f), takes(0u, 0.5f), takes(0u, 0.9f);
    EXPECT_EQ(player.state().speed, 2.0) << "not let go between";
    takes(0u, 0.0f), takes(0u, -0.9f), takes(0u, 0.0f), takes(0u, -0.9f);
    EXPECT_EQ(player.state().speed, 0.5);
    player.execute("seek 0.5\n");
    takes(4u, 0.0f);
    EXPECT_NEAR(player.state().at_s, 50.0 - PlayerStick::kBack_s, 1e-3);
    takes(0u, 0.0f), takes(2u, 0.0f);
    EXPECT_EQ(player.state().at_s, 0.0);
}

}  // namespace
}  // namespace stylet::trainer
