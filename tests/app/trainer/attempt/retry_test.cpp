#include "app/trainer/attempt/retry.h"

#include <gtest/gtest.h>

#include <atomic>

#include "app/records/replay.h"
#include "app/trainer/stores/platform_linux.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using haptics::Phase;

records::RecordInfo onTheDuct() {
    records::RecordInfo info;
    info.path = test::ductPath();
    return info;
}

class FromABookmark : public testing::Test {
  protected:
    // Runs an attempt with three bookmarks: in the fat, deep in the liver with the force on, and at the end.
    void SetUp() override {
        const Attempt attempt = makeAttempt(patient_, scenario_, test::ductPath(), 3);
        records::RecordWriter writer(first(), {patient::digest(package_), attempt.simulation}, info_);
        Session session = makeSession(&writer);
        session.setWatcher([&](const haptics::TickOutput& now, const SessionLog& log) {
            if (writer.info().bookmarks.empty() && now.depth_m > 0.010) session.note("bookmark", "fat");
            if (writer.info().bookmarks.size() == 1 && now.depth_m > 0.045) session.note("bookmark", "");
            last_ = log.last_tick;
        });
        runFast(attempt, session, nullptr, 0.0, {});
        session.note("bookmark", "the end");
        writer.finish();
        log_ = session.log();
        ASSERT_EQ(writer.info().bookmarks.size(), 3u);
    }
    std::filesystem::path first() const { return folder_ / "first" / "record"; }
    Session makeSession(records::RecordWriter* writer) {
        return Session(patient_, test::ductPath(), scenario_.moments, scenario_.approach_distance_m, writer);
    }
    Retry retryAt(const std::string& bookmark) {
        Retry retry = openRetry((folder_ / "first").string() + bookmark, folder_ / "store");
        checkRetry(retry, patient_);
        return retry;
    }
    // Continues from the bookmark with the scripted input of `seed`, on the virtual clock.
    SessionLog goOn(const Retry& retry, std::uint64_t seed) {
        Attempt attempt = makeAttempt(patient_, scenario_, test::ductPath(), seed);
        startFromRecord(attempt, retry);
        records::RecordWriter writer(second(), {patient::digest(package_), attempt.simulation}, info_);
        Session session = makeSession(&writer);
        runFast(attempt, session, nullptr, 0.0, {});
        writer.finish();
        return session.log();
    }
    std::filesystem::path second() const { return folder_ / "second" / "record"; }

    test::TempFolder folder_;
    patient::Package package_ = test::ductPhantom();
    patient::Patient patient_{package_};
    Scenario scenario_ = test::shortScenario();
    records::RecordInfo info_ = onTheDuct();
    SessionLog log_;
    std::uint64_t last_ = 0;
};

TEST_F(FromABookmark, SameInputEndsInTheSameState) {
    for (const char* bookmark : {"@1", "@2", "@the end", ""}) {
        const SessionLog again = goOn(retryAt(bookmark), 3);
        EXPECT_EQ(again.state_hash, log_.state_hash) << bookmark;
        EXPECT_EQ(again.ticks, log_.ticks) << bookmark;
        EXPECT_EQ(again.score.total, log_.score.total) << bookmark;
        EXPECT_EQ(again.punctures.size(), log_.punctures.size()) << bookmark;
    }
}

TEST_F(FromABookmark, OtherInputContinuesFromTheRecordedInputs) {
    const Retry retry = retryAt("@2");
    EXPECT_GT(retry.left.depth_m, 0.044);
    const SessionLog again = goOn(retry, 4);
    EXPECT_NE(again.state_hash, log_.state_hash);
    const records::Record record = records::loadRecord(second());
    EXPECT_TRUE(records::replay(patient_, record, {}).equal());
    ASSERT_GT(record.inputs.size(), retry.bookmark.tick);
    for (std::size_t i = 0; i < retry.bookmark.tick; ++i)
        ASSERT_EQ(record.inputs[i].device.device_from_stylus.position_m,
                  retry.record.inputs[i].device.device_from_stylus.position_m)
            << i;
}

// A device that senses only its position.
class Placed final : public haptics::HapticDevice {
  public:
    explicit Placed(const Retry& retry) : left_(retry.record.inputs[retry.bookmark.tick - 1].device) {
        profile_.name = "placed";
        const Vec3 out = retry.left.patient_from_needle.direction({0.0, 0.0, 1.0});
        drawn_back_m_ = retry.record.header.settings.patient_from_device.inverse().direction(
            retry.left.extension_m * out);
    }
    const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
    haptics::DeviceState read(std::int64_t) noexcept STYLET_NONBLOCKING override {
        ++reads;
        haptics::DeviceState state = left_;
        state.fresh = 1;
        state.buttons = 0;
        state.device_from_stylus.position_m += away ? Vec3(0.0, 0.02, 0.0) : drawn_back_m_;
        return state;
    }
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override {
        if (away && force_n != Vec3(0.0)) pushed_away = true;
    }
    std::atomic<bool> away{true}, pushed_away{false};
    std::atomic<int> reads{0};

  private:
    haptics::DeviceState left_;
    haptics::DeviceProfile profile_;
    // The device is withdrawn by the tissue's stretch, so that the force starts at zero.
    Vec3 drawn_back_m_{0.0};
};

