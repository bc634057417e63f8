#include "haptics/loop/flight_recorder.h"

#include <gtest/gtest.h>

#include <thread>

namespace stylet::haptics {
namespace {

// Logs ticks `first` to `last`, all with the given faults.
void log(FlightRecorder& recorder, std::uint64_t first, std::uint64_t last, std::uint32_t faults = 0) {
    TickRecord record;
    record.output.faults = faults;
    for (std::uint64_t tick = first; tick <= last; ++tick) {
        record.output.tick = tick;
        record.input.device.buttons = std::uint32_t(tick);
        recorder.log(record);
    }
}

TEST(FlightRecorder, KeepsTwoSecondsBeforeAFaultAndATenthAfter) {
    FlightRecorder recorder(0.001);
    std::vector<TickRecord> flight;
    log(recorder, 1, 10000);
    EXPECT_FALSE(recorder.pop(flight));
    log(recorder, 10001, 10100, kFaultBadPose);
    EXPECT_FALSE(recorder.pop(flight));
    log(recorder, 10101, 10101, kFaultBadPose);
    ASSERT_TRUE(recorder.pop(flight));
    ASSERT_EQ(flight.size(), 2100u);
    for (std::size_t i = 0; i < flight.size(); ++i)
        ASSERT_EQ(flight[i].output.tick, 8002 + i);
    EXPECT_EQ(flight.front().input.device.buttons, 8002u);
    EXPECT_FALSE(recorder.pop(flight));
    log(recorder, 10102, 20000, kFaultBadPose);  // the same fault continues
    EXPECT_FALSE(recorder.pop(flight));
    log(recorder, 20001, 20500);  // re-armed
    log(recorder, 20501, 20700, kFaultBadPose);
    EXPECT_TRUE(recorder.pop(flight));
}

TEST(FlightRecorder, NewFaultBitStartsANewRecordingAndShortHistoryIsShort) {
    FlightRecorder recorder(0.00025);
    std::vector<TickRecord> flight;
    log(recorder, 1, 10);
    log(recorder, 11, 411, kFaultHandOff);
    ASSERT_TRUE(recorder.pop(flight));
    EXPECT_EQ(flight.size(), 411u);
    log(recorder, 412, 900, kFaultHandOff | kFaultDeviceLost);
    EXPECT_TRUE(recorder.pop(flight));
    EXPECT_EQ(flight.front().output.tick, 412u);
}

TEST(FlightRecorder, UnconsumedRecordingIsKeptAndTheNextIsCountedAsDropped) {
    FlightRecorder recorder(0.001);
    std::vector<TickRecord> flight;
    log(recorder, 1, 200, kFaultBadPose);
    log(recorder, 201, 300);
    log(recorder, 301, 500, kFaultBadForce);
    EXPECT_EQ(recorder.dropped(), 1u);
    ASSERT_TRUE(recorder.pop(flight));
    EXPECT_EQ(flight.front().output.tick, 1u);
}

TEST(FlightRecorder, FinishEndsARunningRecording) {
    FlightRecorder recorder(0.001);
    std::vector<TickRecord> flight;
    log(recorder, 1, 50);
    recorder.finish();
    EXPECT_FALSE(recorder.pop(flight));
    log(recorder, 51, 60, kFaultOverSpeed);
    recorder.finish();
    ASSERT_TRUE(recorder.pop(flight));
    EXPECT_EQ(flight.size(), 60u);
}

// For ThreadSanitizer: one thread logs, another consumes.
TEST(FlightRecorder, ManyFlightsBetweenTwoThreads) {
    FlightRecorder recorder(0.01);
    std::atomic<bool> ended{false};
    std::thread haptics([&] {
        for (std::uint64_t i = 0; i < 300; ++i)
            log(recorder, 100 * i + 1, 100 * i + 100, i % 2 == 0 ? kFaultBadPose : 0u);
        ended.store(true);
    });
    std::vector<TickRecord> flight;
    std::uint64_t taken = 0;
    const auto takeAll = [&] {
        while (recorder.pop(flight)) {
            ++taken;
            for (std::size_t i = 1; i < flight.size(); ++i)
                ASSERT_EQ(flight[i].output.tick, flight[i - 1].output.tick + 1);
        }
    };
    while (!ended.load())
        takeAll();
    haptics.join();
    takeAll();
    EXPECT_EQ(taken + recorder.dropped(), 150u);
    EXPECT_GE(taken, 1u);
}

}  // namespace
}  // namespace stylet::haptics
