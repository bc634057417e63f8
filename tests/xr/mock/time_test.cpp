// XR_KHR_convert_timespec_time.
#include <limits>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

constexpr long kNsPerSecond = 1'000'000'000;

class Time : public MockTest {
  protected:
    void startWith(const char* clock) {
        setVariable("XRMOCK_CLOCK", clock);
        start();
        to_time_ = load<PFN_xrConvertTimespecTimeToTimeKHR>(instance_, "xrConvertTimespecTimeToTimeKHR");
        to_timespec_ = load<PFN_xrConvertTimeToTimespecTimeKHR>(instance_, "xrConvertTimeToTimespecTimeKHR");
    }
    XrTime toTime(const timespec& time) {
        XrTime result = 0;
        EXPECT_EQ(to_time_(instance_, &time, &result), XR_SUCCESS);
        return result;
    }
    timespec toTimespec(XrTime time) {
        timespec result{};
        EXPECT_EQ(to_timespec_(instance_, time, &result), XR_SUCCESS);
        return result;
    }
    static timespec monotonicNow() {
        timespec now{};
        clock_gettime(CLOCK_MONOTONIC, &now);
        return now;
    }
    void expectRoundTrips() {
        const timespec now = monotonicNow();
        const XrTime time = toTime(now);
        EXPECT_GT(time, 0);
        const timespec back = toTimespec(time);
        EXPECT_EQ(back.tv_sec, now.tv_sec);
        EXPECT_EQ(back.tv_nsec, now.tv_nsec);
        EXPECT_EQ(toTime(back), time);
    }
    PFN_xrConvertTimespecTimeToTimeKHR to_time_ = nullptr;
    PFN_xrConvertTimeToTimespecTimeKHR to_timespec_ = nullptr;
};

TEST_F(Time, OfTheWallClockIsMonotonic) {
    startWith("real");
    expectRoundTrips();
    EXPECT_EQ(toTime({12, 34}), 12 * kNsPerSecond + 34);
    const timespec back = toTimespec(5 * kNsPerSecond + 6);
    EXPECT_EQ(back.tv_sec, 5);
    EXPECT_EQ(back.tv_nsec, 6);
}

TEST_F(Time, OfTheVirtualClockCountsFromTheInstance) {
    const timespec before = monotonicNow();
    startWith("virtual");
    const timespec after = monotonicNow();
    expectRoundTrips();
    const timespec second = toTimespec(kNsPerSecond);  // one second after xrCreateInstance
    EXPECT_GE(second.tv_sec, before.tv_sec + 1);
    EXPECT_LE(second.tv_sec, after.tv_sec + 2);
    XrTime time;
    EXPECT_EQ(to_time_(instance_, &before, &time), XR_ERROR_TIME_INVALID);
}

TEST_F(Time, OutOfRangeIsRefused) {
    startWith("real");
    timespec time{};
    EXPECT_EQ(to_timespec_(instance_, 0, &time), XR_ERROR_TIME_INVALID);
    EXPECT_EQ(to_timespec_(instance_, -1, &time), XR_ERROR_TIME_INVALID);
    XrTime result = 0;
    for (const timespec& bad : {timespec{0, 0}, timespec{-1, 0}, timespec{std::int64_t{1} << 62, 0}})
        EXPECT_EQ(to_time_(instance_, &bad, &result), XR_ERROR_TIME_INVALID);
    for (const timespec& bad : {timespec{1, -1}, timespec{1, kNsPerSecond}})
        EXPECT_EQ(to_time_(instance_, &bad, &result), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(to_time_(instance_, nullptr, &result), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(to_time_(instance_, &time, nullptr), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(to_timespec_(instance_, 1, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

// Nothing may overflow, even at the extreme time values.
TEST_F(Time, SpacesAreLocatedAtEveryTime) {
    startSession();
    const XrSpace view = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    auto velocity = makeStruct<XrSpaceVelocity>(XR_TYPE_SPACE_VELOCITY);
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    location.next = &velocity;
    for (const XrTime time : {XrTime{1}, XrTime{1} << 40, std::numeric_limits<XrTime>::max()}) {
        EXPECT_EQ(xrLocateSpace(view, stage_, time, &location), XR_SUCCESS);
        EXPECT_EQ(location.next, &velocity);
        EXPECT_EQ(velocity.type, XR_TYPE_SPACE_VELOCITY);
        EXPECT_EQ(location.locationFlags, 15U);
    }
}

}  // namespace
}  // namespace mock_test
