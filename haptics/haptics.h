// What the hand feels: the force models, the tick that folds them, the loop that runs it at 1 kHz.
#pragma once

// In order of use.
// clang-format off
#include "haptics/tool.h"        // the five tools, what a model says of a tick
#include "haptics/incision.h"    // what the scalpel opened
#include "haptics/needle.h"      // the needle: state, step, force
#include "haptics/exact.h"       // the same force in closed form along straight paths: oracle and study
#include "haptics/guide.h"       // the rail that keeps a needle on one line
#include "haptics/touch.h"       // what lies under the skin, for whatever presses on it
#include "haptics/pad.h"         // a pad of proxies on the skin
#include "haptics/finger.h"      // the palpating finger
#include "haptics/probe.h"       // the ultrasound probe, held and parked
#include "haptics/scalpel.h"     // the scalpel, which opens incisions
#include "haptics/toolbox.h"     // the tool in hand, the change of tools
#include "haptics/device.h"      // a device: what it can do, what it says
#include "haptics/safety.h"      // when a device may push at all; every fault by name
#include "haptics/passivity.h"   // energy: observer and controller
#include "haptics/output.h"      // the one output stage: rate, gain, ramp, passivity, clamp
#include "haptics/simulation.h"  // one tick of everything hashed
#include "haptics/trace.h"       // device traces: recorded or scripted hands
#include "haptics/rings.h"       // rings and snapshots between threads
#include "haptics/flight_recorder.h"  // two seconds of history when a fault comes
#include "haptics/loop.h"        // the loop
