#include "tests/haptics/naive_needle.h"

#include <algorithm>
#include <cmath>

namespace stylet::test {

using patient::Tissue;

NaiveNeedle::NaiveNeedle(const Layers& layers, const patient::TissueTable& table,
                         const haptics::NeedleSettings& settings)
    : layers_(layers), table_(table), settings_(settings), tissue_(layers.front().first) {
    x_m_ = 0.5 * kStep_m;
}

Tissue NaiveNeedle::at(double x_m) const {
    double end_m = 0.0;
    for (const auto& [tissue, thickness_m] : layers_) {
        end_m += thickness_m;
        if (x_m < end_m) return tissue;
    }
    return Tissue::air;
}

double NaiveNeedle::force() const {
    if (!isTentingAtTip()) return row(tissue_).stiffness_n_per_m * e_m_;
    const TentingBorder& h = tenting_.back();
    const double k = row(h.border.to).stiffness_n_per_m, d = x_m_ - h.x_m, t = row(h.border.to).cut_force_n;
    if (std::isinf(t)) return std::min(h.a0_n + k * d, std::max(settings_.max_force_n, h.a0_n));
    const double a1 = settings_.a1_share * k;
    return k * (k - a1) / (t - h.a0_n) * d * d + a1 * d + h.a0_n;
}

double NaiveNeedle::distanceToEvent() const {
    double nearest_m = HUGE_VAL;
    for (const double at_m : events_m_)
        nearest_m = std::min(nearest_m, std::fabs(at_m - x_m_));
    double border_m = 0.0;
    for (const auto& [tissue, thickness_m] : layers_) {
        border_m += thickness_m;
        nearest_m = std::min(nearest_m, std::fabs(border_m - x_m_));
    }
    return nearest_m;
}

void NaiveNeedle::to(double x_m) {
    const long long goal = std::llround(x_m / kStep_m);
    while (step_ != goal) {
        const bool in = goal > step_;
        step_ += in ? 1 : -1;
        x_m_ = (double(step_) + 0.5) * kStep_m;
        in ? forward(at(x_m_)) : backward(at(x_m_));
    }
}

void NaiveNeedle::slide(double travel_m) {
    const auto& t = row(tissue_);
    if (t.stiffness_n_per_m == 0.0) {
        e_m_ = 0.0;
        return;
    }
    const double most_m = t.friction_n * settings_.friction_scale / t.stiffness_n_per_m;
    e_m_ = std::clamp(e_m_ + travel_m, -most_m, most_m);
}

// Phases 2 and 4 without tenting.
void NaiveNeedle::enter(const Border& border, double force_n, bool cut) {
    const auto& t = row(border.to);
    tissue_ = border.to;
    e_m_ = 0.0;
    if (t.stiffness_n_per_m > 0.0)
        e_m_ = std::clamp(force_n, -t.friction_n * settings_.friction_scale,
                          t.friction_n * settings_.friction_scale) /
               t.stiffness_n_per_m;
    if (cut && border.to != Tissue::air) cuts_.push_back(border);
    events_m_.push_back(x_m_);
}

// Phase 4. `queued_after`: the tip has already passed another border.
void NaiveNeedle::meet(const Border& border, bool queued_after) {
    const auto& t = row(border.to);
    const double f = force();
    const bool is_cut = std::any_of(cuts_.begin(), cuts_.end(), [&](const Border& c) {
        return c.to == border.to && std::fabs(c.x_m - border.x_m) <= settings_.cut_reach_m;
    });
    const bool resists = t.stiffness_n_per_m > 0.0 && t.cut_force_n > f + 1e-6;
    if (std::isinf(t.cut_force_n) || (resists && !is_cut && !(queued_after && !t.membrane)))
        tenting_ = {{x_m_, f, border}};
    else
        enter(border, f, !resists);
}

void NaiveNeedle::forward(Tissue x) {
    const Border border{x_m_, x};
    // True if the tip returned to a tenting border from the tissue in front of it.
    const bool returned = isTentingAtTip() && x_m_ - 0.5 * kStep_m < tenting_.back().x_m;
    const Tissue front = !queue_.empty()     ? queue_.back().to
                         : !tenting_.empty() ? tenting_.back().border.to
                                             : tissue_;
    const bool on_bone = isTentingAtTip() && std::isinf(row(tenting_.back().border.to).cut_force_n);
    if (!on_bone && x != front) {
        if (tenting_.empty()) {
            meet(border, false);
        } else if (std::isinf(row(x).cut_force_n)) {
            tenting_.push_back({x_m_, force(), border});
        } else if (row(tenting_.back().border.to).membrane) {
            queue_.push_back(border);
        } else {
            const Border left = tenting_.back().border;
            const double f = force();
            tenting_.clear();
            enter(left, f, false);
            meet(border, false);
        }
    }
    if (returned || !isTentingAtTip()) {
        slide(kStep_m);
        if (returned) tenting_.back().a0_n = row(tissue_).stiffness_n_per_m * e_m_;
        return;
    }
    const TentingBorder h = tenting_.back();
    if (std::isinf(row(h.border.to).cut_force_n) || force() < row(h.border.to).cut_force_n) return;
    tenting_.clear();
    enter(h.border, row(h.border.to).cut_force_n, true);
    const std::vector<Border> queue = queue_;
    queue_.clear();
    for (std::size_t i = 0; i < queue.size(); ++i) {
        meet(queue[i], i + 1 < queue.size());
        if (tenting_.empty()) continue;
        queue_.assign(queue.begin() + long(i) + 1, queue.end());
        break;
    }
}

void NaiveNeedle::backward(Tissue x) {
    const bool on_bone = !tenting_.empty() && std::isinf(row(tenting_.back().border.to).cut_force_n);
    if (on_bone) {
        if (isTentingAtTip()) return;
        tenting_.pop_back();  // the border below the bone is still tenting
    }
    if (!queue_.empty()) {
        if (x != queue_.back().to) queue_.pop_back();
    } else if (!isTentingAtTip() && !tenting_.empty() && x != tenting_.back().border.to) {
        tenting_.clear();  // the tip is in front of the border again
    }
    if (isTentingAtTip()) return;
    if (tenting_.empty() && x != tissue_) enter({x_m_, x}, force(), false);
    slide(-kStep_m);
}

}  // namespace stylet::test
