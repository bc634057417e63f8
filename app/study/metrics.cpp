#include "app/study/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

namespace stylet::study {

using haptics::ExactEvent;
using haptics::ForcePiece;
using haptics::NeedleEventKind;
using haptics::Segment;
using patient::Tissue;

namespace {

std::size_t at(Tissue t) {
    return std::size_t(t);
}

// ---- the samples

double sampleDepth(const SteeringResult& s, std::size_t i) {
    return s.first_m + double(i) * s.step_m;
}

// The first sample at or behind `depth_m`. If the patients breathe, events lie on samples except for rounding
// errors.
std::size_t sampleFrom(const SteeringResult& s, double depth_m) {
    constexpr double kRounding = 1e-6;
    const double i = std::ceil((depth_m - s.first_m) / s.step_m - kRounding);
    return std::size_t(std::clamp(i, 0.0, double(s.full.samples_n.size())));
}

void measureSamples(const SteeringResult& s, PathResult& r) {
    const std::size_t count = s.full.samples_n.size();
    std::size_t equal = 0, largest = 0;
    double sum_n2 = 0.0;
    for (std::size_t bin = 0; bin < kPositionBins; ++bin) {
        const std::size_t end = count * (bin + 1) / kPositionBins;
        double bin_n2 = 0.0;
        for (std::size_t i = count * bin / kPositionBins; i < end; ++i) {
            const double error_n = s.partial.samples_n[i] - s.full.samples_n[i];
            bin_n2 += error_n * error_n;
            equal += error_n == 0.0;
            if (std::fabs(error_n) > r.sampled.max_n) r.sampled.max_n = std::fabs(error_n), largest = i;
        }
        r.position_n2[bin] = bin_n2;
        sum_n2 += bin_n2;
    }
    r.samples = std::uint32_t(count);
    r.sampled.rmse_n = std::sqrt(sum_n2 / double(count));
    r.sampled.max_at_m = sampleDepth(s, largest) - s.entry_m;
    r.sampled.equal_share = double(equal) / double(count);

    const std::vector<Segment>& segments = *s.full.segments;
    for (std::size_t j = 0; j < segments.size(); ++j) {
        const std::size_t end = j + 1 < segments.size() ? sampleFrom(s, segments[j + 1].begin_m) : count;
        for (std::size_t i = sampleFrom(s, segments[j].begin_m); i < end; ++i) {
            const double error_n = s.partial.samples_n[i] - s.full.samples_n[i];
            r.sum_n2[at(segments[j].tissue)] += error_n * error_n;
        }
    }
}

double largestErrorOutsideEvents(const SteeringResult& s, double window_m) {
    std::vector<double> events;
    for (const PatientForces* felt : {&s.full, &s.partial})
        for (const ExactEvent& e : felt->force->events)
            events.push_back(e.depth_m);
    std::sort(events.begin(), events.end());
    double largest_n = 0.0;
    std::size_t i = 0;
    const auto scanUntil = [&](std::size_t end) {
        for (; i < end; ++i)
            largest_n = std::max(largest_n, std::fabs(s.partial.samples_n[i] - s.full.samples_n[i]));
    };
    for (const double event_m : events) {
        scanUntil(sampleFrom(s, event_m - window_m));
        i = std::max(i, sampleFrom(s, event_m + window_m));
    }
    scanUntil(s.full.samples_n.size());
    return largest_n;
}

// ---- closed form

// c2 x^2 + c1 x + c0, with x measured from `begin_m`.
struct Curve {
    double c0 = 0.0, c1 = 0.0, c2 = 0.0;
};

Curve curveFrom(const ForcePiece& p, double begin_m) {
    const double x = begin_m - p.begin_m;
    return {(p.c2_n_per_m2 * x + p.c1_n_per_m) * x + p.c0_n, 2.0 * p.c2_n_per_m2 * x + p.c1_n_per_m,
            p.c2_n_per_m2};
}

bool sameForce(const ForcePiece& a, const ForcePiece& b) {
    if (a.c0_n != b.c0_n || a.c1_n_per_m != b.c1_n_per_m || a.c2_n_per_m2 != b.c2_n_per_m2) return false;
    return a.begin_m == b.begin_m || (a.c1_n_per_m == 0.0 && a.c2_n_per_m2 == 0.0);
}

ForceError measureExactly(const SteeringResult& s) {
    const std::vector<ForcePiece>&full = s.full.force->pieces, &partial = s.partial.force->pieces;
    if (full.empty() || partial.empty()) return {kNone, kNone, kNone, kNone};
    ForceError e;
    double sum_n2m = 0.0, equal_m = 0.0;
    std::size_t a = 0, b = 0;
    for (double x = s.begin_m; x < s.end_m;) {
        while (a + 1 < full.size() && full[a].end_m <= x)
            ++a;
        while (b + 1 < partial.size() && partial[b].end_m <= x)
            ++b;
        const double end = std::min({full[a].end_m, partial[b].end_m, s.end_m}), h = end - x;
        if (!(h > 0.0)) break;
        if (sameForce(full[a], partial[b])) {
            equal_m += h;
        } else {
            const Curve f = curveFrom(full[a], x), g = curveFrom(partial[b], x);
            const double c0 = g.c0 - f.c0, c1 = g.c1 - f.c1, c2 = g.c2 - f.c2;
            sum_n2m += h * (c0 * c0 + h * (c0 * c1 + h * ((c1 * c1 + 2.0 * c0 * c2) / 3.0 +
                                                          h * (c1 * c2 / 2.0 + h * c2 * c2 / 5.0))));
            const double top = c2 != 0.0 ? std::clamp(-0.5 * c1 / c2, 0.0, h) : 0.0;
            for (const double u : {0.0, top, h}) {
                const double error_n = std::fabs((c2 * u + c1) * u + c0);
                if (error_n > e.max_n) e.max_n = error_n, e.max_at_m = x + u - s.entry_m;
            }
        }
        x = end;
    }
    const double travel_m = s.end_m - s.begin_m;
    e.rmse_n = std::sqrt(std::max(0.0, sum_n2m) / travel_m);
    e.equal_share = equal_m / travel_m;
    return e;
}

// ---- borders

// The depths at which the path enters or leaves a tissue.
struct Surfaces {
    std::vector<double> at_m;
    std::size_t before_target = 0;
};

void findSurfaces(const std::vector<Segment>& segments, Tissue tissue, double target_m, Surfaces& out) {
    out.at_m.clear();
    for (std::size_t j = 0; j < segments.size(); ++j) {
        if (segments[j].tissue != tissue) continue;
        if (j > 0) out.at_m.push_back(segments[j].begin_m);
        if (j + 1 < segments.size()) out.at_m.push_back(segments[j + 1].begin_m);
    }
    out.before_target =
        std::size_t(std::upper_bound(out.at_m.begin(), out.at_m.end(), target_m) - out.at_m.begin());
}

struct Distances {
    double sum_m = 0.0, largest_m = 0.0;
    double min_m = std::numeric_limits<double>::infinity();
    std::size_t count = 0;
    void add(const Distances& d) {
        sum_m += d.sum_m, count += d.count;
        largest_m = std::max(largest_m, d.largest_m);
        min_m = std::min(min_m, d.min_m);
    }
};

// Applies if only one patient has a structure before the target. A structure of the other patient behind the
// target counts as the same one up to this distance.
constexpr double kSameStructure_m = 0.010;

Distances distances(const Surfaces& from, const Surfaces& to) {
    Distances d;
    for (std::size_t i = 0; i < from.before_target; ++i) {
        double nearest_m = std::numeric_limits<double>::infinity();
        for (const double other_m : to.at_m)
            nearest_m = std::min(nearest_m, std::fabs(other_m - from.at_m[i]));
        d.add({nearest_m, nearest_m, nearest_m, 1});
    }
    return d;
}

void measureBorders(const SteeringResult& s, PathResult& r) {
    Surfaces full, partial;
    Distances all;
    for (std::size_t t = at(Tissue::skin); t < kTissues; ++t) {
        findSurfaces(*s.full.segments, Tissue(t), s.end_m, full);
        findSurfaces(*s.partial.segments, Tissue(t), s.end_m, partial);
        BorderError& b = r.by_tissue[t];
        Distances d = distances(full, partial);
        d.add(distances(partial, full));
        if (d.count == 0) continue;  // not on the path
        const bool both = full.before_target > 0 && partial.before_target > 0;
        if (!both && d.min_m > kSameStructure_m) {
            b.missed = full.before_target > 0;
            b.invented = partial.before_target > 0;
            r.borders.missed = std::uint8_t(r.borders.missed + b.missed);
            r.borders.invented = std::uint8_t(r.borders.invented + b.invented);
            continue;
        }
        b.mean_m = d.sum_m / double(d.count);
        b.hausdorff_m = d.largest_m;
        all.add(d);
    }
    if (all.count == 0) return;
    r.borders.mean_m = all.sum_m / double(all.count);
    r.borders.hausdorff_m = all.largest_m;
}

// ---- events

bool isEntry(const ExactEvent& e) {
    return e.kind == NeedleEventKind::puncture || e.kind == NeedleEventKind::entry;
}

double firstEntryDepth(const std::vector<ExactEvent>& events, Tissue tissue) {
    for (const ExactEvent& e : events)
        if (isEntry(e) && e.tissue == tissue) return e.depth_m;
    return kNone;
}

// Partial minus full. Returns none if neither patient has the entry before the target.
double entryError(const SteeringResult& s, Tissue tissue) {
    const double full_m = firstEntryDepth(s.full.force->events, tissue),
                 partial_m = firstEntryDepth(s.partial.force->events, tissue);
    return std::min(full_m, partial_m) <= s.end_m ? partial_m - full_m : kNone;
}

enum class Skin { counts, ignored };

// Iterates over the entries into tissues before the target. If the patients breathe, a change of label within
// a tissue is an entry event too. The iterator skips those.
class EntryIterator {
  public:
    EntryIterator(const PatientForces& felt, double target_m, Skin skin)
        : events_(felt.force->events), target_m_(target_m), skin_(skin) {}

