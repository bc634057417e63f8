// Haptic rendering: the force models, the simulation tick that combines them, and the 1 kHz loop.
#pragma once

// The headers are in order of use.
// clang-format off
#include "haptics/tools/tool.h"              // the tools, and the result of a tick
#include "haptics/tools/incision.h"          // incisions made by the scalpel
#include "haptics/tools/needle.h"            // the needle: state, step, force
#include "haptics/tools/force_sample.h"      // its force over the depth, as curves show it
#include "haptics/tools/exact.h"             // the same force in closed form along straight paths: oracle and study
#include "haptics/tools/guide.h"             // the rail that guides the needle along one line
#include "haptics/tools/touch.h"             // compliance of the layers under the skin
#include "haptics/tools/pad.h"               // a pad of proxies on the skin
#include "haptics/tools/finger.h"            // the palpating finger
#include "haptics/tools/probe.h"             // the ultrasound probe, hand-held or parked
#include "haptics/tools/scalpel.h"           // the scalpel, which opens incisions
#include "haptics/tools/wire.h"              // the guide wire in the ducts
#include "haptics/tools/tube.h"              // dilator and drain over the wire
#include "haptics/tools/instrument.h"        // instruments: dimensions, material and force settings from files
#include "haptics/loop/access.h"             // needle, wire, dilator and drain on one track
#include "haptics/loop/toolbox.h"            // the active tool and tool changes
#include "haptics/tools/device.h"            // haptic device interface: capabilities and state
#include "haptics/output/safety.h"           // safety checks, force ramps, named faults
#include "haptics/output/stored_energy.h"    // the springs return no more than the hand has put in
#include "haptics/output/passivity.h"        // passivity observer and controller
#include "haptics/output/output.h"           // the one output stage: rate, gain, ramp, passivity, clamp
#include "haptics/loop/simulation.h"         // one tick of the hashed state
#include "haptics/loop/trace.h"              // device traces, recorded or scripted
#include "haptics/loop/flight_recorder.h"    // two seconds of history around a fault
#include "haptics/loop/loop.h"               // the loop
