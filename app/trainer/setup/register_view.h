// The headset as `stylet register` uses it: one flat picture in front of the eyes, a controller and its
// buttons. The build selects the implementation (register_gpu.cpp or register_none.cpp).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "base/geometry.h"

namespace stylet::trainer {

// Content of one frame.
struct RegisterShown {
    const std::uint8_t* rgba = nullptr;  // RegisterCard's, rows from the top
    std::uint64_t revision = 0;
    std::optional<Pose> stage_from_needle{};  // needle to draw: tip at the origin, hub at +z
};

struct RegisterAnswer {
    bool over = false;  // the runtime wants the program to end
    bool seen = false;  // frames are being shown
    bool select = false, menu = false;
    bool bare = false;         // bare hand without a controller: too inaccurate
    bool space_moved = false;  // since the last frame
};

struct RegisterView {
    // Frame thread. Waits for the runtime's frame timing. Throws std::runtime_error if the GPU or the
    // runtime is lost.
    std::function<RegisterAnswer(const RegisterShown&)> frame;
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
