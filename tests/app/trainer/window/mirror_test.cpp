// The instructor's window on an X server without a screen, beside a headset of the mock runtime.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/attempt/tool_pose.h"
#include "app/trainer/display/frames.h"
#include "app/trainer/window/layout.h"
#include "app/trainer/window/mirror.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wait_until.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using SteadyClock = std::chrono::steady_clock;
using test::Screenshot;

constexpr int kWidth = 900, kHeight = 600, kEyePixels = 192;

FrameState outside() {
    FrameState seen;
    seen.tick.patient_from_needle.position_m = {-0.01, 0.0, 0.0};
    seen.tick.tool_awaits_exit = false;
    return seen;
}

bool until(const std::function<bool()>& done) {
    return test::waitUntil(done, 120s, 10);
}

// Mean values of boxes in a grid over `part` of a picture. They hardly change if the picture is scaled.
std::vector<double> boxes(const std::uint8_t* rgb, int stride, const Rect& part, int count) {
    std::vector<double> means;
    for (int j = 0; j < count; ++j)
        for (int i = 0; i < count; ++i)
            for (int c = 0; c < 3; ++c) {
                double sum = 0.0;
                int pixels = 0;
                for (int y = part.y + j * part.height / count; y < part.y + (j + 1) * part.height / count;
                     ++y)
                    for (int x = part.x + i * part.width / count; x < part.x + (i + 1) * part.width / count;
                         ++x)
                        sum += rgb[std::size_t(3 * (y * stride + x) + c)], ++pixels;
                means.push_back(sum / pixels);
            }
    return means;
}

double psnrOfGreys_db(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return 10.0 * std::log10(255.0 * 255.0 * double(a.size()) / std::max(sum, 1e-9));
}

double spread(const std::vector<double>& values) {
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    return *most - *least;
}

Rect findPane(WindowView view, int width = kWidth, int height = kHeight) {
    return computeLayout(view, WindowView::leftEye, width, height).panes[0].area;
}
// Area of an eye's picture.
Rect eyeIn(WindowView view, int width = kWidth, int height = kHeight) {
    return fitted(findPane(view, width, height), kEyePixels, kEyePixels);
}

class MirrorTest : public testing::Test {
  protected:
    void SetUp() override {
        std::signal(SIGPIPE, SIG_IGN);  // as the program does: a display may close its end
        settings_.pictures.assets = std::getenv("STYLET_ASSETS");
        settings_.pictures.config.validation = true;
        settings_.pictures.field = flankField(patient_);
        settings_.pictures.config.difficulties = test::difficulties();
        settings_.pictures.config.difficulty = training::Difficulty::exam;  // no hints
        settings_.width = kWidth, settings_.height = kHeight;
    }
    void open() { mirror_.emplace(patient_, path_, settings_); }
    // A headset with a fixed head pose.
    void putOn() {
        json head = json::array();
        const Pose pose = stageFromHead(stageFromPatient(patient_, fieldOf(path_)), fieldOf(path_), 0.0);
        const auto& [q, at] = pose;
        head.push_back({{"t_s", 0}, {"position", {at.x, at.y, at.z}}, {"orientation", {q.x, q.y, q.z, q.w}}});
        std::ofstream(folder_ / "scenario.json") << json{
            {"version", 2}, {"eyes", {{"recommended_size", {kEyePixels, kEyePixels}}}}, {"head", head}};
        setenv("XRMOCK_SCENARIO", (folder_ / "scenario.json").c_str(), 1);
        setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
        PictureSettings frames;
        frames.field = fieldOf(path_);
        frames.config.difficulties = test::difficulties();
        frames.assets = settings_.pictures.assets;
        frames.config.fast = true;
        frames.config.validation = true;
        frames.config.folder = folder_.path();
        frames_.emplace(patient_, frames, path_);
        if (mirror_) frames_->mirrorTo(mirror_->channels());
    }
    void TearDown() override {
        frames_.reset();
        mirror_.reset();
        unsetenv("XRMOCK_SCENARIO");
    }
    void show(int frames, const std::string& moment = "") {
        for (int i = 0; i < frames; ++i) {
            seen_.tick.tick += 11;
            ASSERT_TRUE(frames_->frame(seen_, nullptr, i + 1 == frames ? moment : ""));
        }
    }
    std::vector<double> captured(const std::string& file) const {
        int width = 0, height = 0, channels = 0;
        const std::unique_ptr<stbi_uc, void (*)(void*)> rgb(
            stbi_load((folder_ / file).c_str(), &width, &height, &channels, 3), stbi_image_free);
        EXPECT_EQ(width, kEyePixels) << file;
        return rgb ? boxes(rgb.get(), width, {0, 0, width, height}, 32) : std::vector<double>(32 * 32 * 3);
    }
    std::vector<double> shown(const Rect& part) const {
        const Screenshot shot = display_->shot();
        if (part.x + part.width > shot.width || part.y + part.height > shot.height)
            return std::vector<double>(32 * 32 * 3);
        return boxes(shot.rgb.data(), shot.width, part, 32);
    }
    // Renders frames until `done` returns true.
    bool showUntil(const std::function<bool()>& done) {
        return until([&] { return show(1), done(); });
    }

