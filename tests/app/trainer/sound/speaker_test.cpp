// Tests the audible output: the samples that OpenAL renders into its loopback device.
#include "app/trainer/sound/speaker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <numbers>
#include <thread>

#include "app/trainer/sound/sounds.h"

namespace stylet::trainer {
namespace {

constexpr double kStep_s = 0.01;
constexpr std::size_t kStepFrames = std::size_t(kClipRate_hz / 100);

using Stereo = std::vector<float>;

// RMS of one ear's channel.
double rms(const Stereo& samples, std::size_t ear) {
    double sum = 0.0;
    for (std::size_t i = ear; i < samples.size(); i += 2)
        sum += double(samples[i]) * double(samples[i]);
    return std::sqrt(2.0 * sum / double(samples.size()));
}

// Amplitude of a tone (Goertzel).
double toneIn(const Stereo& samples, double hz) {
    double c = 0.0, s = 0.0;
    for (std::size_t i = 0; i < samples.size(); i += 2) {
        const double phase = 2.0 * std::numbers::pi * hz * double(i / 2) / kClipRate_hz;
        c += double(samples[i]) * std::cos(phase), s += double(samples[i]) * std::sin(phase);
    }
    return 4.0 * std::hypot(c, s) / double(samples.size());
}

class Loopback : public testing::Test {
  protected:
    Stereo render(double seconds) {
        Stereo all;
        for (double t_s = 0.0; t_s < seconds - 1e-9; t_s += kStep_s) {
            Stereo part(2 * kStepFrames);
            speaker_.play(heard_);
            heard_.begun = 0;
            speaker_.render(part);
            all.insert(all.end(), part.begin(), part.end());
        }
        return all;
    }
    void begin(Sound sound, float gain, const Vec3& at) {
        heard_[sound] = {gain, 1.0f, at};
        heard_.begun |= soundBit(sound);
    }

