#include "app/trainer/session/contrast_feed.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

const Vec3 kInDuct{0.053, 0.0, 0.0}, kInLiver{0.030, 0.0, 0.0};
constexpr double kMl = 1e-6;

// Injects into the duct for one second, and into the liver after that.
void injectTick(patient::Contrast& contrast, int i) {
    contrast.step({i < 1000 ? kInDuct : kInLiver, 0.5 * kMl, true}, 0.001);
}

double shown_m3(const patient::ContrastTable& table) {
    double sum = 0.0;
    for (const float v : table.added_per_m)
        sum += double(v);
    return sum * patient::voxelVolume_m3(table.grid) / 75.0;
}

TEST(ContrastFeed, UpdatesTheTableHoweverRarelyItIsApplied) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    for (const int every : {1, 33, 700, 5000}) {
        patient::Contrast contrast(patient);
        ContrastFeed feed({0.0});
        patient::ContrastTable table;
        EXPECT_FALSE(feed.applyTo(table));
        for (int i = 0; i < 2000; ++i) {
            injectTick(contrast, i);
            if (i % 2 == 1) feed.publish(contrast);
            if (i % every == 0) feed.applyTo(table);
        }
        feed.applyTo(table);
        EXPECT_FALSE(feed.applyTo(table)) << "nothing new";
        const patient::ContrastVolumes& v = contrast.volumes();
        EXPECT_NEAR(shown_m3(table), v.ducts_m3 + v.liver_m3, 0.001 * kMl) << every;
    }
}

// This test is also run with the thread sanitizer.
TEST(ContrastFeed, IsSafeFromTwoThreads) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    patient::Contrast contrast(patient);
    ContrastFeed feed({0.0});
    std::atomic<bool> done{false};
    std::thread session([&] {
        for (int i = 0; i < 2000; ++i) {
            injectTick(contrast, i);
            if (i % 10 == 9) feed.publish(contrast);
        }
        done.store(true);
    });
    patient::ContrastTable table;
    std::uint64_t last = 0;
    while (!done.load()) {
        feed.applyTo(table);
        EXPECT_GE(table.revision, last);
        last = table.revision;
    }
    session.join();
    feed.applyTo(table);
    const patient::ContrastVolumes& v = contrast.volumes();
    EXPECT_NEAR(shown_m3(table), v.ducts_m3 + v.liver_m3, 0.001 * kMl);
}

}  // namespace
}  // namespace stylet::trainer
