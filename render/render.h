// The picture: Vulkan device, what a frame shows, and the renderer that draws it.
#pragma once

#include "render/gpu.h"       // instance, device, queue; hooks for OpenXR
#include "render/renderer.h"  // both eyes of a scene
#include "render/scene.h"     // what one frame shows, what it may skip, what it counted
