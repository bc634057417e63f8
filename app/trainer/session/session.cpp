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

constexpr std::size_t kRecentTicks = 4096;  // as many as the ring between the threads can hold

}  // namespace

Session::Session(const patient::Patient& patient, const patient::PlannedPath& path,
                 const std::vector<std::string>& moments, double approach_distance_m,
                 records::RecordWriter* record, double dt_s)
    : patient_(patient),
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
    // An event is passed on after its own tick and before the next one, however much waits. Everything
    // computed from both is then reproducible.
    TickRecord record;
    EventRecord event;
    while (channels.records.pop(record)) {
        while (channels.events.pop(event))
            unsettled_.push_back(event);
        take(record);
    }
    while (channels.events.pop(event))
        take(event);
    std::vector<TickRecord> flight;
    while (channels.flights.pop(flight))
        if (log_.flights.size() < kMaxFlights)
            log_.flights.push_back(flight);
        else
            ++log_.more_flights;
}

void Session::forgetNews() {
    newly_pressed_ = new_faults_ = 0;
    taken_.clear();
    rearm_ = false;
}

bool Session::takeRearm() {
    return std::exchange(rearm_, false);
}

// Tracks buttons, commands, re-arm acts and new faults.
void Session::watchUser(const TickRecord& record) {
    const TickOutput& now = record.output;
    const TickOutput before = recent_.empty() ? TickOutput{} : recent_.back();
    const std::uint32_t pressed = record.input.device.buttons;
    // A button that is already down when the attempt begins was not pressed.
    const std::uint32_t fresh = recent_.empty() ? 0 : pressed & ~pressed_;
    pressed_ = pressed;
    held_ = (record.input.device.flags & haptics::kDeviceReady) != 0 ? pressed : 0;
    newly_pressed_ |= fresh;
    if ((fresh & rearm_button_) != 0 && now.stage == haptics::ForceStage::off) rearm_ = true;
    rearm_acts_ += (fresh & rearm_button_) != 0;
    for (std::uint32_t i = 0; i < record.input.command_count; ++i)
        rearm_acts_ += record.input.commands[i].kind == haptics::CommandKind::rearm;
    for (std::uint32_t i = 0; i < record.input.command_count; ++i)
        taken_.push_back({record.input.commands[i], before, now});
    new_faults_ |= now.faults & ~before.faults;
    log_.awaited_ticks = now.awaited != 0 && now.awaited == log_.awaited ? log_.awaited_ticks + 1 : 0;
    log_.awaited = now.awaited;
}

void Session::watchInstructor(const TickRecord& record) {
    for (std::uint32_t i = 0; i < record.input.command_count; ++i) {
        const haptics::Command& command = record.input.commands[i];
        std::string name = injectedName(command);
        if (name.empty()) continue;
        if (command.kind == haptics::CommandKind::lights) lights_out_ = command.value == 0;
        if (command.kind == haptics::CommandKind::bleed && !wounds_.bleed())
            name += ": no hole is in the skin";
        log_.events.push_back({record.output.tick, "injected", std::move(name)});
    }
}