    std::optional<test::XDisplay> display_{std::in_place, 1280, 1024};
    const patient::Package package_ = test::ductPhantom();
    const patient::Patient patient_{package_};
    const patient::PlannedPath path_ = test::ductPath();
    test::TempFolder folder_;
    MirrorSettings settings_;
    FrameState seen_ = outside();
    std::optional<Mirror> mirror_;
    std::optional<FrameLoop> frames_;
};

// HZ-TEACH-04
TEST_F(MirrorTest, ItShowsTheEyeThatTheHeadsetShows) {
    open();
    putOn();
    display_->key("1");
    ASSERT_TRUE(until([&] { return display_->title() == "Stylet \u2013 left eye"; })) << display_->title();
    show(6, "seen");
    const std::vector<double> left = captured("seen_left.png"), right = captured("seen_right.png");
    ASSERT_GT(spread(left), 50.0);
    EXPECT_TRUE(showUntil([&] { return psnrOfGreys_db(shown(eyeIn(WindowView::leftEye)), left) > 36.0; }))
        << psnrOfGreys_db(shown(eyeIn(WindowView::leftEye)), left);
    EXPECT_LT(psnrOfGreys_db(left, right), 30.0);
    display_->key("2");
    EXPECT_TRUE(showUntil([&] { return psnrOfGreys_db(shown(eyeIn(WindowView::rightEye)), right) > 36.0; }))
        << psnrOfGreys_db(shown(eyeIn(WindowView::rightEye)), right);
    // Also at other window sizes.
    for (const auto& [width, height] : {std::pair{1200, 500}, {500, 900}}) {
        display_->resize(width, height);
        EXPECT_TRUE(showUntil([&] {
            return psnrOfGreys_db(shown(eyeIn(WindowView::rightEye, width, height)), right) > 34.0;
        })) << width
            << " x " << height;
    }
    frames_.reset();
    EXPECT_TRUE(until([&] { return mirror_->shown() > 3; }));
    EXPECT_EQ(mirror_->validationMessages(), 0u);
}

TEST_F(MirrorTest, KeysSelectViewsAndTheTitleNamesThem) {
    open();
    const char* const names[] = {"left eye", "right eye", "free camera", "ultrasound",
                                 "X-ray",    "metrics",   "overview",    "slices"};
    const auto reads = [&](const std::string& name) {
        return until([&] { return display_->title() == "Stylet \u2013 " + name; });
    };
    EXPECT_TRUE(reads("overview"));
    for (int i = 0; i < 8; ++i) {
        display_->key(std::to_string(i + 1));
        EXPECT_TRUE(reads(names[i])) << display_->title();
    }
    display_->key("Tab");
    EXPECT_TRUE(reads("left eye"));
    display_->key("Tab");
    EXPECT_TRUE(reads("right eye"));
    display_->key("9");
    EXPECT_TRUE(reads("right eye"));
}

