#include "capture.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "composition.h"
#include "png.h"

namespace xrmock {

namespace {

constexpr char kPrefix[] = "capture:";
constexpr std::size_t kMaxName = 128;

std::vector<std::uint8_t> withoutAlpha(const std::vector<std::uint8_t>& rgba) {
    std::vector<std::uint8_t> rgb(rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < rgba.size() / 4; ++i) {
        for (std::size_t channel = 0; channel < 3; ++channel)
            rgb[i * 3 + channel] = rgba[i * 4 + channel];
    }
    return rgb;
}

void captureEyes(Session& session, const std::string& name, const SubmittedFrame& frame) {
    const char* const suffixes[] = {"_left.png", "_right.png"};
    std::filesystem::create_directories(session.instance.capture_folder);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const Picture picture = composeEye(session, frame, eye);
        writePng(session.instance.capture_folder + "/" + name + suffixes[eye], picture.width, picture.height,
                 withoutAlpha(picture.rgba));
    }
    ++session.instance.statistics.captured;
}

}  // namespace

std::string captureName(const std::string& label) {
    if (!label.starts_with(kPrefix)) return {};
    const std::string name = label.substr(sizeof kPrefix - 1);
    const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-' || c == '.';
    });
    return plain && name.size() <= kMaxName && !name.starts_with('.') ? name : std::string();
}

void captureIfDue(Call& call, Session& session, const SubmittedFrame& frame) {
    if (session.capture_name.empty() || frame.layers.empty()) return;
    try {
        captureEyes(session, session.capture_name, frame);
    } catch (const Refused& refused) {
        warn(call, "capture " + session.capture_name + ": " + refused.reason);
    } catch (const std::exception& error) {
        warn(call, "capture " + session.capture_name + ": " + error.what());
    }
    session.capture_name.clear();
}

void writeStatistics(const Instance& instance) {
    std::error_code unwritable;  // then there is nobody to tell: the instance is going
    std::filesystem::create_directories(instance.capture_folder, unwritable);
    const Statistics& counts = instance.statistics;
    std::ofstream(instance.capture_folder + "/frames.json")
        << "{\n    \"submitted\": " << counts.submitted << ",\n    \"discarded\": " << counts.discarded
        << ",\n    \"missed\": " << counts.missed << ",\n    \"captured\": " << counts.captured
        << ",\n    \"haptic_pulses\": " << counts.haptic_pulses << "\n}\n";
}

}  // namespace xrmock