void Session::note(std::string kind, std::string text) {
    assert(training::isEventKind(kind));
    if (kind == "bookmark" && record_) record_->bookmark({log_.last_tick, text});
    log_.events.push_back({log_.last_tick, std::move(kind), std::move(text)});
    if (noted_) noted_(log_);
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

void Session::take(const TickRecord& record) {
    const TickOutput& now = record.output;
    settleEvents();
    log_.state_hash = fold_.take(record.input, now);
    if (record_) record_->add(record.input, now.tick, log_.state_hash);
    ++log_.ticks;
    log_.last_tick = now.tick;
    log_.machines_used = fold_.begun();
    log_.dose = fold_.dose();
    log_.contrast = fold_.contrast().status();
    log_.faults |= now.faults;
    watchUser(record);
    watchInstructor(record);
    watchForce(record);
    wounds_.take(now);
    insertion_.take(now);
    log_.lateral_cut_m = now.lateral_cut_m;
    log_.peak_force_n = std::max(log_.peak_force_n, std::fabs(now.force_n));
    if (now.phase != haptics::Phase::outside) {
        if (!log_.deepest || now.depth_m > log_.deepest->depth_m) log_.deepest = now;
        log_.curve.push_back({now.tick, now.depth_m, now.force_n, now.phase, now.tissue, now.breath_held});
    }
    recent_.push_back(now);
    if (recent_.size() > kRecentTicks) recent_.pop_front();
    procedure_.take(now, fold_);
    takeProgress();
    glow_.take(now.tick, log_.progress);
    if (truth_) {
        truth_->take(now);
        log_.truth = truth_->reading();
    }
    if (haptics::holdsNeedle(now.tool) &&
        glm::dot(now.patient_from_needle.position_m - entry_m_, axis_) >= -approach_distance_m_)
        note("approach", now);
    watchXray(now);
    settleEvents();
    if (watcher_) watcher_(now, log_);
}

void Session::watchXray(const TickOutput& now) {
    const training::XrayState& xray = fold_.machines().xray;
    if (xray.pulses > 0) note("xray", now);
    if (pedal_ && !xray.pedal && fold_.contrast().begun()) note("contrast", now);
    pedal_ = xray.pedal;
}

void Session::take(const EventRecord& event) {
    unsettled_.push_back(event);
    settleEvents();
}

void Session::take(const haptics::TickInput& input, const haptics::TickOutput& output,
                   const haptics::NeedleEvents& events) {
    take(TickRecord{input, output});
    for (int i = 0; i < events.count; ++i)
        take(haptics::EventRecord{output.tick, events.list[std::size_t(i)]});
}

void Session::settleEvents() {
    while (!unsettled_.empty() && log_.ticks > 0 && unsettled_.front().tick <= log_.last_tick) {
        const EventRecord event = unsettled_.front();
        unsettled_.pop_front();
        const auto shown =
            std::lower_bound(recent_.begin(), recent_.end(), event.tick,
                             [](const TickOutput& o, std::uint64_t tick) { return o.tick < tick; });
        onEvent(event, *shown);
    }
}

void Session::onEvent(const EventRecord& record, const TickOutput& shown) {
    const haptics::NeedleEvent& event = record.event;
    wounds_.take(event);
    insertion_.take(event);
    const bool cut = event.kind == NeedleEventKind::puncture;
    const bool target_cut =
        cut && event.border.to == haptics::Tissue::duct && !log_.target_cut && targetAtTip(shown);
    procedure_.take(event, shown, target_cut);
    takeProgress();
    if (!cut && event.kind != NeedleEventKind::entry) return;
    log_.punctures.push_back(record);
    // A cut happens between two ticks, so neither tick's force contains its peak.
    log_.peak_force_n = std::max(log_.peak_force_n, std::fabs(event.force_before_n));
    note(std::string(patient::tissueName(event.border.to)), shown);
    if (target_cut) log_.target_cut = shown;
}

void Session::takeProgress() {
    log_.progress = procedure_.progress();
    log_.score = procedure_.score();
    for (training::SessionEvent& event : procedure_.takeEvents())
        log_.events.push_back(std::move(event));
}

Seen Session::seen(const TickOutput& tick) const {
    Seen seen{tick, wounds_.wounds(), fold_.machines(), fold_.dose()};
    seen.rearm_acts = rearm_acts_;
    seen.progress = log_.progress;
    seen.lights_out = lights_out_;
    seen.glow = glow_.now();
    seen.insertion = insertion_.insertion();
    seen.truth = log_.truth;
    seen.rest_due = rest_due_;
    seen.difficulty = difficulty_;
    return seen;
}

void Session::note(const std::string& moment, const TickOutput& shown) {
    const auto awaited = std::find(awaited_.begin(), awaited_.end(), moment);
    if (awaited == awaited_.end()) return;
    awaited_.erase(awaited);
    log_.moments.push_back({moment, seen(shown)});
}

bool Session::targetAtTip(const TickOutput& shown) const {
    const std::uint8_t id = patient_.package().labels.nearestOr(shown.tip_reference_m, 0);
    const patient::Label* label = patient_.label(id);
    return label && label->role == patient::Role::target;
}

std::vector<Moment> Session::newMoments() {
    std::vector<Moment> fresh(log_.moments.begin() + std::ptrdiff_t(handed_out_), log_.moments.end());
    handed_out_ = log_.moments.size();
    return fresh;
}

}  // namespace stylet::trainer
