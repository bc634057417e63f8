#include "world/capture.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "compositor/png.h"
#include "world/composition.h"
#include "world/log.h"

namespace xrmock {

namespace {

void captureEyes(Call& call, Session& session, const SubmittedFrame& frame) {
    const char* const suffixes[] = {"_left.png", "_right.png"};
    const std::string& folder = session.instance.capture_folder;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw std::runtime_error(folder + " cannot be created: " + error.message());
    for (std::size_t eye = 0; eye < 2; ++eye) {
        writeFile(folder + "/" + session.capture_name + suffixes[eye], eyePng(call, session, frame, eye));
    }
    ++session.instance.statistics.captured;
}

// Prints and logs the first error of the instance.
void reportError(Instance& instance, const std::string& reason) {
    if (std::exchange(instance.capture_failed, true)) return;
    std::fprintf(stderr, "xrmock: XRMOCK_CAPTURE: %s\n", reason.c_str());
    if (runtime().log) logError(*runtime().log, "XRMOCK_CAPTURE: " + reason);
}

void reportFailedCapture(Call& call, Session& session, const std::string& reason) {
    const std::string text = "capture " + session.capture_name + ": " + reason;
    warn(call, text);
    reportError(session.instance, text);
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
        reportFailedCapture(call, session, refused.reason);
    } catch (const std::exception& error) {
        reportFailedCapture(call, session, error.what());
    }
    session.capture_name.clear();
}

void writeStatistics(Instance& instance) {
    std::error_code error;  // the file cannot be written either
    std::filesystem::create_directories(instance.capture_folder, error);
    const Statistics& counts = instance.statistics;
    const std::string file = instance.capture_folder + "/frames.json";
    std::ofstream out(file);
    out << "{\n    \"submitted\": " << counts.submitted << ",\n    \"discarded\": " << counts.discarded
        << ",\n    \"missed\": " << counts.missed << ",\n    \"captured\": " << counts.captured
        << ",\n    \"haptic_pulses\": " << counts.haptic_pulses << "\n}\n";
    out.close();
    if (!out) reportError(instance, file + " cannot be written");
}

}  // namespace xrmock
