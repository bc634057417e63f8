#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "haptics/devices/inverse3/inverse3_messages.h"

// A message is accepted with valid values or rejected with a reason. An accepted device id needs no
// escaping.
// HZ-FORCE-21, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::haptics;
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    std::string why;
    const auto update = inverse3::parseUpdate(text, why);
    if (update.has_value() != why.empty()) std::abort();
    if (update) {
        const stylet::Pose pose = inverse3::stylusPose(*update);
        if (!(glm::length(pose.position_m) <= inverse3::kFarthest_m)) std::abort();
        if (!(std::fabs(glm::length(pose.rotation) - 1.0) < 1e-9)) std::abort();
        if (update->present) {
            std::string command;
            inverse3::writeForce(command, update->device_id, {0.0, 1.0, 0.0}, inverse3::Spelling::vector);
            // The id must not bring in a backslash or any character that needs escaping.
            if (command.size() != update->device_id.size() + 94 || command.find('\\') != command.npos)
                std::abort();
        }
    }
    inverse3::parseSpelling(text);
    return 0;
}
