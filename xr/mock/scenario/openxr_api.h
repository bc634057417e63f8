// The OpenXR and Vulkan declarations, in the only order that works.
#pragma once

#define XR_NO_PROTOTYPES
#define VK_NO_PROTOTYPES
#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC

#include <vulkan/vulkan.h>

#include <time.h>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "openxr_later.h"
