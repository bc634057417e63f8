// Shows a record in the window and scrubs back and forth. Its capture points look the same as in the attempt.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <memory>
#include <thread>

#include <gtest/gtest.h>
#include <stb/stb_image.h>

#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/support/wait_until.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using test::Outcome;
using test::Screenshot;

double psnrOfBytes_db(const std::uint8_t* a, const std::uint8_t* b, std::size_t count) {
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i)
        sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return 10.0 * std::log10(255.0 * 255.0 * double(count) / std::max(sum, 1e-9));
}

double psnrOfFiles_db(const std::filesystem::path& a, const std::filesystem::path& b) {
    int size[2][3];
    const auto load = [](const std::filesystem::path& file, int* s) {
        return std::unique_ptr<stbi_uc, void (*)(void*)>(stbi_load(file.c_str(), &s[0], &s[1], &s[2], 3),
                                                         stbi_image_free);
    };
    const auto first = load(a, size[0]), second = load(b, size[1]);
    if (!first || !second || size[0][0] != size[1][0] || size[0][1] != size[1][1]) return 0.0;
    return psnrOfBytes_db(first.get(), second.get(), std::size_t(3) * std::size_t(size[0][0] * size[0][1]));
}

// PSNR of the large picture in the left half of the window.
double psnrOfShots_db(const Screenshot& a, const Screenshot& b) {
    if (a.width != b.width || a.height != b.height || a.rgb.empty()) return 0.0;
    std::vector<std::uint8_t> parts[2];
    for (int y = a.height / 12; y < a.height * 2 / 5; ++y)
        for (int x = 40; x < a.width / 2; ++x)
            for (int c = 0; c < 3; ++c) {
                const std::size_t at = std::size_t(3 * (y * a.width + x) + c);
                parts[0].push_back(a.rgb[at]), parts[1].push_back(b.rgb[at]);
            }
    return psnrOfBytes_db(parts[0].data(), parts[1].data(), parts[0].size());
}

class ReplayShow : public testing::Test {
  protected:
    bool until(const std::function<bool()>& done, std::chrono::seconds most = 300s) const {
        return test::waitUntil(done, most, 50);
    }
    // Waits for two equal consecutive pictures. On a busy machine even these may be outdated.
    Screenshot still() const {
        Screenshot shot = display_.shot();
        until([&] {
            std::this_thread::sleep_for(700ms);
            Screenshot next = display_.shot();
            const bool same = psnrOfShots_db(shot, next) > 45.0;
            shot = std::move(next);
            return same;
        });
        return shot;
    }
    // Shows the end of the attempt, its start, and its end again. The start must look different, and the end
    // the same.
    bool scrubsThereAndBack() const {
        display_.key("End");  // at the end the needle is outside again or deep inside
        const Screenshot end = still();
        display_.key("space");  // play from the start and stop immediately
        display_.key("space");
        display_.key("Home");
        if (!until([&] { return psnrOfShots_db(display_.shot(), end) < 45.0; }, 20s)) return false;
        still();
        display_.key("End");
        return until([&] { return psnrOfShots_db(display_.shot(), end) > 38.0; }, 20s);
    }

    test::XDisplay display_{1500, 950};
    test::Command command_;
};

// HZ-TEACH-13
TEST_F(ReplayShow, ShowsTheAttemptAndScrubsInBothDirections) {
    command_.set("XR_RUNTIME_JSON", "/nowhere/runtime.json");
    const std::filesystem::path live = command_ / "live", again = command_ / "again";
    const Outcome attempt = command_.runInto(live, "run --fast --fps 1 --spacing-mm 3 --mirror --scenario '" +
                                                       test::testScenario("short").string() + "'");
    ASSERT_EQ(attempt.status, 0) << attempt.err;
    ASSERT_TRUE(until([&] { return display_.title().empty(); }));

    auto shown = std::async(std::launch::async, [&] {
        return command_.runInto(again,
                                "replay --show '" + live.string() + "' --ghost '" + live.string() + "'");
    });
    ASSERT_TRUE(
        until([&] { return !display_.title().empty() || shown.wait_for(0s) == std::future_status::ready; }));
    ASSERT_TRUE(until([&] { return std::filesystem::exists(again / "duct_view.png"); }));
    bool scrubs = false;  // tries again if a picture was older than its key press
    for (int tries = 0; tries < 6 && !scrubs; ++tries)
        scrubs = scrubsThereAndBack();
    EXPECT_TRUE(scrubs);
    display_.close();
    const Outcome outcome = shown.get();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.summary.at("state_hash"), attempt.summary.at("state_hash"));
    // Each capture point is drawn from the state of its tick, so the picture equals that of the attempt.
    for (const std::string moment : {"approach", "skin", "fascia", "liver", "duct"})
        EXPECT_GT(psnrOfFiles_db(live / (moment + "_view.png"), again / (moment + "_view.png")), 35.0)
            << moment;
}

}  // namespace
}  // namespace stylet::trainer
