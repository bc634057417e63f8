// The frame loop as the rest of the trainer sees it: something that may draw, or nothing. Which of the two is
// decided by the build (pictures_gpu.cpp or pictures_none.cpp) and, at run time, by whether a runtime
// answers.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptics/simulation.h"
#include "patient/planning.h"

namespace stylet::trainer {

struct PictureSettings {
    std::filesystem::path assets;
    std::filesystem::path capture_folder;  // where the mock runtime puts the eyes' PNGs
    bool validation = false;
    bool virtual_clock = false;
};

struct PictureTotals {
    std::uint64_t frames = 0, rendered = 0, validation_messages = 0;
    double median_frame_ms = 0.0;
    std::string runtime, gpu;
    std::vector<std::pair<std::string, std::uint64_t>> skips;  // counters of work left out
};

// Frame thread only. `frame` draws one display time, false when the runtime asks to end; a named moment is
// captured. Throws std::runtime_error when GPU or runtime are lost.
struct Pictures {
    std::function<bool(const haptics::TickOutput& shown, const std::string& moment)> frame;
    std::function<PictureTotals()> totals;
    std::function<bool()> focused = nullptr;  // as of the last frame; absent: always
};

// Empty when no pictures can be made; then `why_not` is one line: what was looked for, where, what was
// missing.
std::optional<Pictures> openPictures(const patient::Patient&, const patient::PlannedPath&,
                                     const PictureSettings&, std::string& why_not);

// Both eyes of a head that keeps still, of a patient whose only motion is the breath: no runtime has a part
// in it. One thread.
struct EyePicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // packed triples, rows from the top
};
struct StereoView {
    std::function<std::array<EyePicture, 2>(const patient::Surrogate&)> draw;
    std::string gpu;
};
std::optional<StereoView> openStereo(const patient::Patient&, const patient::PlannedPath&,
                                     const std::filesystem::path& assets, std::string& why_not);

}  // namespace stylet::trainer
