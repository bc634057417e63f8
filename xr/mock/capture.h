// Captures: the pictures of the two eyes, as they were submitted.
#pragma once

#include <string>
#include <vector>

#include "objects.h"

namespace xrmock {

// The name after "capture:", or empty when the label asks for no capture or for no plain file name.
std::string captureName(const std::string& label);

// One sub-image of a submitted layer.
struct SubImage {
    Swapchain* swapchain;
    std::uint32_t image;
    XrRect2Di rect;
    std::uint32_t layer;
};

// Writes FOLDER/NAME_left.png and FOLDER/NAME_right.png; waits for the GPU. Throws std::runtime_error or
// Refused.
void captureEyes(Session& session, const std::string& name, const std::vector<SubImage>& eyes);

// FOLDER/frames.json: what the instance counted.
void writeStatistics(const Instance& instance);

}  // namespace xrmock
