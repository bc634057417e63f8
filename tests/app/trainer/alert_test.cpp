#include "app/trainer/alert.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace stylet::trainer {
namespace {

using training::Struck;

Seen at(double t_s) {
    Seen seen;
    seen.tick.tick = std::uint64_t(t_s * 1000.0 + 0.5);
    return seen;
}

std::uint8_t alphaAt(const AlertPicture& picture, int x, int y) {
    return picture.rgba()[4 * std::size_t(y * AlertPicture::kSize + x) + 3];
}

TEST(AlertWatch, SaysWhatIsStruckForAsLongAndAMomentLonger) {
    AlertWatch watch(0.001);
    EXPECT_FALSE(watch.take(at(0.9)));
    Seen struck = at(1.0);
    struck.progress.striking = Struck::vessel;
    EXPECT_EQ(watch.take(struck), Alert{Struck::vessel});
    EXPECT_EQ(watch.take(at(1.0 + 0.9 * kAlertLeast_s)), Alert{Struck::vessel});
    EXPECT_FALSE(watch.take(at(1.0 + 1.1 * kAlertLeast_s)));
}

TEST(AlertWatch, TheTargetIsReachedOnceAndAStrikeGoesBeforeIt) {
    AlertWatch watch(0.001);
    Seen reached = at(2.0);
    reached.progress.success = true;
    EXPECT_EQ(watch.take(reached), Alert{});
    reached.tick.tick += 10, reached.progress.striking = Struck::lung;
    EXPECT_EQ(watch.take(reached), Alert{Struck::lung});
    reached.progress.striking = Struck::nothing;
    reached.tick.tick = std::uint64_t(1000 * (2.0 + kReached_s));
    EXPECT_FALSE(watch.take(reached));
}

TEST(AlertPicture, TheMiddleIsFreeAndTheBorderIsNot) {
    AlertPicture picture;
    picture.show({Struck::vessel});
    const int middle = AlertPicture::kSize / 2, edge = 3;
    for (const int offset : {-120, -60, 0, 60, 120}) {
        EXPECT_EQ(alphaAt(picture, middle + offset, middle), 0);
        EXPECT_EQ(alphaAt(picture, middle, middle + offset), 0);
        EXPECT_GT(alphaAt(picture, edge, middle + offset), 120);
        EXPECT_GT(alphaAt(picture, middle + offset, edge), 120);
    }
}

// Who sees no colours sees stripes or dots.
TEST(AlertPicture, PatternsDifferWithoutTheirColours) {
    AlertPicture struck, reached;
    struck.show({Struck::bone});
    reached.show({});
    int changes = 0, others = 0;
    const auto bright = [](const AlertPicture& picture, int y) {
        const std::size_t at = 4 * std::size_t(y * AlertPicture::kSize + 4);
        return picture.rgba()[at] + picture.rgba()[at + 2];
    };
    for (int y = 1; y < AlertPicture::kSize; ++y) {
        changes += std::abs(bright(struck, y) - bright(struck, y - 1)) > 20;
        others += std::abs(bright(reached, y) - bright(reached, y - 1)) > 20;
    }
    EXPECT_GT(changes, 10);
    EXPECT_NE(changes, others);
}

TEST(AlertPicture, IsDrawnOnceForEach) {
    AlertPicture picture;
    for (int i = 0; i < 5; ++i)
        picture.show({Struck::vessel});
    EXPECT_EQ(picture.revision(), 1u);
    picture.show({Struck::bone});
    EXPECT_EQ(picture.revision(), 2u);
}

}  // namespace
}  // namespace stylet::trainer
