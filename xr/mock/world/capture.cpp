#include "world/capture.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "compositor/png.h"
#include "world/composition.h"

namespace xrmock {

namespace {

void captureEyes(Call& call, Session& session, const SubmittedFrame& frame) {
    const char* const suffixes[] = {"_left.png", "_right.png"};
    std::filesystem::create_directories(session.instance.capture_folder);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        writeFile(session.instance.capture_folder + "/" + session.capture_name + suffixes[eye],
                  eyePng(call, session, frame, eye));
    }
    ++session.instance.statistics.captured;
}

}  // namespace

std::string eyePng(Call& call, Session& session, const SubmittedFrame& frame, std::size_t eye) {
    const std::int64_t start_ns = monotonicNs();
    const Picture picture = composeEye(session, frame, eye);
    std::ostringstream text;
    text << "composed the " << (eye == 0 ? "left" : "right") << " eye: " << picture.width << " x "
         << picture.height << ", " << frame.layers.size() << " layers, "
         << static_cast<double>(monotonicNs() - start_ns) * 1e-6 << " ms";
    reportPerformance(call, text.str());
    return encodePng(picture.width, picture.height, picture.rgba);
}

void captureIfDue(Call& call, Session& session, const SubmittedFrame& frame) {
    if (session.capture_name.empty() || frame.layers.empty() || session.frames.begun_override.dropped) return;
    try {
        captureEyes(call, session, frame);
    } catch (const Refused& refused) {
        warn(call, "capture " + session.capture_name + ": " + refused.reason);
    } catch (const std::exception& error) {
        warn(call, "capture " + session.capture_name + ": " + error.what());
    }
    session.capture_name.clear();
}

void writeStatistics(const Instance& instance) {
    std::error_code unwritable;  // errors are ignored: the instance is being destroyed
    std::filesystem::create_directories(instance.capture_folder, unwritable);
    const Statistics& counts = instance.statistics;
    std::ofstream(instance.capture_folder + "/frames.json")
        << "{\n    \"submitted\": " << counts.submitted << ",\n    \"discarded\": " << counts.discarded
        << ",\n    \"missed\": " << counts.missed << ",\n    \"captured\": " << counts.captured
        << ",\n    \"haptic_pulses\": " << counts.haptic_pulses << "\n}\n";
}

}  // namespace xrmock
