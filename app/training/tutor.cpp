#include "app/training/tutor.h"

#include <fmt/core.h>

#include <glm/geometric.hpp>
#include <optional>

#include "app/training/evidence.h"

namespace stylet::training {

using haptics::TickOutput;
using haptics::Tool;

const Controls kMouseControls{.finger = "press F",
                              .probe = "press P",
                              .park = "press K",
                              .lift = "press L",
                              .scalpel = "press S",
                              .guide = "press G",
                              .hold = "press H",
                              .numb = "press M",
                              .aspirate = "press V",
                              .pedal = "press X",
                              .inject = "press I",
                              .stop = "press I",
                              .release = "press X",
                              .wire = "press W",
                              .needle = "press N",
                              .dilator = "press D",
                              .drain = "press A",
                              .yes = "press Y",
                              .no = "press U",
                              .move = "drag or use the arrow keys",
                              .push = "turn the wheel forward or press Page Down",
                              .pull = "turn the wheel back or press Page Up",
                              .turn = "press Q or E, or Shift with the arrow keys",
                              .skin = "press T",
                              .expert = "press O",
                              .regrip = ""};
const Controls kControllerControls{.finger = "press B (menu) until you hold it",
                                   .probe = "press B (menu) until you hold it",
                                   .park = "press B (menu)",
                                   .lift = "hold B (menu) for a second",
                                   .scalpel = "press B (menu) until you hold it",
                                   .guide = "press B (menu) until you hold it",
                                   .hold = "squeeze",
                                   .numb = "squeeze the other hand",
                                   .aspirate = "press the other hand's menu button (B)",
                                   .pedal = "pull the other hand's trigger",
                                   .inject = "squeeze the other hand",
                                   .stop = "open the other hand",
                                   .release = "let go of the other hand's trigger",
                                   .wire = "press B (menu) until you hold it",
                                   .needle = "press B (menu) until you hold it",
                                   .dilator = "press B (menu) until you hold it",
                                   .drain = "press B (menu) until you hold it",
                                   .yes = "squeeze",
                                   .no = "press B (menu)",
                                   .move = "move your hand",
                                   .push = "move your hand",
                                   .pull = "move your hand back",
                                   .turn = "turn your hand",
                                   .skin = "hold the trigger",
                                   .expert = "push the stick up",
                                   .regrip = ""};
const Controls kTypedControls{.finger = "type \"finger\"",
                              .probe = "type \"probe\"",
                              .park = "type \"park\"",
                              .lift = "type \"lift\"",
                              .scalpel = "type \"scalpel\"",
                              .guide = "type \"guide\"",
                              .hold = "type \"hold\"",
                              .numb = "type \"numb\"",
                              .aspirate = "type \"aspirate\"",
                              .pedal = "type \"pedal\"",
                              .inject = "type \"inject\"",
                              .stop = "type \"stop\"",
                              .release = "type \"release\"",
                              .wire = "type \"wire\"",
                              .needle = "type \"needle\"",
                              .dilator = "type \"dilator\"",
                              .drain = "type \"drain\"",
                              .yes = "type \"yes\"",
                              .no = "type \"no\"",
                              .move = "move the device",
                              .push = "push the device",
                              .pull = "draw the device back",
                              .turn = "turn the device",
                              .skin = "",
                              .expert = "type \"expert\"",
                              .regrip = ""};

namespace {

Controls withRegrip(std::string_view regrip) {
    Controls controls = kTypedControls;
    controls.regrip = regrip;
    return controls;
}

}  // namespace

const Controls kForceControls = withRegrip(" Re-grip: hold button 1."),
               kFalconControls = withRegrip(" Re-grip: hold button 3.");

namespace {

// Length of wire and drain in the duct before the wire is drawn out: that of the side holes, without the last
// millimetre, by which a compressed wire is shorter.
constexpr double kDrainInDuct_m = haptics::kSideHoles_m - 0.001;
// Greatest distance of the guide's opening from the path at which the duct is searched for in a breath-hold.
constexpr double kProbeReach_m = 0.025;
constexpr double kWireAhead_m = 0.003;  // least length of wire before the drain's end, to move the drain on

Act toFindGap(const Progress& progress, const TickOutput& now) noexcept {
    if (now.tool != Tool::finger) return Act::selectFinger;
    if (progress.missing == Refusal::upperRibNotFelt) return Act::pressUpperRib;
    return progress.missing == Refusal::lowerRibNotFelt ? Act::pressLowerRib : Act::pressGap;
}

// True if the probe in the hand touches the skin and is near enough to its place to ask for a breath-hold. A
// hold is too short to bring the probe there. In a hold, and with an aimed guide, any place will do.
bool isProbePlaced(const Progress& progress, const TickOutput& now, bool aimed) noexcept {
    return now.probe_touching_share > kMinContact &&
           (now.breath_held || aimed || progress.off_path_m <= kProbeReach_m);
}

Act toFindDuct(const Progress& progress, const TickOutput& now) noexcept {
    if (now.tool != Tool::probe && !now.probe_parked) return Act::selectProbe;
    if (!now.probe_parked && !isProbePlaced(progress, now, false)) return Act::placeProbe;
    if (!now.breath_held) return Act::holdBreath;
    if (now.probe_parked && progress.missing != Refusal::ductTooShort) return Act::liftProbe;
    switch (progress.missing) {
        case Refusal::ductBesidePlane:
        case Refusal::ductOutsidePicture:
            return Act::shiftProbe;
        case Refusal::ductShadowed:
            return Act::turnProbe;
        case Refusal::ductTooShort:
            return Act::holdProbeStill;
        default:
            return Act::placeProbe;
    }
}

// To a parked probe whose guide's line meets the duct.
std::optional<Act> toParkedProbe(const Progress& progress, const TickOutput& now) noexcept {
    const bool aimed = progress.missing != Refusal::ductBesideRail;
    if (now.probe_parked && aimed) return std::nullopt;
    if (now.probe_parked) return Act::liftProbe;
    if (now.tool != Tool::probe) return Act::selectProbe;
    if (!isProbePlaced(progress, now, aimed)) return Act::placeProbe;
    if (!now.breath_held) return Act::holdBreath;
    return aimed ? Act::parkProbe : Act::aimGuide;
}

// To local anaesthetic under the skin and at the capsule. The parked probe shows where it goes.
Act toNumb(const Progress& progress, const TickOutput& now, const Equipment& equipment) noexcept {
    const TrackPlace at = progress.track_place;
    if (at == TrackPlace::outside && (!now.probe_parked || progress.missing == Refusal::ductBesideRail))
        if (const std::optional<Act> act = toParkedProbe(progress, now)) return *act;
    if (now.tool != Tool::needle) return Act::selectSyringe;
    const bool skin = progress.missing != Refusal::capsuleNotNumb;
    const TrackPlace wanted = skin ? TrackPlace::skin : TrackPlace::capsule;
    if (at == wanted) return skin ? Act::numbSkin : Act::numbCapsule;
    if (equipment.anaesthetic_m3_per_s > 0.0) return Act::stopInjecting;
    if (at == TrackPlace::aside) return Act::withdrawNumbingNeedle;
    if (at > wanted) return Act::pullNeedleBack;
    return skin ? Act::enterWheal : Act::pushToCapsule;
}

Act toIncise(const Progress& progress, const TickOutput& now) noexcept {
    if (const std::optional<Act> act = toParkedProbe(progress, now)) return *act;
    return now.tool == Tool::scalpel ? Act::cut : Act::selectScalpel;
}

// From the guide to the duct.
Act toPuncture(const Progress& progress, const TickOutput& now) noexcept {
    const bool inside = now.phase != haptics::Phase::outside;
    if (!inside)
        if (const std::optional<Act> act = toParkedProbe(progress, now)) return *act;
    // A free needle does not snap into the guide.
    if (inside ? !haptics::isNeedleTool(now.tool) : now.tool != Tool::guide) return Act::selectGuide;
    if (!now.needle_in_guide) return inside ? Act::withdrawToRetry : Act::snapNeedle;
    const bool refused = progress.missing != Refusal::none && progress.missing != Refusal::ductBesideRail;
    if (inside && refused) return Act::withdrawToRetry;
    if (!now.breath_held) return Act::holdBreath;
    return inside ? Act::advance : Act::enterSkin;
}

// To a free needle whose tip is in a duct.
std::optional<Act> toTipInDuct(const Progress& progress, const TickOutput& now) noexcept {
    if (now.phase == haptics::Phase::outside) return toPuncture(progress, now);
    if (now.tissue != patient::Tissue::duct) return Act::seekDuct;
    return std::nullopt;
}

Act toPicture(const Progress& progress, const TickOutput& now, const Equipment& equipment) noexcept {
    if (const std::optional<Act> act = toTipInDuct(progress, now)) return *act;
    return equipment.xray.pedal ? Act::inject : Act::pressPedal;
}

// To a wire that lies down the duct. The needle, or an earlier wire, holds the way to it.
Act toPassWire(const Progress& progress, const TickOutput& now) noexcept {
    const haptics::AccessOutput& access = now.access;
    if (access.dilator_m > 0.0) return now.tool == Tool::dilator ? Act::withdrawDilator : Act::selectDilator;
    if (!access.wire_in) {
        if (const std::optional<Act> act = toTipInDuct(progress, now)) return *act;
        // The needle has come out since bile or contrast medium proved its place.
        if (progress.missing == Refusal::wireUnproven) return Act::aspirate;
    }
    if (now.tool != Tool::wire) return Act::selectWire;
    // A needle that the wire fills draws no bile.
    if (access.needle_in && progress.missing == Refusal::wireUnproven) return Act::pullWireBack;
    return access.pierced ? Act::pullWireBack : Act::feedWire;
}

// To a wire without a needle around it, for what slides over it.
std::optional<Act> toFreeWire(const Progress& progress, const TickOutput& now) noexcept {
    const haptics::AccessOutput& access = now.access;
    if (!access.wire_in || access.pierced || access.in_duct_m < kDrainInDuct_m)
        return toPassWire(progress, now);
    if (!access.needle_in) return std::nullopt;
    return haptics::isNeedleTool(now.tool) ? Act::withdrawNeedle : Act::selectNeedle;
}

Act toDilate(const Progress& progress, const TickOutput& now) noexcept {
    if (now.access.drain_m > 0.0 && now.access.wire_in)
        return now.tool == Tool::drain ? Act::withdrawDrain : Act::selectDrain;
    if (const std::optional<Act> act = toFreeWire(progress, now)) return *act;
    return now.tool == Tool::dilator ? Act::pushDilator : Act::selectDilator;
}

Act toPlaceDrain(const Progress& progress, const TickOutput& now) noexcept {
    using haptics::DrainState;
    const haptics::AccessOutput& access = now.access;
    if (access.drain == DrainState::in_place || access.drain == DrainState::misplaced) {
        if (!access.open) return Act::rewireDrain;
        return now.tool == Tool::wire ? Act::straightenDrain : Act::selectWire;
    }
    const double track_m = glm::length(access.base_m - access.entry_m);
    const bool deep =
        access.wire_in && access.drain == DrainState::over_wire && access.drain_m >= track_m + kDrainInDuct_m;
    const bool leaks = progress.missing == Refusal::drainLeaks,
               beyond = progress.missing == Refusal::drainTooDeep;
    if (deep && (leaks || beyond)) {
        // The drain cannot go beyond the wire's tip.
        if (leaks && track_m + access.wire_m < access.drain_m + kWireAhead_m)
            return now.tool == Tool::wire ? Act::feedWire : Act::selectWire;
        if (now.tool != Tool::drain) return Act::selectDrain;
        return leaks ? Act::shiftDrainIn : Act::shiftDrainOut;
    }
    if (deep) return now.tool == Tool::wire ? Act::withdrawWire : Act::selectWire;
    if (const std::optional<Act> act = toFreeWire(progress, now)) return *act;
    if (access.dilator_m > 0.0) return now.tool == Tool::dilator ? Act::withdrawDilator : Act::selectDilator;
    return now.tool == Tool::drain ? Act::pushDrain : Act::selectDrain;
}

}  // namespace

Act nextAct(const Progress& progress, const TickOutput& now, const Equipment& equipment) noexcept {
    const bool pictures = progress.step == Step::contrast || progress.step == Step::finalPicture;
    if (equipment.injected_m3_per_s > 0.0 && !pictures) return Act::stopInjecting;
    if (equipment.anaesthetic_m3_per_s > 0.0 && progress.step != Step::anaesthetise)
        return Act::stopInjecting;
    if (equipment.xray.pedal && progress.step == Step::done) return Act::releasePedal;
    if (now.tool_awaits_exit && progress.step != Step::done) return Act::liftOff;
    if (progress.step < Step::guide && progress.step != Step::anaesthetise &&
        haptics::isNeedleTool(now.tool) && now.phase != haptics::Phase::outside)
        return progress.course == Course::drainage ? Act::withdrawNumbingNeedle : Act::withdrawToRetry;
    switch (progress.step) {
        case Step::reviewCase:
            return Act::answer;
        case Step::findGap:
            return toFindGap(progress, now);
        case Step::findDuct:
            return toFindDuct(progress, now);
        case Step::anaesthetise:
            return toNumb(progress, now, equipment);
        case Step::incise:
            return toIncise(progress, now);
        case Step::guide:
        case Step::advance:
            return toPuncture(progress, now);
        case Step::aspirate:
            return toTipInDuct(progress, now).value_or(Act::aspirate);
        case Step::contrast:
            return toPicture(progress, now, equipment);
        case Step::wire:
            return toPassWire(progress, now);
        case Step::dilate:
            return toDilate(progress, now);
        case Step::drain:
            return toPlaceDrain(progress, now);
        case Step::finalPicture:
            // The medium goes in through the drain's hub, where the wire comes out.
            if (now.access.wire_in) return now.tool == Tool::wire ? Act::clearDrain : Act::selectWire;
            return equipment.xray.pedal ? Act::injectDrain : Act::pressPedal;
        case Step::done:
            break;
    }
    return Act::finish;
}

std::string prompt(Act act, const Controls& c) {
    switch (act) {
        case Act::liftOff:
            return fmt::format("Lift the tool off, it feels nothing yet: {}.", c.pull);
        case Act::selectFinger:
            return fmt::format("Take the finger: {}.", c.finger);
        case Act::pressGap:
            return fmt::format("Press the gap between two ribs at the entry: {}.", c.push);
        case Act::pressUpperRib:
            return fmt::format("Keep pressing and feel the rib above: {}.", c.move);
        case Act::pressLowerRib:
            return fmt::format("Keep pressing and feel the rib below: {}.", c.move);
        case Act::answer:
            return fmt::format("Read the case and answer: {} for yes, {} for no.", c.yes, c.no);
        case Act::selectProbe:
            return fmt::format("Take the probe: {}.", c.probe);
        case Act::holdBreath:
            return fmt::format("Have the breath held: {}.", c.hold);
        case Act::placeProbe:
            return fmt::format("Put the probe flat on the gap: {}.", c.push);
        case Act::shiftProbe:
            return fmt::format("Bring the target duct into the picture: {}.", c.move);
        case Act::turnProbe:
            return fmt::format("A rib or gas hides the duct. Turn: {}.", c.turn);
        case Act::holdProbeStill:
            return "The duct is in the picture: keep the probe still for a second.";
        case Act::selectSyringe:
            return fmt::format("Take the needle, with local anaesthetic in its syringe: {}.", c.needle);
        case Act::enterWheal:
            return fmt::format("Push the needle just through the skin: {}.", c.push);
        case Act::numbSkin:
            return fmt::format("Inject 0.5 ml of local anaesthetic under the skin: {}.", c.numb);
        case Act::pushToCapsule:
            return fmt::format("Push on, to just before the liver: {}.", c.push);
        case Act::numbCapsule:
            return fmt::format("Inject 2 ml in front of the liver's capsule: {}.", c.numb);
        case Act::pullNeedleBack:
            return fmt::format("The tip is too deep. Draw the needle back a little: {}.", c.pull);
        case Act::withdrawNumbingNeedle:
            return fmt::format("Draw the needle out of the skin: {}.", c.pull);
        case Act::aimGuide:
            return fmt::format("Move the probe until the dashed line meets the duct: {}.", c.move);
        case Act::parkProbe:
            return fmt::format("Leave the probe in its place: {}.", c.park);
        case Act::liftProbe:
            return fmt::format("Take the probe off the skin, to place it anew: {}.", c.lift);
        case Act::selectScalpel:
            return fmt::format("Take the scalpel: {}.", c.scalpel);
        case Act::cut:
            return fmt::format("Cut at the entry (in, 4 mm along, out): {}.", c.push);
        case Act::selectGuide:
            return fmt::format("Take the needle to the guide: {}.", c.guide);
        case Act::snapNeedle:
            return fmt::format("Lay the needle into the probe's guide: {}.", c.move);
        case Act::enterSkin:
            return fmt::format("Push the needle along the guide into the skin: {}.", c.push);
        case Act::advance:
            return fmt::format("Push until the duct gives way in the picture: {}.", c.push);
        case Act::withdrawToRetry:
            return fmt::format("Draw the needle out, and puncture again: {}.", c.pull);
        case Act::pressPedal:
            return fmt::format("Switch the X-rays on: {}.", c.pedal);
        case Act::seekDuct:
            return fmt::format("Move the needle until its tip is in the duct: {}.", c.push);
        case Act::aspirate:
            return fmt::format("Draw with the syringe until bile comes: {}.", c.aspirate);
        case Act::inject:
            return fmt::format("Inject a little contrast medium: {}.", c.inject);
        case Act::selectWire:
            return fmt::format("Take the guide wire: {}.", c.wire);
        case Act::feedWire:
            return fmt::format("Push the wire 20 mm down the duct: {}.", c.push);
        case Act::pullWireBack:
            return fmt::format("Draw the wire back: {}.", c.pull);
        case Act::selectNeedle:
            return fmt::format("Take the needle, to draw it out over the wire: {}.", c.needle);
        case Act::withdrawNeedle:
            return fmt::format("Draw the needle out over the wire: {}.{}", c.pull, c.regrip);
        case Act::selectDilator:
            return fmt::format("Take the dilator: {}.", c.dilator);
        case Act::pushDilator:
            return fmt::format("Push the dilator over the wire to the duct: {}.", c.push);
        case Act::withdrawDilator:
            return fmt::format("Draw the dilator out over the wire: {}.{}", c.pull, c.regrip);
        case Act::selectDrain:
            return fmt::format("Take the drain: {}.", c.drain);
        case Act::pushDrain:
            return fmt::format("Push the drain over the wire into the duct: {}.", c.push);
        case Act::withdrawDrain:
            return fmt::format("Not dilated yet. Draw the drain out: {}.{}", c.pull, c.regrip);
        case Act::withdrawWire:
            return fmt::format("Draw the wire out until the drain curls: {}.{}", c.pull, c.regrip);
        case Act::clearDrain:
            return fmt::format("Draw the wire all the way out of the drain: {}.{}", c.pull, c.regrip);
        case Act::shiftDrainIn:
            return fmt::format("Side holes before the duct. Push the drain on: {}.", c.push);
        case Act::shiftDrainOut:
            return fmt::format("Side holes beyond the duct. Draw the drain back: {}.", c.pull);
        case Act::rewireDrain:
            return fmt::format("The drain leaks. Put the guide wire into it again: {}.", c.wire);
        case Act::straightenDrain:
            return fmt::format("Push the wire into the drain's loop: {}.{}", c.push, c.regrip);
        case Act::injectDrain:
            return fmt::format("Inject contrast medium through the drain: {}.", c.inject);
        case Act::stopInjecting:
            return fmt::format("Stop the injection: {}.", c.stop);
        case Act::releasePedal:
            return fmt::format("Switch the X-rays off: {}.", c.release);
        case Act::finish:
            break;
    }
    return "All steps are done.";
}

std::string hint(Act act, const Controls& c) {
    const std::string to_skin = c.skin.empty() ? "" : fmt::format("To reach the skin, {}. ", c.skin);
    switch (act) {
        case Act::liftOff:
            return fmt::format("Draw it away until it moves freely: {}.", c.pull);
        case Act::pressGap:
            return c.skin.empty() ? fmt::format("A gap feels soft: {}.", c.push)
                                  : to_skin + "A gap feels soft.";
        case Act::pressUpperRib:
        case Act::pressLowerRib:
            return fmt::format("A rib feels hard. Keep pressing and slide: {}.", c.move);
        case Act::placeProbe:
            return c.skin.empty() ? fmt::format("The whole face must touch: {}.", c.push)
                                  : to_skin + "The whole face must touch it.";
        case Act::shiftProbe:
            return fmt::format("A duct is dark. To tilt, {}.", c.turn);
        case Act::turnProbe:
            return fmt::format("Turn a little, then wait: {}.", c.turn);
        case Act::aimGuide:
            return fmt::format("Shift the probe toward the arrow: {}.", c.move);
        case Act::enterWheal:
        case Act::pushToCapsule:
            return fmt::format("The liver's edge is the bright line: {}.", c.push);
        case Act::pullNeedleBack:
            return fmt::format("Anaesthetic this deep does not count: {}.", c.pull);
        case Act::cut:
            return fmt::format("A cut of 3 to 15 mm counts. Along the skin: {}.", c.move);
        case Act::snapNeedle:
            return fmt::format("Cross the rail slowly with the tip: {}.", c.move);
        case Act::advance:
        case Act::seekDuct:
            return fmt::format("The tip dents the duct, then enters: {}.", c.push);
        case Act::feedWire:
            return fmt::format("If it stops: {}, then push slowly.", c.pull);
        case Act::pushDilator:
        case Act::pushDrain:
            return fmt::format("It needs force, up to the wire's end: {}.{}", c.push, c.regrip);
        case Act::shiftDrainIn:
        case Act::shiftDrainOut:
            return fmt::format("The drain must stay over the wire: {}.", c.push);
        case Act::straightenDrain:
            return fmt::format("Halfway in, the drain straightens: {}.", c.push);
        case Act::enterSkin:
        case Act::withdrawToRetry:
        case Act::withdrawNeedle:
        case Act::withdrawDilator:
        case Act::withdrawDrain:
        case Act::withdrawWire:
        case Act::clearDrain:
            return fmt::format("To see how the expert does it, {}.", c.expert);
        default:
            return {};
    }
}

}  // namespace stylet::training
