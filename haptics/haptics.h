// Haptic rendering: the force models, the simulation tick that combines them, and the 1 kHz loop.
#pragma once

// In order of use.
// clang-format off
#include "haptics/tool.h"        // the five tools, and the result of a tick
#include "haptics/incision.h"    // incisions made by the scalpel
#include "haptics/needle.h"      // the needle: state, step, force
#include "haptics/exact.h"       // the same force in closed form along straight paths: oracle and study
#include "haptics/guide.h"       // the rail that guides the needle along one line
#include "haptics/touch.h"       // compliance of the layers under the skin
#include "haptics/pad.h"         // a pad of proxies on the skin
#include "haptics/finger.h"      // the palpating finger
#include "haptics/probe.h"       // the ultrasound probe, hand-held or parked
#include "haptics/scalpel.h"     // the scalpel, which opens incisions
#include "haptics/toolbox.h"     // the active tool and tool changes
#include "haptics/device.h"      // haptic device interface: capabilities and state
#include "haptics/safety.h"      // safety checks, force ramps, named faults
#include "haptics/passivity.h"   // passivity observer and controller
#include "haptics/output.h"      // the one output stage: rate, gain, ramp, passivity, clamp
#include "haptics/simulation.h"  // one tick of the hashed state
#include "haptics/trace.h"       // device traces, recorded or scripted
#include "haptics/rings.h"       // rings and snapshots between threads
#include "haptics/flight_recorder.h"  // two seconds of history around a fault
#include "haptics/loop.h"        // the loop
