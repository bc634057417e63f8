#include "app/trainer/session/session.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "app/trainer/session/instructor.h"

namespace stylet::trainer {

using haptics::EventRecord;
using haptics::NeedleEventKind;
using haptics::TickOutput;
using haptics::TickRecord;

namespace {

// Ticks kept for events that arrive after them. As many as fit into the ring of ticks from the haptics
// thread.
constexpr std::size_t kRecentTicks = 4096;
constexpr double kSyringeShown_s = 3.0;  // what the syringe drew, and how much it injected
constexpr double kRefusedShown_s = 20.0, kAnswerShown_s = 6.0;

// Returns why the simulation ignored an injected event, or nothing. `before`: the tick before it, to which
// start() has added the earlier events of the same tick.
std::string whyIgnored(const haptics::Command& command, const TickOutput& before) {
    using enum haptics::CommandKind;
    using patient::InterruptionKind;
    if (command.kind == move && before.patient_moved_m != Vec3(0.0)) return "the patient is moving already";
    if ((command.kind != cough && command.kind != sigh) || before.interruption == InterruptionKind::none)
        return {};
    return before.interruption == InterruptionKind::cough ? "a cough is under way" : "a sigh is under way";
}

// Adds to `now` what an injected event starts.
void start(const haptics::Command& command, TickOutput& now) {
    using enum haptics::CommandKind;
    if (command.kind == move) now.patient_moved_m = haptics::kStartleDisplacement_m;
    if (command.kind == cough) now.interruption = patient::InterruptionKind::cough;
    if (command.kind == sigh) now.interruption = patient::InterruptionKind::sigh;
}

}  // namespace

Session::Session(const patient::Patient& patient, const patient::PlannedPath& path,
                 const std::vector<std::string>& moments, double approach_distance_m,
                 records::RecordWriter* record, double dt_s)
    : patient_(patient),
      dt_s_(dt_s),
      entry_m_(path.entry_m),
      axis_(glm::normalize(path.target_m - path.entry_m)),
      awaited_(moments),
      approach_distance_m_(approach_distance_m),
      record_(record),
      fold_(patient, dt_s),
      procedure_(patient, path, dt_s),
      wounds_(dt_s),
      insertion_(patient),
      glow_(dt_s) {}

void Session::drain(haptics::LoopChannels& channels) {
    // Handle each event after its own tick and before the next tick, even if many ticks are waiting. Results
    // that depend on ticks and events are then the same in every run.
    TickRecord record;
    EventRecord event;
    while (channels.records.pop(record)) {
        while (channels.events.pop(event))
            unmatched_.push_back(event);
        update(record);
    }
    while (channels.events.pop(event))
        update(event);
    std::vector<TickRecord> flight;
    while (channels.flights.pop(flight))
        if (log_.flights.size() < kMaxFlights)
            log_.flights.push_back(flight);
        else
            ++log_.more_flights;
}

void Session::discardPending() {
    newly_pressed_ = new_faults_ = 0;
    executed_commands_.clear();
    new_injected_.clear();
    rearm_ = false;
}

// Tracks buttons, commands, re-arm requests and new faults.
void Session::watchUser(const TickRecord& record) {
    const TickOutput& now = record.output;
    const TickOutput before = recent_.empty() ? TickOutput{} : recent_.back();
    const std::uint32_t pressed = record.input.device.buttons;
    // A button that is already down at the first tick does not count as pressed.
    const std::uint32_t fresh = recent_.empty() ? 0 : pressed & ~pressed_;
    pressed_ = pressed;
    buttons_down_ = (record.input.device.flags & haptics::kDeviceReady) != 0 ? pressed : 0;
    newly_pressed_ |= fresh;
    if ((fresh & rearm_button_) != 0 && now.stage == haptics::ForceStage::off) rearm_ = true;
    rearm_acts_ += (fresh & rearm_button_) != 0;
    for (std::uint32_t i = 0; i < record.input.command_count; ++i) {
        rearm_acts_ += record.input.commands[i].kind == haptics::CommandKind::rearm;
        executed_commands_.push_back({record.input.commands[i], before, now});
    }
    new_faults_ |= now.faults & ~before.faults;
    log_.awaited_ticks = now.awaited != 0 && now.awaited == log_.awaited ? log_.awaited_ticks + 1 : 0;
    log_.awaited = now.awaited;
}

void Session::watchInstructor(const TickRecord& record) {
    TickOutput before = recent_.empty() ? TickOutput{} : recent_.back();
    for (std::uint32_t i = 0; i < record.input.command_count; ++i) {
        const haptics::Command& command = record.input.commands[i];
        std::string name = injectedName(command);
        if (name.empty()) continue;
        if (command.kind == haptics::CommandKind::lights) lights_out_ = command.value == 0;
        if (command.kind == haptics::CommandKind::bleed && !wounds_.bleed())
            name += ": no hole is in the skin";
        if (const std::string why = whyIgnored(command, before); !why.empty())
            name += ": not done, " + why;
        else
            start(command, before);
        new_injected_.push_back(name);
        log_.events.push_back({record.output.tick, "injected", std::move(name)});
    }
}

void Session::note(std::string kind, std::string text) {
    assert(training::isEventKind(kind));
    if (kind == "bookmark" && record_) record_->bookmark({log_.last_tick, text});
    log_.events.push_back({log_.last_tick, std::move(kind), std::move(text)});
    if (noted_) noted_(log_);
}

void Session::showAnswer(std::string text) {
    answer_ = std::move(text);
    answered_at_ = log_.last_tick;
}

void Session::watchForce(const TickRecord& record) {
    if (record.output.tool_force.force_n == Vec3(0.0)) return;
    ControllerLog& controller = log_.controller;
    const double added_n = glm::length(record.output.controller_device_n);
    ++controller.contact_ticks;
    controller.felt_ticks += added_n > kFelt_n;
    controller.peak_n = std::max(controller.peak_n, added_n);
    controller.sum_n2 += added_n * added_n;
}

void Session::update(const TickRecord& record) {
    const TickOutput& now = record.output;
    matchEvents();
    log_.state_hash = fold_.step(record.input, now);
    if (record_) record_->add(record.input, now.tick, log_.state_hash);
    ++log_.ticks;
    log_.last_tick = now.tick;
    log_.equipment_used = fold_.begun();
    log_.dose = fold_.dose();
    log_.contrast = fold_.contrast().status();
    log_.faults |= now.faults;
    watchUser(record);
    watchInstructor(record);
    watchForce(record);
    wounds_.update(now);
    insertion_.update(now);
    log_.lateral_cut_m = now.lateral_cut_m;
    const bool felt = haptics::isNeedleTool(now.tool);  // an assistant may hold the needle in the body
    if (felt) log_.peak_force_n = std::max(log_.peak_force_n, std::fabs(now.force_n));
    if (felt && now.phase != haptics::Phase::outside) {
        if (!log_.deepest || now.depth_m > log_.deepest->depth_m) log_.deepest = now;
        log_.curve.push_back({now.tick, now.depth_m, now.force_n, now.phase, now.tissue, now.breath_held});
    }
    recent_.push_back(now);
    if (recent_.size() > kRecentTicks) recent_.pop_front();
    procedure_.update(now, fold_);
    updateProgress();
    glow_.update(now.tick, log_.progress);
    if (truth_) {
        truth_->update(now);
        log_.truth = truth_->reading();
    }
    if (haptics::isNeedleTool(now.tool) &&
        glm::dot(now.patient_from_needle.position_m - entry_m_, axis_) >= -approach_distance_m_)
        note("approach", now);
    watchXray(now);
    matchEvents();
    if (watcher_) watcher_(now, log_);
}

void Session::watchXray(const TickOutput& now) {
    const training::XrayState& xray = fold_.equipment().xray;
    if (xray.pulses > 0) note("xray", now);
    if (pedal_ && !xray.pedal && fold_.contrast().begun()) note("contrast", now);
    pedal_ = xray.pedal;
}

void Session::update(const EventRecord& event) {
    unmatched_.push_back(event);
    matchEvents();
}

void Session::update(const haptics::TickInput& input, const haptics::TickOutput& output,
                     const haptics::NeedleEvents& events) {
    update(TickRecord{input, output});
    for (int i = 0; i < events.count; ++i)
        update(haptics::EventRecord{output.tick, events.list[std::size_t(i)]});
}

void Session::matchEvents() {
    while (!unmatched_.empty() && log_.ticks > 0 && unmatched_.front().tick <= log_.last_tick) {
        const EventRecord event = unmatched_.front();
        unmatched_.pop_front();
        const auto shown =
            std::lower_bound(recent_.begin(), recent_.end(), event.tick,
                             [](const TickOutput& o, std::uint64_t tick) { return o.tick < tick; });
        onEvent(event, *shown);
    }
}

void Session::onEvent(const EventRecord& record, const TickOutput& shown) {
    const haptics::NeedleEvent& event = record.event;
    wounds_.update(event);
    insertion_.update(event);
    const bool cut = event.kind == NeedleEventKind::puncture;
    const bool target_cut =
        cut && event.border.to == haptics::Tissue::duct && !log_.target_cut && targetAtTip(shown);
    procedure_.update(event, shown, target_cut);
    updateProgress();
    if (!cut && event.kind != NeedleEventKind::entry) return;
    log_.punctures.push_back(record);
    // A cut happens between two ticks, so the force of neither tick contains the peak.
    log_.peak_force_n = std::max(log_.peak_force_n, std::fabs(event.force_before_n));
    note(std::string(patient::tissueName(event.border.to)), shown);
    if (target_cut) log_.target_cut = shown;
}

void Session::updateProgress() {
    log_.progress = procedure_.progress();
    log_.score = procedure_.score();
    for (training::SessionEvent& event : procedure_.consumeEvents())
        log_.events.push_back(std::move(event));
}

void Session::setInstruments(const haptics::InstrumentSet& instruments) {
    haptics::ToolSettings tools;
    haptics::equip(tools, instruments);
    procedure_.setTools(tools);
    needle_ = instruments.needle.shape;
    wounds_.setNeedleRadius(needle_.radius_m());
    probe_.transducer = instruments.probe.transducer;
    if (const auto* face = std::get_if<haptics::ProbeSettings>(&instruments.probe.force))
        probe_.length_m = face->length_m, probe_.curvature_m = face->curvature_m;
}

FrameState Session::frameState(const TickOutput& tick) const {
    FrameState seen{tick, needle_, probe_, access_, wounds_.wounds(), fold_.equipment(), fold_.dose()};
    seen.depots = fold_.anaesthetic().depots();
    seen.rearm_acts = rearm_acts_;
    seen.progress = log_.progress;
    seen.patient_case = case_;
    seen.lights_out = lights_out_;
    seen.glow = glow_.now();
    seen.insertion = insertion_.insertion();
    seen.truth = log_.truth;
    seen.rest_due = rest_due_;
    seen.difficulty = difficulty_;
    // A picture may show a tick before the event.
    const auto isRecent = [&](std::uint64_t at, double shown_s) {
        return tick.tick < at || double(tick.tick - at) * dt_s_ < shown_s;
    };
    const training::Aspiration& last = fold_.aspiration();
    if (last.count > 0 && isRecent(last.tick, kSyringeShown_s)) seen.drawn = last.drawn;
    if (const auto& injection = fold_.injection(); injection && isRecent(injection->tick, kSyringeShown_s))
        seen.syringe = {injection->anaesthetic,
                        injection->anaesthetic ? fold_.dose().anaesthetic_m3 : fold_.dose().contrast_m3};
    if (double(tick.tick) * dt_s_ < kRefusedShown_s) seen.start_refused = start_refused_;
    if (isRecent(answered_at_, kAnswerShown_s)) seen.answer = answer_;
    return seen;
}

void Session::note(const std::string& moment, const TickOutput& shown) {
    const auto awaited = std::find(awaited_.begin(), awaited_.end(), moment);
    if (awaited == awaited_.end()) return;
    awaited_.erase(awaited);
    log_.captures.push_back({moment, frameState(shown)});
}

bool Session::targetAtTip(const TickOutput& shown) const {
    const std::uint8_t id = patient_.package().labels.nearestOr(shown.tip_reference_m, 0);
    const patient::Label* label = patient_.label(id);
    return label && label->role == patient::Role::target;
}

std::vector<Capture> Session::newCaptures() {
    std::vector<Capture> fresh(log_.captures.begin() + std::ptrdiff_t(handed_out_), log_.captures.end());
    handed_out_ = log_.captures.size();
    return fresh;
}

}  // namespace stylet::trainer