// The trainee's alerts also appear in the window. A strike is shown around the eye's picture, which stays
// unchanged. A key opens the guide. In an exam, neither is shown.
TEST_F(MirrorTest, AlertSurroundsTheTraineesView) {
    settings_.pictures.config.difficulty = training::Difficulty::practice;
    open();
    putOn();
    display_->key("1");
    show(6, "seen");
    const Rect pane = findPane(WindowView::leftEye);
    const int edge = std::min(pane.width, pane.height) / 28;
    const Rect above{pane.x, pane.y, pane.width, edge},
        inside = fitted({pane.x + edge, pane.y + edge, pane.width - 2 * edge, pane.height - 2 * edge},
                        kEyePixels, kEyePixels);
    const std::vector<double> left = captured("seen_left.png");
    ASSERT_TRUE(showUntil([&] { return psnrOfGreys_db(shown(inside), left) > 34.0; }));
    // Means of boxes along the strip. There are fewer boxes than rows.
    const auto strip = [&] {
        const Screenshot shot = display_->shot();
        if (above.x + above.width > shot.width || above.y + above.height > shot.height)
            return std::vector<double>(3 * 8 * 8);
        return boxes(shot.rgb.data(), shot.width, above, 8);
    };
    const auto mean = [&](std::size_t channel) {
        const std::vector<double> means = strip();
        double sum = 0.0;
        for (std::size_t i = channel; i < means.size(); i += 3)
            sum += means[i];
        return 3.0 * sum / double(means.size());
    };
    EXPECT_LT(mean(0), 60.0) << "nothing is struck";
    seen_.progress.current_risk = training::RiskStructure::vessel;
    EXPECT_TRUE(showUntil([&] { return mean(0) > mean(1) + 60.0 && mean(0) > mean(2) + 60.0; }));
    EXPECT_GT(psnrOfGreys_db(shown(inside), left), 34.0) << "the picture stays free";
    const Screenshot struck = display_->shot();
    int changes = 0;  // changes between light and dark along the strip's middle
    for (int x = above.x + 1; x < above.x + above.width; ++x) {
        const auto light = [&](int at) {
            return struck.rgb[std::size_t(3 * ((above.y + above.height / 2) * struck.width + at) + 1)] > 45;
        };
        changes += light(x) != light(x - 1);
    }
    EXPECT_GT(changes, above.width / 24) << "stripes";
    seen_.progress.current_risk = training::RiskStructure::nothing, seen_.progress.success = true;
    seen_.tick.tick += 1000;
    EXPECT_TRUE(showUntil([&] { return mean(1) > mean(0) + 40.0 && mean(1) > mean(2) + 40.0; }));
    seen_.tick.tick += 10'000;
    EXPECT_TRUE(showUntil([&] { return mean(1) < 60.0; }));

    display_->key("9");
    ASSERT_TRUE(until([&] { return display_->title() == "Stylet \u2013 guide"; })) << display_->title();
    const Rect guide = findPane(WindowView::guide);
    EXPECT_TRUE(showUntil([&] { return spread(shown(guide)) > 60.0; }));
    EXPECT_EQ(mirror_->validationMessages(), 0u);
}

// The overview shows the equipment's pictures although the trainee looks at neither screen.
TEST_F(MirrorTest, OverviewShowsEquipmentThatNobodyInTheHeadsetSees) {
    open();
    putOn();
    seen_.tick.probe_parked = true;
    seen_.tick.patient_from_probe = needlePose({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}) * haptics::kStylusFromProbe;
    seen_.equipment.xray.pedal = true;
    seen_.equipment.xray.pulses = 3;
    const Layout layout = computeLayout(WindowView::overview, WindowView::leftEye, kWidth, kHeight);
    for (const WindowView view : {WindowView::ultrasound, WindowView::xray}) {
        const auto pane = std::ranges::find(layout.panes, view, &Pane::shows);
        ASSERT_NE(pane, layout.panes.end());
        // A text in place of a picture is dark grey.
        EXPECT_TRUE(showUntil([&] { return spread(shown(pane->area)) > 90.0; })) << nameOf(view);
    }
    EXPECT_GT(frames_->totals().equipment.unseen, 0u) << "not in every frame";
}

TEST_F(MirrorTest, WindowIsNotLargerThanTheScreen) {
    display_.emplace(1000, 700);
    settings_.width = 1440, settings_.height = 900;
    open();
    ASSERT_TRUE(until([&] { return !display_->title().empty(); }));
    EXPECT_TRUE(until([&] {
        const Screenshot shot = display_->shot();
        return shot.width == 1000 && shot.height == 700;
    }));
}

// The instructor pressed the key in the window, so the answer appears there.
TEST_F(MirrorTest, AnAnswerAppearsBelowThePictures) {
    open();
    putOn();
    display_->key("1");
    ASSERT_TRUE(until([&] { return display_->title() == "Stylet \u2013 left eye"; })) << display_->title();
    const std::uint64_t presented = mirror_->shown();
    ASSERT_TRUE(showUntil([&] { return mirror_->shown() > presented + 1; }));
    const Rect keys = computeLayout(WindowView::leftEye, WindowView::leftEye, kWidth, kHeight).keys;
    ASSERT_GT(keys.height, 8);
    const auto line = [&] {
        const Screenshot shot = display_->shot();
        if (keys.x + keys.width > shot.width || keys.y + keys.height > shot.height)
            return std::vector<double>(3 * 8 * 8);
        return boxes(shot.rgb.data(), shot.width, keys, 8);
    };
    ASSERT_TRUE(showUntil([&] { return spread(line()) > 5.0; }));
    const std::vector<double> before = line();
    seen_.answer = "instructor: bleed: no hole is in the skin";
    EXPECT_TRUE(showUntil([&] { return psnrOfGreys_db(line(), before) < 35.0; }))
        << psnrOfGreys_db(line(), before);
    seen_.answer.clear();
    EXPECT_TRUE(showUntil([&] { return psnrOfGreys_db(line(), before) > 60.0; }));
}

