#include "app/trainer/player.h"

#include <gtest/gtest.h>

#include "app/trainer/replay_show.h"

namespace stylet::trainer {
namespace {

TEST(Player, PlaysAtItsSpeedAndStopsAtTheEnd) {
    Player player(10.0);
    player.pass(1.0);
    EXPECT_EQ(player.state().at_s, 0.0);
    player.hear("toggle\n");
    player.pass(1.0);
    EXPECT_DOUBLE_EQ(player.state().at_s, 1.0);
    player.hear("speed 0.5\n");
    player.pass(1.0);
    EXPECT_DOUBLE_EQ(player.state().at_s, 1.5);
    player.hear("speed 16\n");
    player.pass(5.0);
    EXPECT_EQ(player.state().at_s, 10.0);
    EXPECT_FALSE(player.state().plays);
    player.hear("toggle\n");  // from the begin again
    EXPECT_EQ(player.state().at_s, 0.0);
    EXPECT_TRUE(player.state().plays);
}

TEST(Player, IsScrubbedWithinItsLength) {
    Player player(8.0);
    player.hear("seek 0.25\nskip 1\n");
    EXPECT_DOUBLE_EQ(player.state().at_s, 3.0);
    player.hear("skip -100\n");
    EXPECT_EQ(player.state().at_s, 0.0);
    player.hear("seek 7\n");
    EXPECT_EQ(player.state().at_s, 8.0);
}

TEST(Player, PassesOverWhatIsNoWordOfIts) {
    Player player(8.0);
    for (const char* line : {"seek\n", "seek nan\n", "skip inf\n", "skip 1x\n", "speed 0\n", "speed -2\n",
                             "probe\n", "\n", " \n"})
        player.hear(line);
    EXPECT_EQ(player.state().at_s, 0.0);
    EXPECT_EQ(player.state().speed, 1.0);
    for (int i = 0; i < 20; ++i)
        player.hear("speed 2\n");
    EXPECT_EQ(player.state().speed, Player::kFastest);
}

TEST(TimelineTest, GivesTheNewestAtATickAndKeepsNoMoreThanItMay) {
    for (const std::size_t ticks : {10u, 5000u, 1000000u}) {
        Timeline timeline(ticks);
        std::size_t kept = 0;
        for (std::uint64_t tick = 1; tick <= ticks; ++tick)
            timeline.take(tick, [&] {
                ++kept;
                Seen seen;
                seen.tick.tick = tick;
                return seen;
            });
        EXPECT_LE(kept, Timeline::kMost + 2);
        EXPECT_EQ(timeline.at(0.0).tick.tick, 1u);
        const std::uint64_t last = timeline.at(1e12).tick.tick;
        EXPECT_LE(ticks - last, ticks / Timeline::kMost + 5);
        EXPECT_LE(timeline.at(double(ticks) / 2.0).tick.tick, ticks / 2);
    }
}

}  // namespace
}  // namespace stylet::trainer
