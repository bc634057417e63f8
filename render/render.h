// The picture: Vulkan device, what a frame shows, and the renderer that draws it.
#pragma once

#include "render/eye_tap.h"                  // an eye for somebody without a headset
#include "render/fluoroscopy/fluoroscopy.h"  // the C-arm's screen
#include "render/governor.h"                 // resolution that keeps to a budget
#include "render/gpu.h"                      // instance, device, queue; hooks for OpenXR
#include "render/picture_upload.h"           // pictures for images of the runtime's
#include "render/presenter.h"                // pictures on a window's surface
#include "render/renderer.h"                 // both eyes of a scene
#include "render/scene.h"                    // what one frame shows, what it may skip, what it counted
#include "render/ultrasound/ultrasound.h"    // the ultrasound machine
