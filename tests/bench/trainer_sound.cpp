// Sound latency: from the session's request to the device, and from there to the first audible sample.
#include <cmath>
#include <thread>

#include "app/trainer/sound/sounds.h"
#include "tests/bench/bench.h"

namespace stylet::bench {
namespace {

using trainer::Sound;
using trainer::SoundFrame;
using trainer::Speaker;

SoundFrame click() {
    SoundFrame heard;
    heard[Sound::click] = {0.5f, 1.0f, {0.0, 0.0, -1.0}};
    heard.begun = trainer::soundBit(Sound::click);
    return heard;
}

// Returns the time [ms] from the start of the next mixed block to the first audible sample.
double onset_ms() {
    Speaker speaker = Speaker::loopback();
    std::vector<float> block(2 * trainer::kClipRate_hz / 100);
    speaker.render(block);
    speaker.play(click());
    speaker.render(block);
    std::size_t first = 0;
    while (first < block.size() && std::fabs(block[first]) < 0.01f)
        ++first;
    return 1e3 * double(first / 2) / trainer::kClipRate_hz;
}

void run(std::vector<Row>& rows) {
    trainer::Sounds sounds({}, nullptr, Speaker::loopback, [](const std::string&) {});
    constexpr std::uint64_t kCues = 200;
    while (sounds.totals().device.empty())  // wait until the device is open
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    for (std::uint64_t i = 1; i <= kCues; ++i) {
        sounds.submit(click());
        while (sounds.totals().begun < i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const trainer::SoundTotals totals = sounds.totals();
    Row row;
    row.name = "trainer.sound";
    row.knob = "cues";
    row.value = double(kCues);
    row.time_ms = 1e3 * totals.mean_late_s;
    row.error = 1e3 * totals.late_s;
    row.error_unit = "ms (latest)";
    row.reference = "the instant the session said it";
    row.note = "handed to OpenAL (mean); heard " + std::to_string(onset_ms()) +
               " ms into the next period, of which 3 of 10 ms wait in a device that does as asked";
    rows.push_back(row);
}

const Registration registration("trainer.sound", run);

}  // namespace
}  // namespace stylet::bench
