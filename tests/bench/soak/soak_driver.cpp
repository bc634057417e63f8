#include <vulkan/vulkan_raii.hpp>

#include "tests/bench/soak/soak_output.h"

namespace stylet::soak {

void keepDriverLoaded() {
    static const vk::raii::Context context;
    static const vk::raii::Instance instance = context.createInstance({});
    // The loader opens the driver for the devices, and keeps it open as long as the instance exists.
    static const vk::raii::PhysicalDevices devices(instance);
}

}  // namespace stylet::soak
