// What `stylet register` needs of a headset: one flat picture before the eyes, a controller and its buttons.
// Which of the two there is, is decided by the build (register_gpu.cpp or register_none.cpp).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "patient/geometry.h"

namespace stylet::trainer {

// Shown for one frame.
struct RegisterShown {
    const std::uint8_t* rgba = nullptr;  // RegisterCard's, rows from the top
    std::uint64_t revision = 0;
    std::optional<patient::Pose> stage_from_needle{};  // drawn as a needle: its tip at the origin, hub at +z
};

struct RegisterAnswer {
    bool over = false;  // the runtime wants the program to end
    bool seen = false;  // frames are being shown
    bool select = false, menu = false;
    bool bare = false;         // a hand without a controller: too vague for this
    bool space_moved = false;  // since the last frame
};

struct RegisterView {
    // Frame thread; waits for the runtime's pace. Throws std::runtime_error when GPU or runtime are lost.
    std::function<RegisterAnswer(const RegisterShown&)> frame;
    // Any thread while this lives: where the controller was, CLOCK_MONOTONIC.
    std::function<std::optional<patient::Pose>(std::int64_t when_ns)> gripAt;
    std::function<std::string()> space, generation;
};

struct RegisterViewSettings {
    std::filesystem::path assets;
    std::filesystem::path pipeline_cache{};
    int side = 1;  // of the controller: 0 left
    bool validation = false;
};

// Empty where there is no headset; then `why_not` is one line.
std::optional<RegisterView> openRegisterView(const RegisterViewSettings&, std::string& why_not);

}  // namespace stylet::trainer
