#include "app/trainer/view/notice.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "base/text.h"

namespace stylet::trainer {
namespace {

constexpr report::Colour kNoticeGlass{0.05, 0.07, 0.09}, kFrame{0.95, 0.72, 0.20}, kTitle{1.0, 0.80, 0.30},
    kNoticeText{0.93, 0.95, 0.96};
constexpr double kMargin_px = 30.0, kTitle_px = 46.0, kUnderTitle_px = 13.0, kBottom_px = 12.0;
constexpr double kPitch = 42.0 / 34.0;  // between lines, in ems

// Text of the first fault that keeps the force off. A line has space for only one.
std::string textOf(std::uint32_t bits) {
    for (const haptics::FaultText& fault : haptics::faultTexts())
        if ((bits & fault.bit & ~std::uint32_t(haptics::kFaultRingFull)) != 0) return fault.text;
    return "";
}

constexpr const char* kRefusedTitle = "A request was refused";

bool isAsking(const FrameState& seen) {
    return seen.patient_case && seen.progress.step == training::Step::reviewCase;
}

// The whole case, its open question and how to answer. It does not say which answers were right.
Notice makeCaseNotice(const FrameState& seen, const training::Controls& controls) {
    const int question = seen.progress.answered;
    Notice notice{"The case, question " + std::to_string(question + 1) + " of " +
                      std::to_string(training::kQuestionCount),
                  {"> " + std::string(questionText(training::Question(question))),
                   "> Yes: " + std::string(controls.yes) + ". No: " + std::string(controls.no) + "."},
                  true};
    if (!seen.start_refused.empty())
        notice.lines.push_back(std::string(kRefusedTitle) + ": " + seen.start_refused);
    // Last, because a long case may not fit.
    const std::vector<std::string> facts = training::describeCase(*seen.patient_case);
    notice.lines.emplace_back();
    notice.lines.insert(notice.lines.end(), facts.begin(), facts.end());
    return notice;
}

// What came, and the syringe's scale. Both can be seen in reality, so every difficulty shows them.
Notice makeSyringeNotice(const FrameState& seen) {
    Notice notice{"Syringe", {}};
    if (seen.drawn)
        notice.lines.push_back(capitalised(enumName(training::kDrawnNames, *seen.drawn)) + " comes.");
    if (seen.syringe)
        notice.lines.push_back(fmt::format(
            "{}: {:.1f} ml injected.", seen.syringe->anaesthetic ? "Local anaesthetic" : "Contrast medium",
            training::kMlPerM3 * seen.syringe->injected_m3));
    return notice;
}

}  // namespace

std::vector<std::string> wrapped(report::Canvas& canvas, const std::string& text,
                                 const report::TextStyle& style, double width_px) {
    const auto fits = [&](const std::string& line) { return canvas.textWidth(line, style) <= width_px; };
    std::vector<std::string> lines{""};
    std::size_t at = 0;
    while (at < text.size()) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        const std::string word = text.substr(at, end - at);
        const std::string longer = lines.back().empty() ? word : lines.back() + ' ' + word;
        at = end + 1;
        if (fits(longer)) {
            lines.back() = longer;
            continue;
        }
        if (!lines.back().empty()) lines.emplace_back();
        if (fits(word)) {
            lines.back() = word;
            continue;
        }
        for (std::size_t i = 0; i < word.size();) {
            std::size_t next = i + 1;
            while (next < word.size() && (static_cast<unsigned char>(word[next]) & 0xc0u) == 0x80u)
                ++next;  // inside a character of UTF-8
            const std::string letter = word.substr(i, next - i);
            if (!lines.back().empty() && !fits(lines.back() + letter)) lines.emplace_back();
            lines.back() += letter;
            i = next;
        }
    }
    return lines;
}

