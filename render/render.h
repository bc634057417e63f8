// Rendering: the Vulkan device, the content of a frame, and the renderer that draws it.
#pragma once

// In order of use: create the device, describe a frame, draw it.
// clang-format off
#include "render/gpu/gpu.h"                  // instance, device, queue; hooks for OpenXR
#include "render/scene/scene.h"              // content, settings and counters of one frame
#include "render/frame/renderer.h"           // draws both eyes of a scene
#include "render/frame/governor.h"           // dynamic resolution

// Finished pictures: to the host, to the OpenXR runtime, to a window.
#include "render/frame/eye_tap.h"            // copies one eye to the host
#include "render/gpu/picture_upload.h"       // uploads pictures to images of the OpenXR runtime
#include "render/frame/presenter.h"          // shows pictures on a window's surface

// Imaging. Independent of the renderer: each computes its picture into host memory.
#include "render/ultrasound/ultrasound.h"    // picture of the ultrasound machine
#include "render/fluoroscopy/fluoroscopy.h"  // picture on the C-arm's screen