TEST_F(MirrorTest, TheFreeCameraTurnsWithTheMouse) {
    open();
    putOn();
    show(4);
    display_->key("3");
    const Rect pane = findPane(WindowView::camera);
    ASSERT_TRUE(showUntil([&] { return spread(shown(pane)) > 50.0; }));
    show(2);
    std::vector<double> before = shown(pane);
    double still_db = 0.0;  // similarity of two pictures that the window presented one after the other
    EXPECT_TRUE(until([&] {
        const std::uint64_t presented = mirror_->shown();
        if (!until([&] { return show(1), mirror_->shown() > presented + 1; })) return false;
        const std::vector<double> next = shown(pane);
        still_db = psnrOfGreys_db(std::exchange(before, next), next);
        return still_db > 32.0;
    }));
    display_->drag(300, 300, 550, 250);
    EXPECT_TRUE(until([&] { return psnrOfGreys_db(before, shown(pane)) < 24.0; })) << still_db;
    display_->key("r");
    EXPECT_TRUE(until([&] { return psnrOfGreys_db(before, shown(pane)) > 32.0; }));
    EXPECT_EQ(mirror_->validationMessages(), 0u);
}

TEST_F(MirrorTest, ClosingTheWindowDoesNotStopFrames) {
    open();
    putOn();
    show(4);
    EXPECT_TRUE(mirror_->channels().open.load());
    ASSERT_TRUE(until([&] { return !display_->title().empty(); }));
    display_->close();
    EXPECT_TRUE(until([&] { return !mirror_->channels().open.load(); }));
    show(4);
    EXPECT_TRUE(until([&] { return display_->title().empty(); })) << display_->title();
    EXPECT_EQ(frames_->totals().validation_messages, 0u);
}

TEST_F(MirrorTest, MissingDisplayIsReported) {
    display_.reset();
    try {
        open();
        FAIL() << "a window opened";
    } catch (const WindowError& e) {
        EXPECT_THAT(std::string(e.what()), testing::HasSubstr("no display")) << e.what();
    }
}

// Needs real time: a display that stops answering must not delay the frames.
using MirrorRealTime = MirrorTest;

// Must be the last test, because a process opens no other window after its display has stopped answering.
TEST_F(MirrorRealTime, StuckWindowDelaysNoFrame) {
    open();
    putOn();
    show(3);
    const auto slowest = [&](int frames) {
        double most_ms = 0.0;
        for (int i = 0; i < frames; ++i) {
            const auto begin = SteadyClock::now();
            show(1);
            most_ms = std::max(most_ms,
                               std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count());
        }
        return most_ms;
    };
    const double going_ms = slowest(10);
    ASSERT_TRUE(showUntil([&] { return mirror_->shown() > 0; }));
    const std::uint64_t before = mirror_->shown();
    display_->stop();
    const std::uint64_t rendered = frames_->totals().rendered;
    int frames = 0;
    double stuck_ms = 0.0;
    // Five consecutive frames must be as fast as before. If a frame waited for the display, it would be among
    // them. Repeat if the machine itself stalled.
    EXPECT_TRUE(until([&] {
        frames += 5;
        stuck_ms = slowest(5);
        return frames >= 20 && stuck_ms < 2.0 * going_ms + 200.0;
    })) << stuck_ms
        << " ms, before " << going_ms;
    RecordProperty("slowest_frame_ms", std::to_string(going_ms));
    RecordProperty("slowest_frame_beside_a_stuck_window_ms", std::to_string(stuck_ms));
    EXPECT_EQ(frames_->totals().rendered, rendered + std::uint64_t(frames));
    EXPECT_LE(mirror_->shown(), before + 3) << "the window was not stuck";
    // The window resumes.
    display_->resume();
    const std::uint64_t after = mirror_->shown();
    EXPECT_TRUE(showUntil([&] { return mirror_->shown() > after + 3; }));
    display_->stop();
    show(10);
    // Closing the window does not wait either, although the display still does not answer.
    const auto begin = SteadyClock::now();
    frames_.reset();
    mirror_.reset();
    EXPECT_LT(SteadyClock::now() - begin, 60s);
    RecordProperty("end_beside_a_stuck_window_ms",
                   std::to_string((SteadyClock::now() - begin) / std::chrono::milliseconds(1)));
    display_->resume();
}

}  // namespace
}  // namespace stylet::trainer
