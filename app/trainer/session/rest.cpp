#include "app/trainer/session/rest.h"

#include <algorithm>
#include <cmath>

namespace stylet::trainer {

double sinceRest_s(std::span<const WorkPeriod> work, double now_s) {
    double sum_s = 0.0, begins_s = now_s;
    for (auto span = work.rbegin(); span != work.rend() && begins_s - span->end_s < kRest_s; ++span) {
        sum_s += std::max(0.0, std::min(span->end_s, begins_s) - span->begin_s);
        begins_s = std::min(begins_s, span->begin_s);
    }
    return sum_s;
}

bool RestWatch::update(double now_s, bool works, bool inside) {
    const double passed_s = begun_ ? std::max(0.0, now_s - last_s_) : 0.0;
    begun_ = true;
    last_s_ = now_s;
    if (works)
        worked_s_ += passed_s, idle_s_ = 0.0;
    else
        idle_s_ += passed_s;
    if (idle_s_ >= kRest_s) worked_s_ = 0.0, suggested_ = false;
    if (inside || now_s - suggested_s_ >= kRestShown_s) shown_ = false;
    if (suggested_ || inside || worked_s_ < kRestAfter_s) return false;
    suggested_ = shown_ = true;
    suggested_s_ = now_s;
    return true;
}

std::string restAdvice(double worked_s) {
    return "for " + std::to_string(std::lround(worked_s / 60.0)) +
           " minutes without a break: rest eyes and hand for a few minutes";
}

}  // namespace stylet::trainer
