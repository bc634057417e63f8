#include "app/trainer/sound/clips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stylet::trainer {
namespace {

double largestStep(const std::vector<float>& clip) {
    double most = 0.0;
    for (std::size_t i = 1; i < clip.size(); ++i)
        most = std::max(most, std::fabs(double(clip[i]) - double(clip[i - 1])));
    return most;
}

TEST(Clips, ArePeakedAndFinite) {
    for (int i = 0; i < kSoundCount; ++i) {
        const std::vector<float> clip = makeClip(Sound(i));
        float most = 0.0f;
        for (const float s : clip) {
            ASSERT_TRUE(std::isfinite(s)) << "sound " << i;
            most = std::max(most, std::fabs(s));
        }
        EXPECT_NEAR(most, kClipPeak, 1e-3) << "sound " << i;
        EXPECT_GT(clip.size(), std::size_t(kClipRate_hz) / 50) << "sound " << i;
    }
}

TEST(Clips, AreTheSameEveryTime) {
    EXPECT_EQ(makeClip(Sound::room), makeClip(Sound::room));
    EXPECT_EQ(makeClip(Sound::cut), makeClip(Sound::cut));
}

// A step at the loop's seam is audible as a click if it is larger than every step inside the clip.
TEST(Clips, LoopsHaveNoSeam) {
    for (int i = 0; i < kLoopCount; ++i) {
        const std::vector<float> clip = makeClip(Sound(i));
        EXPECT_LE(std::fabs(double(clip.front()) - double(clip.back())), largestStep(clip)) << "sound " << i;
    }
}

TEST(Clips, OthersBeginAndEndAtRest) {
    for (int i = kLoopCount; i < kSoundCount; ++i) {
        const std::vector<float> clip = makeClip(Sound(i));
        EXPECT_LT(std::fabs(clip.front()), 0.02f) << "sound " << i;
        EXPECT_LT(std::fabs(clip.back()), 0.02f) << "sound " << i;
    }
}

}  // namespace
}  // namespace stylet::trainer
