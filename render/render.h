// Rendering: the Vulkan device, the content of a frame, and the renderer that draws it.
#pragma once

#include "render/fluoroscopy/fluoroscopy.h"  // picture on the C-arm's screen
#include "render/frame/eye_tap.h"            // copies one eye to the host
#include "render/frame/governor.h"           // dynamic resolution
#include "render/frame/presenter.h"          // shows pictures on a window's surface
#include "render/frame/renderer.h"           // draws both eyes of a scene
#include "render/gpu/gpu.h"                  // instance, device, queue; hooks for OpenXR
#include "render/gpu/picture_upload.h"       // uploads pictures to images of the OpenXR runtime
#include "render/scene/scene.h"              // content, settings and counters of one frame
#include "render/ultrasound/ultrasound.h"    // picture of the ultrasound machine
