// The tutor: what a trainee should do now, in the words of the input in use.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "app/training/equipment.h"
#include "app/training/progress.h"
#include "haptics/loop/simulation.h"

namespace stylet::training {

// One action of the trainee. Each leads to evidence that the current step still lacks (evidence.h).
enum class Act : std::uint8_t {
    answer,   // the next question about the case
    liftOff,  // a tool that was selected while it was in the body gives no force yet
    selectFinger,
    pressGap,
    pressUpperRib,
    pressLowerRib,
    selectProbe,
    holdBreath,
    placeProbe,
    shiftProbe,  // the duct is beside the picture's plane, or outside the picture
    turnProbe,   // a rib or gas hides the duct
    holdProbeStill,
    selectSyringe,  // the needle, with local anaesthetic
    enterWheal,
    numbSkin,
    pushToCapsule,
    numbCapsule,
    pullNeedleBack,         // the tip is past the place to numb
    withdrawNumbingNeedle,  // out of the skin: numb, or beside the track
    aimGuide,               // the guide's line passes beside the duct
    parkProbe,
    liftProbe,  // it was parked where it does not show the duct, or with the guide beside it
    selectScalpel,
    cut,
    selectGuide,
    snapNeedle,
    enterSkin,
    advance,
    withdrawToRetry,  // the puncture was refused or missed the duct: it counts only from outside
    seekDuct,         // the needle's tip is not in a duct
    aspirate,
    pressPedal,
    inject,
    selectWire,
    feedWire,
    pullWireBack,  // it has pierced the duct
    selectNeedle,
    withdrawNeedle,  // out, over the wire
    selectDilator,
    pushDilator,
    withdrawDilator,
    selectDrain,
    pushDrain,
    withdrawDrain,  // it was selected before the dilator
    shiftDrainIn,
    shiftDrainOut,  // the straight drain's side holes lie outside the duct
    withdrawWire,   // out, so that the drain curls
    clearDrain,     // of the wire, for the final picture
    rewireDrain,    // it leaks: the wire, through it, straightens it again
    straightenDrain,
    injectDrain,
    stopInjecting,
    releasePedal,
    finish
};
inline constexpr int kActCount = int(Act::finish) + 1;

Act nextAct(const Progress&, const haptics::TickOutput&, const Equipment&) noexcept;

// The keys, buttons or typed words of an input.
struct Controls {
    std::string_view finger, probe, park, lift, scalpel, guide, hold, numb, aspirate, pedal, inject, stop,
        release;  // "press F"
    std::string_view wire, needle, dilator, drain;
    std::string_view yes, no;                 // answer a question about the case
    std::string_view move, push, pull, turn;  // "drag or use the arrow keys"; push: into the body
    std::string_view skin;                    // places the tool on the skin; empty: this input cannot
    std::string_view expert;                  // shows how the expert does this step
    std::string_view regrip;  // for a long wire in a device with a short travel; empty: not needed
};
// kForceControls: of a force device. kFalconControls: of one whose clutch is its third button.
extern const Controls kMouseControls, kControllerControls, kTypedControls, kForceControls, kFalconControls;

// One or two sentences, for example "Take the finger: press F."
std::string prompt(Act, const Controls&);
// What else may help a trainee to whom the same prompt has been shown for kHintAfter_s. Empty if there is
// nothing more to say.
inline constexpr double kHintAfter_s = 15.0;
std::string hint(Act, const Controls&);

}  // namespace stylet::training