std::optional<Notice> makeNotice(const FrameState& seen, Attention attention, const std::string& rearm_act,
                                 const training::Controls& controls) {
    if (attention == Attention::away)
        return Notice{
            "Paused",
            {"The simulation is paused while you do not wear the headset or another program has the focus."}};
    if (seen.paused_by_instructor)
        return Notice{"Paused", {"The instructor has paused the attempt and will resume it."}};
    if (seen.ticks_paused && seen.return_distance_m >= haptics::kDeviceNotReady_m)
        return Notice{"Paused", {"The tool is not tracked: move it to where the headset sees it."}};
    if (seen.ticks_paused && seen.return_distance_m > 0.0)
        return Notice{"Paused",
                      {"Move the tool back to where you left it: " +
                       std::to_string(std::max(1L, std::lround(1e3 * seen.return_distance_m))) + " mm."}};
    if ((seen.tick.awaited & haptics::kFaultAwayFromNeedle) != 0)
        return Notice{"The tool has jumped",
                      {"The needle is still in the patient: move the tool back to it, or draw it out."}};
    const haptics::ForceStage stage = seen.tick.stage;
    const bool off = stage == haptics::ForceStage::off || stage == haptics::ForceStage::fading;
    if (isAsking(seen) && (rearm_act.empty() || !off)) return makeCaseNotice(seen, controls);
    if (!seen.start_refused.empty() && (rearm_act.empty() || !off))
        return Notice{kRefusedTitle, {seen.start_refused}};
    if (seen.tick.tick > 0 && seen.tick.tool_awaits_exit && (rearm_act.empty() || !off))
        return Notice{"Lift the tool",
                      {"It feels nothing until it has been off the skin once: lift it, then go on."}};
    if (seen.rest_due && (rearm_act.empty() || !off))
        return Notice{"Time for a rest",
                      {"You have practised for a long time: rest your eyes and hand for a few minutes."}};
    if ((seen.drawn || seen.syringe) && (rearm_act.empty() || !off)) return makeSyringeNotice(seen);
    if (!seen.expert_note.empty() && (rearm_act.empty() || !off))
        return Notice{"Expert", {capitalised(seen.expert_note) + "."}};
    const bool stalled = seen.picture_stall_s > 0.0;
    const std::string stall =
        "The picture had stopped for " + std::to_string(std::lround(seen.picture_stall_s)) + " s";
    if (rearm_act.empty() || !off) {
        if (!stalled) return std::nullopt;
        return Notice{"The picture moves again", {stall + "; the attempt continued."}};
    }
    // Without a picture the force is removed as if the headset were off.
    const bool by_stall = stalled && (seen.tick.faults & haptics::kFaultNotFocused) != 0;
    const std::string why = capitalised(by_stall ? stall : textOf(seen.tick.faults));
    Notice notice{"The force is off", {"To resume: " + rearm_act + "."}};
    if (!why.empty()) notice.lines.insert(notice.lines.begin(), why + ".");
    if (!seen.start_refused.empty())
        notice.lines.push_back(std::string(kRefusedTitle) + ": " + seen.start_refused);
    return notice;
}

Notice makeNotice(RoomWarning warning, const std::string& rearm_act) {
    if (warning == RoomWarning::lost)
        return {"The room has moved", {"The force is off.", "Register the device again: stylet register."}};
    return {warning == RoomWarning::moved ? "The room has moved" : "Before you begin",
            {"The force is off. Is the tool where you feel it? Then: " + rearm_act +
             ". If not: stylet register."}};
}

double letterAngle_rad(double px_per_rad) {
    return std::max(kMinText_rad, kMinText_px / px_per_rad);
}

NoticePanel::NoticePanel() : canvas_(std::in_place, kWidth, kHeight, kNoticeGlass) {}

void NoticePanel::show(const Notice& notice) {
    if (revision_ > 0 && notice == shown_) return;
    if (notice.tall != shown_.tall)
        canvas_.emplace(kWidth, notice.tall ? kTallHeight : kHeight, kNoticeGlass);
    shown_ = notice;
    canvas_->rectangle(0.0, 0.0, kWidth, height(), kNoticeGlass);
    canvas_->rectangle(0.0, 0.0, kWidth, 8.0, kFrame);
    double y = kMargin_px + kTitle_px;
    canvas_->text({kMargin_px, y}, notice.title, {.size = kTitle_px, .colour = kTitle, .bold = true});
    y += kUnderTitle_px;
    letter_px_ = kLetter_px;
    std::vector<std::string> lines = breakLines(notice.lines);
    while (letter_px_ > kSmallest_px &&
           y + kPitch * letter_px_ * double(lines.size()) > height() - kBottom_px - 0.3 * letter_px_) {
        letter_px_ -= 1.0;
        lines = breakLines(notice.lines);
    }
    for (const std::string& line : lines)
        canvas_->text({kMargin_px, y += kPitch * letter_px_}, line,
                      {.size = letter_px_, .colour = kNoticeText});
    filled_ = std::min(height(), int(std::ceil(y + 0.3 * letter_px_ + kBottom_px)));
    canvas_->pixels(rgba_);
    // What lies behind the empty rows stays visible.
    std::fill(rgba_.begin() + std::ptrdiff_t(filled_) * kWidth * 4, rgba_.end(), std::uint8_t(0));
    ++revision_;
}

std::vector<std::string> NoticePanel::breakLines(const std::vector<std::string>& texts) {
    std::vector<std::string> lines;
    for (const std::string& text : texts)
        for (std::string& line :
             wrapped(*canvas_, text, {.size = letter_px_, .colour = kNoticeText}, kWidth - 2.0 * kMargin_px))
            lines.push_back(std::move(line));
    return lines;
}

double NoticePanel::width_m(double distance_m, double letter_rad) {
    return kWidth / kLetter_px * distance_m * std::tan(letter_rad);
}

}  // namespace stylet::trainer