    const ExactEvent* next() {
        for (; at_ < events_.size() && events_[at_].depth_m <= target_m_; ++at_) {
            const ExactEvent& e = events_[at_];
            if (!isEntry(e)) continue;
            const bool stays = e.kind == NeedleEventKind::entry && e.tissue == tissue_;
            tissue_ = e.tissue;
            if (stays || (skin_ == Skin::ignored && e.tissue == Tissue::skin)) continue;
            ++at_;
            return &e;
        }
        return nullptr;
    }

  private:
    const std::vector<ExactEvent>& events_;
    double target_m_;
    Skin skin_;
    std::size_t at_ = 0;
    Tissue tissue_ = Tissue::air;
};

bool sameOrder(const SteeringResult& s, Skin skin) {
    EntryIterator full(s.full, s.end_m, skin), partial(s.partial, s.end_m, skin);
    // The first tissue is punctured from the air but entered from the skin. Without a skin, the two are
    // equivalent.
    for (bool any_way = skin == Skin::ignored;; any_way = false) {
        const ExactEvent *a = full.next(), *b = partial.next();
        if (!a || !b) return a == b;
        if (a->tissue != b->tissue || (a->kind != b->kind && !any_way)) return false;
    }
}

constexpr bool isPlain(Tissue t) {
    return t == Tissue::soft || t == Tissue::liver || t == Tissue::duct;
}
constexpr bool isMembrane(Tissue t) {
    return t == Tissue::skin || t == Tissue::fascia;
}

struct Layer {
    Tissue tissue;
    double begin_m, thickness_m;
    double cut_m;       // depth of the tip when it enters the layer
    bool new_membrane;  // a membrane that was punctured, not entered through an earlier cut
};

// Returns the layers that begin before `end_m`. The last one ends there.
std::vector<Layer> layersUpTo(double end_m, const PatientForces& felt) {
    std::vector<Layer> layers;
    EntryIterator iterator(felt, std::numeric_limits<double>::infinity(), Skin::counts);
    for (const ExactEvent* e = iterator.next(); e && e->border_depth_m < end_m; e = iterator.next())
        layers.push_back({e->tissue, e->border_depth_m, 0.0, e->depth_m,
                          isMembrane(e->tissue) && e->kind == NeedleEventKind::puncture});
    for (std::size_t n = 0; n < layers.size(); ++n)
        layers[n].thickness_m = (n + 1 < layers.size() ? layers[n + 1].begin_m : end_m) - layers[n].begin_m;
    return layers;
}

// True if both patients have the same layers in the same order, apart from plain layers that only one patient
// has. Left out one after the other, these must together be too thin to notice. Layers of one tissue that
// then touch are one layer, unless they are membranes: each has its own puncture. A layer entered before the
// target may lie just behind it in the other patient. The layer that holds the target in the full patient
// must be in both.
bool sameOrderNoticeable(const SteeringResult& s) {
    const double end_m = s.end_m + kNoticeableDistance_m;
    const std::vector<Layer> full = layersUpTo(end_m, s.full), partial = layersUpTo(end_m, s.partial);
    const auto isNeeded = [&](const std::vector<Layer>& layers, std::size_t n) {
        return n < layers.size() && layers[n].cut_m <= s.end_m;
    };
    std::size_t target = 0;
    while (isNeeded(full, target + 1))
        ++target;
    // The thickness left out last, behind the first i layers of `full` and j of `partial`, by the tissue that
    // the tip is in. The least of all ways to get there.
    using LeftOut = std::array<double, kTissues>;
    const std::size_t columns = partial.size() + 1;
    LeftOut never;
    never.fill(std::numeric_limits<double>::infinity());
    std::vector<LeftOut> left_out((full.size() + 1) * columns, never);
    left_out[0][std::size_t(Tissue::air)] = 0.0;
    for (std::size_t i = 0; i <= full.size(); ++i)
        for (std::size_t j = 0; j <= partial.size(); ++j) {
            const LeftOut now = left_out[i * columns + j];
            const auto passOne = [&](const Layer& layer, bool may_be_left_out, LeftOut& next) {
                for (std::size_t t = 0; t < kTissues; ++t) {
                    double left_out_m = never[t];
                    if (Tissue(t) == layer.tissue && !layer.new_membrane)
                        left_out_m = now[t] <= layer.thickness_m ? 0.0 : now[t];
                    else if (may_be_left_out && isPlain(layer.tissue))
                        left_out_m = now[t] + layer.thickness_m;
                    if (left_out_m < kNoticeableDistance_m) next[t] = std::min(next[t], left_out_m);
                }
            };
            if (now == never) continue;
            if (!isNeeded(full, i) && !isNeeded(partial, j)) return true;
            if (i < full.size()) passOne(full[i], i != target, left_out[(i + 1) * columns + j]);
            if (j < partial.size()) passOne(partial[j], true, left_out[i * columns + j + 1]);
            if (i < full.size() && j < partial.size() && full[i].tissue == partial[j].tissue)
                left_out[(i + 1) * columns + j + 1][std::size_t(full[i].tissue)] = 0.0;
        }
    return false;
}

bool sameKind(const ExactEvent& a, const ExactEvent& b) {
    return a.kind == b.kind && a.tissue == b.tissue;
}

struct UnmatchedEvent {
    const ExactEvent* event;
    Model model;
};

// Appends the events of one patient up to `depth_m` that the other does not have at the same depth.
void addUnmatchedEvents(Model model, const std::vector<ExactEvent>& own, const std::vector<ExactEvent>& other,
                        double depth_m, std::vector<UnmatchedEvent>& out) {
    for (const ExactEvent& e : own)
        if (e.depth_m <= depth_m && std::none_of(other.begin(), other.end(), [&](const ExactEvent& o) {
                return sameKind(e, o) && o.depth_m == e.depth_m;
            }))
            out.push_back({&e, model});
}

double errorBefore(const SteeringResult& s, double depth_m) {
    const std::size_t i = sampleFrom(s, depth_m);
    return i > 0 ? std::fabs(s.partial.samples_n[i - 1] - s.full.samples_n[i - 1]) : 0.0;
}

// Distance between the event and the other patient's nearest one of the same kind: partial minus full.
double nearestOffset(const ExactEvent& cause, Model model, const SteeringResult& s) {
    double offset_m = kNone;
    for (const ExactEvent& o : (model == Model::full ? s.partial : s.full).force->events) {
        if (!sameKind(cause, o)) continue;
        const double here_m = model == Model::full ? o.depth_m - cause.depth_m : cause.depth_m - o.depth_m;
        if (!(std::fabs(here_m) >= std::fabs(offset_m))) offset_m = here_m;
    }
    return offset_m;
}

Cause findCause(const SteeringResult& s, double largest_n, double depth_m) {
    std::vector<UnmatchedEvent> own;
    addUnmatchedEvents(Model::full, s.full.force->events, s.partial.force->events, depth_m, own);
    addUnmatchedEvents(Model::partial, s.partial.force->events, s.full.force->events, depth_m, own);
    std::sort(own.begin(), own.end(), [](const UnmatchedEvent& a, const UnmatchedEvent& b) {
        return std::tie(a.event->depth_m, a.model, a.event) < std::tie(b.event->depth_m, b.model, b.event);
    });
    const UnmatchedEvent* cause = nullptr;
    double most_n = 0.0;
    for (std::size_t i = 0; i < own.size(); ++i) {
        const double after_n = i + 1 < own.size() ? errorBefore(s, own[i + 1].event->depth_m) : largest_n;
        const double rise_n = after_n - errorBefore(s, own[i].event->depth_m);
        if (rise_n > most_n) most_n = rise_n, cause = &own[i];
    }
    if (!cause) return {};
    return {cause->model, cause->event->tissue, cause->event->kind,
            nearestOffset(*cause->event, cause->model, s)};
}

// The event at which bone stops the needle before the target, or null.
const ExactEvent* findBone(const PatientForces& felt, double target_m) {
    const std::vector<ExactEvent>& events = felt.force->events;
    const auto bone = std::find_if(events.begin(), events.end(), [&](const ExactEvent& e) {
        return e.kind == NeedleEventKind::border && e.tissue == Tissue::bone && e.depth_m <= target_m;
    });
    return bone == events.end() ? nullptr : &*bone;
}

}  // namespace

PathResult measure(const SteeringResult& s, const MeasureSettings& settings) {
    PathResult r;
    r.travel_m = s.end_m - s.begin_m;
    measureSamples(s, r);
    r.exact = measureExactly(s);
    r.max_outside_n = largestErrorOutsideEvents(s, settings.event_window_m);
    measureBorders(s, r);
    r.same_order = sameOrder(s, Skin::counts);
    r.same_order_inside = sameOrder(s, Skin::ignored);
    r.same_order_noticeable = sameOrderNoticeable(s);
    const ExactEvent* const bone = findBone(s.full, s.end_m);
    r.meets_bone = bone || findBone(s.partial, s.end_m);
    for (std::size_t t = 0; t < kTissues; ++t)
        r.event_m[t] = entryError(s, Tissue(t));
    if (r.sampled.max_n > 0.0) r.cause = findCause(s, r.sampled.max_n, r.sampled.max_at_m + s.entry_m);
    return r;
}

}  // namespace stylet::study