    Speaker speaker_ = Speaker::loopback();
    SoundFrame heard_;  // listener at the origin, looking along -z
};

TEST_F(Loopback, SilenceWithoutSounds) {
    const Stereo silence = render(0.2);
    EXPECT_EQ(rms(silence, 0) + rms(silence, 1), 0.0);
}

TEST_F(Loopback, TheBeepComesAtItsRate) {
    int begun = 0, onsets = 0;
    double before = 0.0;
    for (double t_s = 0.0; t_s < 5.0; t_s += kStep_s) {
        if (std::floor((t_s + kStep_s) * 1.2) > std::floor(t_s * 1.2)) {
            begin(Sound::beep, 0.5f, {0.0, 0.0, -1.0});
            ++begun;
        }
        const double now = toneIn(render(kStep_s), 880.0);
        onsets += before < 0.05 && now >= 0.05;
        before = now;
    }
    EXPECT_EQ(begun, 6);
    EXPECT_EQ(onsets, begun);
}

TEST_F(Loopback, TheBuzzOnlyWhileItIsOn) {
    EXPECT_EQ(rms(render(0.1), 0), 0.0);
    heard_[Sound::buzz] = {0.5f, 1.0f, {0.0, 0.0, -1.0}};
    EXPECT_GT(toneIn(render(0.5), 120.0), 0.02);
    heard_[Sound::buzz].gain = 0.0f;
    render(0.1);
    EXPECT_EQ(rms(render(0.2), 0), 0.0);
}

TEST_F(Loopback, SourcesArePannedLeftAndRight) {
    begin(Sound::chime, 0.5f, {-1.5, 0.0, -0.5});
    const Stereo left = render(0.3);
    EXPECT_GT(rms(left, 0), 2.0 * rms(left, 1));
    render(2.0);
    // The same source position, heard after the listener has turned around.
    speaker_.listen({Quat(0.0, 0.0, 1.0, 0.0), {}});
    begin(Sound::chime, 0.5f, {-1.5, 0.0, 0.5});
    const Stereo turned = render(0.3);
    EXPECT_GT(rms(turned, 1), 2.0 * rms(turned, 0));
}

TEST_F(Loopback, FartherIsQuieter) {
    begin(Sound::chime, 0.5f, {0.0, 0.0, -1.0});
    const double near = rms(render(0.3), 0);
    render(2.0);
    begin(Sound::chime, 0.5f, {0.0, 0.0, -4.0});
    EXPECT_NEAR(rms(render(0.3), 0) / near, 0.25, 0.05);
}

// Plays every sound at its largest gain, at the listener's position, for as long as the longest clip.
// HZ-USER-03
TEST_F(Loopback, AllSoundsTogetherDoNotClip) {
    const Pose here{Quat(1.0, 0.0, 0.0, 0.0), {}};
    SoundFrame loudest;
    float sum = 0.0f;
    for (int i = 0; i < kSoundCount; ++i) {
        loudest.voices[std::size_t(i)] = {loudestGain(Sound(i)), 1.0f, here.position_m};
        sum += loudestGain(Sound(i));
        loudest.begun |= soundBit(Sound(i));
    }
    EXPECT_LE(sum, 1.0f);
    heard_ = loudest;
    for (const float s : render(2.0)) {
        ASSERT_TRUE(std::isfinite(s));
        ASSERT_LT(std::fabs(s), 1.0f);
    }
}

// A cue is audible in the next block that is mixed.
TEST_F(Loopback, CueStartsInTheNextBlock) {
    render(0.1);
    begin(Sound::click, 0.5f, {0.0, 0.0, -1.0});
    const Stereo block = render(kStep_s);
    const auto first = std::find_if(block.begin(), block.end(), [](float s) { return std::fabs(s) > 0.01f; });
    ASSERT_NE(first, block.end());
    EXPECT_LT(double(first - block.begin()) / 2.0 / kClipRate_hz, 0.003);
}

struct Lines {
    std::mutex mutex;
    std::vector<std::string> said;
    std::promise<void> first;
    Sounds::Say say() {
        return [this](const std::string& text) {
            const std::lock_guard lock(mutex);
            said.push_back(text);
            if (said.size() == 1) first.set_value();
        };
    }
};

TEST(Sounds, MissingDeviceIsReportedOnce) {
    Lines lines;
    auto told = lines.first.get_future();
    {
        Sounds sounds({}, nullptr, []() -> Speaker { throw SoundError("no device"); }, lines.say());
        told.wait();
        SoundFrame heard;
        heard.begun = soundBit(Sound::beep);
        for (int i = 0; i < 100; ++i)
            sounds.submit(heard);
        EXPECT_EQ(sounds.totals().begun, 0u);
    }
    EXPECT_EQ(lines.said,
              std::vector<std::string>{"no sound: no device; the attempt continues without sound"});
}

TEST(Sounds, StartedSoundIsPlayedOnce) {
    Sounds sounds({}, nullptr, Speaker::loopback, [](const std::string& text) { ADD_FAILURE() << text; });
    SoundFrame heard;
    for (std::uint64_t i = 1; i <= 5; ++i) {
        heard.begun = soundBit(Sound::click);
        sounds.submit(heard);
        heard.begun = 0;
        sounds.submit(heard);  // must not cancel the click
        while (sounds.totals().begun < i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(sounds.totals().begun, 5u);
    EXPECT_FALSE(sounds.totals().device.empty());
}

// Uses OpenAL Soft's driver that writes to a file, on a full disk. The device then fails during playback,
// like a device that is unplugged.
TEST(SoundsDeathTest, ADeviceThatIsLostEndsTheSoundOnly) {
    const std::filesystem::path conf = std::filesystem::path(testing::TempDir()) / "lost-device.conf";
    std::ofstream(conf) << "drivers = wave\n[wave]\nfile = /dev/full\n";
    setenv("ALSOFT_CONF", conf.c_str(), 1);
    // Runs in a separate process, because the library reads its settings only once.
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(
        {
            Lines lines;
            auto told = lines.first.get_future();
            Sounds sounds({}, nullptr, Speaker::device, lines.say());
            SoundFrame heard;
            heard[Sound::room].gain = 0.1f;
            while (told.wait_for(std::chrono::milliseconds(5)) != std::future_status::ready)
                sounds.submit(heard);
            sounds.submit(heard);
            const std::lock_guard lock(lines.mutex);
            std::fprintf(stderr, "%s\n", lines.said.at(0).c_str());
            std::_Exit(sounds.totals().device.empty() ? 0 : 1);
        },
        testing::ExitedWithCode(0), "the sound device was lost; the attempt continues without sound");
}

}  // namespace
}  // namespace stylet::trainer
