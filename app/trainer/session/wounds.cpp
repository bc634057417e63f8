#include "app/trainer/session/wounds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace stylet::trainer {

namespace {

constexpr double kSameHole_m = 0.002;
constexpr std::size_t kMaxHoles = 6;
// Blood from a liver vein runs out along the shaft: first a drop at once, then a pool that grows ever more
// slowly.
constexpr Vec3 kDown{0.0, -1.0, 0.0};  // for a patient who lies on the back
constexpr double kFirstDrop_m = 0.003, kPoolGrowth_m = 0.0035, kLargestPool_m = 0.020;

}  // namespace

void WoundLog::update(const haptics::TickOutput& tick) {
    tick_ = tick.tick;
    if (tick.incision_count > 0) {
        incisions_.resize(std::size_t(tick.incision_count));
        incisions_.back() = tick.newest_incision;
    }
    // The skin is not open while the tip is still tenting it.
    const bool on_skin = tick.phase == haptics::Phase::tenting && tick.tissue == patient::Tissue::air;
    const bool needle = haptics::isNeedleTool(tick.tool) || tick.access.needle_in;
    const bool inside = needle && tick.phase != haptics::Phase::outside && !on_skin;
    if (inside && !inside_) {
        const auto same = [&](const Hole& h) {
            return glm::length(h.reference_m - tick.tip_reference_m) < kSameHole_m;
        };
        const auto found = std::find_if(holes_.begin(), holes_.end(), same);
        if (found != holes_.end()) {
            std::rotate(found, found + 1, holes_.end());  // the last hole is the one in use
        } else {
            if (holes_.size() == kMaxHoles) holes_.erase(holes_.begin());
            holes_.push_back({tick.tip_reference_m, needle_radius_m_, false, 0});
        }
    }
    inside_ = inside;
}

void WoundLog::update(const haptics::NeedleEvent& event) {
    const bool opened = event.kind == haptics::NeedleEventKind::puncture ||
                        event.kind == haptics::NeedleEventKind::entry ||
                        event.kind == haptics::NeedleEventKind::sideways;
    if (opened && event.border.to == patient::Tissue::vessel) bleed();
}

bool WoundLog::bleed() {
    if (holes_.empty()) return false;
    Hole& hole = holes_.back();
    if (!hole.bleeds) hole.opened_tick = tick_;
    hole.bleeds = true;
    return true;
}

std::vector<Wound> WoundLog::wounds() const {
    std::vector<Wound> all;
    for (const haptics::Incision& cut : incisions_) {
        const Vec3 along = cut.end_reference_m - cut.begin_reference_m;
        const double length = glm::length(along);
        if (length > 0.0)
            all.push_back({WoundKind::incision, 0.5 * (cut.begin_reference_m + cut.end_reference_m),
                           0.5 * length, along / length});
    }
    for (const Hole& hole : holes_)
        all.push_back({WoundKind::puncture, hole.reference_m, hole.radius_m});
    for (const Hole& hole : holes_) {
        if (!hole.bleeds) continue;
        const double since_s = dt_s_ * double(tick_ - hole.opened_tick);
        const double radius = std::min(kFirstDrop_m + kPoolGrowth_m * std::sqrt(since_s), kLargestPool_m);
        all.push_back({WoundKind::blood, hole.reference_m, radius, kDown});
    }
    return all;
}

}  // namespace stylet::trainer
