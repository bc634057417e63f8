// The headset as `stylet register` uses it: one flat picture in front of the eyes, and a controller with its
// buttons. The build selects the implementation (register_gpu.cpp or setup_none.cpp).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "base/geometry.h"

namespace stylet::trainer {

// Content of one frame.
struct RegisterFrame {
    const std::uint8_t* rgba = nullptr;  // picture of RegisterCard, rows from the top
    std::uint64_t revision = 0;
    std::optional<Pose> stage_from_needle{};  // needle to draw: tip at the origin, hub at +z
};

struct RegisterInput {
    bool over = false;  // the runtime asks the program to end
    bool seen = false;  // frames are being displayed
    bool select = false, menu = false;
    bool bare = false;         // a bare hand is tracked instead of a controller: too inaccurate
    bool space_moved = false;  // the runtime's space has moved since the last frame
};

struct RegisterView {
    // Frame thread. Waits for the runtime's frame timing. Throws EnvironmentError if the GPU or the
    // runtime is lost.
    std::function<RegisterInput(const RegisterFrame&)> frame;
    // Any thread, as long as this object exists. Grip pose of the controller at `when_ns`
    // (CLOCK_MONOTONIC).
    std::function<std::optional<Pose>(std::int64_t when_ns)> gripAt;
    std::function<std::string()> space, generation;
};

struct RegisterViewSettings {
    std::filesystem::path assets;
    std::filesystem::path pipeline_cache{};
    int side = 1;  // controller: 0 left, 1 right
    bool validation = false;
};

// Returns nothing if there is no headset. `why_not` is then one line.
std::optional<RegisterView> openRegisterView(const RegisterViewSettings&, std::string& why_not);

}  // namespace stylet::trainer