// HZ-FORCE-23
TEST_F(FromABookmark, LiveInputResumesAtTheOldPoseWithRisingForce) {
    const Retry retry = retryAt("@2");
    ASSERT_NE(retry.left.phase, Phase::outside);
    ASSERT_EQ(retry.left.level, 1.0);
    Attempt attempt =
        makeLiveAttempt(patient_, scenario_, test::ductPath(), flankField(patient_), {.seed = 3}, {}, {});
    startFromRecord(attempt, retry);
    records::RecordWriter writer(second(), {patient::digest(package_), attempt.simulation}, info_);
    Session session = makeSession(&writer);
    Placed device(retry);
    double level = 1.0, steepest = 0.0;
    std::uint64_t stood_at = 0;
    session.setWatcher([&](const haptics::TickOutput& now, const SessionLog&) {
        if (now.tick <= retry.bookmark.tick) return;
        if (stood_at > 0) steepest = std::max(steepest, now.level - level);
        level = now.level;
    });
    bool back = false;
    std::string words;
    const LiveHand hand{device,
                        [&](double) {
                            if (!back && device.reads > 50) {  // no tick was computed
                                stood_at = session.log().last_tick;
                                EXPECT_EQ(level, 0.0);
                                words = "rearm\n";
                                device.away = false;
                                back = true;
                            }
                            return back && (level > 0.5 || device.reads > 60'000);
                        },
                        [&] { return std::exchange(words, {}); },
                        [](haptics::Tool) {},
                        {},
                        "Enter"};
    std::uint64_t first_seen = 0;
    const auto on_state = [&](const FrameState& seen) {
        if (first_seen == 0) first_seen = seen.tick.tick;
        if (!back) {
            EXPECT_TRUE(seen.ticks_paused);
        }
    };
    runRealTime(attempt, session, nullptr, monotonicClock(), {.live = &hand, .on_state = on_state});
    writer.finish();
    EXPECT_GT(level, 0.5) << "the force did not come back";
    EXPECT_EQ(stood_at, first_seen) << "ticks went on without the hand";
    EXPECT_FALSE(device.pushed_away);
    EXPECT_LE(steepest, 0.001 / haptics::kStartRamp_s * 1.001);
    EXPECT_TRUE(records::replay(patient_, records::loadRecord(second()), {}).equal());
}

TEST_F(FromABookmark, InvalidRequestsAreRefused) {
    const auto refused = [&](const std::string& from, const std::string& file, const std::string& field) {
        test::expectRefused([&] { openRetry((folder_ / from).string(), folder_ / "store"); }, file, field);
    };
    refused("first@4", "record", "bookmark 4: not among: 1 (fat), 2, 3 (the end)");
    refused("first@0", "record", "bookmark 0");
    refused("nowhere", "nowhere", "--from");
    test::expectRefused([&] { openRetry("20260101-1", folder_ / "store"); }, "20260101-1", "--from");

    Retry changed = openRetry((folder_ / "first").string(), folder_ / "store");
    changed.record.inputs[100].device.buttons ^= 1u;
    test::expectRefused([&] { checkRetry(changed, patient_); }, "record", "tick 250");

    Retry torn = openRetry((folder_ / "first").string() + "@1", folder_ / "store");
    patient::Package other = package_;
    other.ct.voxels[5] += 1;
    const patient::Patient stranger(other);
    test::expectRefused([&] { checkRetry(torn, stranger); }, "", "digest");
}

TEST_F(FromABookmark, AttemptIsFoundByFolderRecordOrId) {
    const std::filesystem::path kept = folder_ / "store" / "attempts" / "20260101T000000-abc" / "record";
    std::filesystem::create_directories(kept.parent_path());
    std::filesystem::copy(first(), kept);
    EXPECT_EQ(openRetry("20260101T000000-abc@1", folder_ / "store").folder, kept);
    EXPECT_EQ(openRetry(first().string() + "@fat", folder_ / "store").number, 1u);
    EXPECT_EQ(openRetry((folder_ / "first").string(), {}).number, 3u);
}

// A bookmark must be on disk immediately, because the power may fail right after it.
TEST(Bookmarks, AreWrittenToTheRecordImmediately) {
    const test::TempFolder folder;
    records::RecordWriter writer(folder / "record", {}, onTheDuct());
    std::string letters = "x";  // an odd offset: letters of two bytes each follow
    for (int i = 0; i < 1000; ++i)
        letters += "\u00e4";
    for (int i = 0; i < 3; ++i)
        writer.bookmark({std::uint64_t(i), i == 1 ? letters : "mark"});
    const records::Record record = records::loadRecord(folder / "record");
    ASSERT_EQ(record.info.bookmarks.size(), 3u);
    EXPECT_FALSE(record.info.end);
    EXPECT_EQ(record.info.bookmarks[1].text, letters.substr(0, records::kMaxBookmarkBytes - 1));
    EXPECT_EQ(record.info.bookmarks[2].tick, 2u);
    // State after a kill before any tick was on disk.
    EXPECT_EQ(openRetry((folder / "record").string(), {}).number, 1u);
    test::expectRefused([&] { openRetry((folder / "record").string() + "@3", {}); }, "record", "bookmark 3");
}

}  // namespace
}  // namespace stylet::trainer
