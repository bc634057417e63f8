#include "app/trainer/session/insertion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stylet::trainer {

using haptics::NeedleEvent;
using haptics::NeedleEventKind;

void InsertionLog::update(const haptics::TickOutput& tick) {
    if (tick.phase == haptics::Phase::outside) {
        open_ = false;
        on_skin_.clear();
        return;
    }
    if (!(tick.depth_m >= 0.0) || tick.depth_m > kDeepest_m) return;
    std::vector<Insertion::Felt>& felt = open_ ? insertion_.felt : on_skin_;
    const Insertion::Felt now{float(tick.depth_m), float(std::fabs(tick.force_n))};
    const auto stepOf = [](float depth_m) { return long(double(depth_m) / kStep_m); };
    if (felt.empty() || stepOf(now.depth_m) > stepOf(felt.back().depth_m))
        felt.push_back(now);
    else if (stepOf(now.depth_m) == stepOf(felt.back().depth_m))
        felt.back().force_n = std::max(felt.back().force_n, now.force_n);
}

void InsertionLog::update(const NeedleEvent& event) {
    const bool cut = event.kind == NeedleEventKind::puncture;
    if (!cut && event.kind != NeedleEventKind::entry && event.kind != NeedleEventKind::sideways) return;
    if (!open_) {
        insertion_ = {{}, std::exchange(on_skin_, {})};
        open_ = true;
    }
    std::vector<Passed>& passed = insertion_.passed;
    const haptics::Border& border = event.border;
    while (!passed.empty() && passed.back().depth_m > border.depth_m)
        passed.pop_back();
    const patient::Label* label = patient_->label(border.to_label);
    std::string name = label ? label->name : std::string(patient::tissueName(border.to));
    if (!passed.empty() && passed.back().name == name) return;
    if (passed.size() == kMaxPassed) passed.erase(passed.begin());
    passed.push_back(
        {border.depth_m, border.to, event.role, std::move(name), cut ? event.force_before_n : 0.0});
}

}  // namespace stylet::trainer
