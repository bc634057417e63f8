// Based on Mastmeyer et al. 2017, Algorithm 2 and Eqs. 1-8, solved from event to event: between two events
// the force is a polynomial in the depth. Shares its formulas (tenting.h) with the sampled solver, but not
// its control flow.
#include "haptics/tools/exact.h"

#include <algorithm>
#include <cmath>

#include "base/traversal.h"
#include "haptics/tools/tenting.h"

namespace stylet::haptics {

using patient::TissueRow;

namespace {

// A straight path from air. Its segments lie within the length.
struct StraightPath {
    const std::vector<Segment>& segments;
    double length_m;
};

// `cuts` and `out` must be empty.
class PathSolver {
  public:
    PathSolver(const patient::TissueTable& table, const NeedleSettings& settings, Bone bone,
               const StraightPath& path, std::vector<Segment>& cuts, ExactForce& out)
        : table_(table),
          settings_(settings),
          bone_(bone),
          segments_(path.segments),
          length_m_(path.length_m),
          cuts_(cuts),
          out_(out) {
        while (inside_from_ < segments_.size() && (segments_[inside_from_].tissue == Tissue::air ||
                                                   segments_[inside_from_].tissue == Tissue::skin))
            ++inside_from_;
    }

    void solve() {
        while (next_ < segments_.size()) {
            passUntil(segments_[next_].begin_m);
            const std::size_t j = next_++;
            if (isOutside(j)) {
                leave(j);
            } else if (holds(j)) {
                hold(j);
            } else {
                enter(j, NeedleEventKind::entry);
            }
        }
        passUntil(length_m_);
    }

  private:
    const TissueRow& row(Tissue t) const { return table_[std::size_t(t)]; }
    const TissueRow& row(std::size_t segment) const { return row(segments_[segment].tissue); }
    bool sameTissueAsBefore(std::size_t j) const { return segments_[j].tissue == segments_[j - 1].tissue; }

    // True for air with nothing but skin in front of it.
    bool isOutside(std::size_t j) const { return j < inside_from_ && segments_[j].tissue == Tissue::air; }

    bool isCut(std::size_t j) const {
        return std::any_of(cuts_.begin(), cuts_.end(), [&](const Segment& c) {
            return c.tissue == segments_[j].tissue &&
                   std::fabs(c.begin_m - segments_[j].begin_m) <= settings_.cut_reach_m;
        });
    }
    bool holds(std::size_t j) const {
        if (isRigid(row(j))) return true;
        return !sameTissueAsBefore(j) && resists(row(j), f_n_) && !isCut(j);
    }

    void piece(double end_m, double c1, double c2, Phase phase) {
        if (end_m <= x_m_) return;
        out_.pieces.push_back({x_m_, end_m, f_n_, c1, c2, tissue_, phase});
        x_m_ = end_m;
    }

    // Phase 3: the force rises with the tissue's stiffness up to its friction, then stays constant.
    void passUntil(double to_m) {
        const TissueRow& t = row(tissue_);
        const Phase phase = isOutside(next_ - 1) ? Phase::outside : Phase::pass;
        if (t.stiffness_n_per_m > 0.0 && f_n_ < t.friction_n) {
            const double begin_m = x_m_;
            const double full_m = begin_m + (t.friction_n - f_n_) / t.stiffness_n_per_m;
            piece(std::min(to_m, full_m), t.stiffness_n_per_m, 0.0, phase);
            f_n_ = full_m <= to_m ? t.friction_n : f_n_ + t.stiffness_n_per_m * (x_m_ - begin_m);
        }
        piece(to_m, 0.0, 0.0, phase);
    }

    // Phase 1 and everything that follows until no border holds.
    void hold(std::size_t j) {
        for (bool held = true; held;) {
            report(NeedleEventKind::border, j, f_n_, f_n_);
            if (isRigid(row(j))) return press(j);
            const TentingCurve curve = tentingCurve(row(j), f_n_, settings_.a1_share);
            const double begin_m = x_m_, cut_m = begin_m + curve.cut_depth_m;

            // The borders that the tip passes before the puncture.
            std::size_t last = next_;
            for (; last < segments_.size() && segments_[last].begin_m < cut_m; ++last) {
                const bool dropped = !row(j).membrane && !sameTissueAsBefore(last);
                if (!isRigid(row(last)) && !dropped && !isOutside(last)) continue;
                const double at_m = std::max(begin_m, segments_[last].begin_m);
                piece(at_m, curve.a1_n_per_m, curve.a2_n_per_m2, Phase::held);
                f_n_ = curve.force_n(at_m - begin_m);
                if (isOutside(last)) {
                    next_ = last + 1;
                    return leave(last);
                }
                if (isRigid(row(last))) {
                    report(NeedleEventKind::border, last, f_n_, f_n_);
                    return press(last);
                }
                enter(j, NeedleEventKind::entry);
                for (; next_ < last; ++next_)
                    enter(next_, NeedleEventKind::entry);
                return;
            }
            piece(std::min(cut_m, length_m_), curve.a1_n_per_m, curve.a2_n_per_m2, Phase::held);
            if (cut_m > length_m_) return finish(curve.force_n(length_m_ - begin_m));
            f_n_ = row(j).cut_force_n;
            enter(j, NeedleEventKind::puncture);
            held = fold(last, j);
        }
    }

    // Meets the segments from next_ to `last`, all behind the tip, at the tip. Returns true if one of them
    // holds; `j` is then its index.
    bool fold(std::size_t last, std::size_t& j) {
        while (next_ < last) {
            const std::size_t k = next_++;
            bool left_behind = false;
            for (std::size_t m = k + 1; m < last; ++m)
                left_behind = left_behind || !sameTissueAsBefore(m);
            if (holds(k) && (row(k).membrane || !left_behind)) {
                j = k;
                return true;
            }
            enter(k, NeedleEventKind::entry);
        }
        return false;
    }

    // Pressing against bone, to the end of the path.
    void press(std::size_t j) {
        const double k = row(j).stiffness_n_per_m;
        const double most_n = std::max(settings_.max_force_n, f_n_);
        const double begin_m = x_m_;
        if (bone_ == Bone::maximumAtOnce) f_n_ = most_n;
        piece(std::min(length_m_, x_m_ + (most_n - f_n_) / k), k, 0.0, Phase::held);
        f_n_ += k * (x_m_ - begin_m);
        piece(length_m_, 0.0, 0.0, Phase::held);
        finish(f_n_);
    }

    // The needle grazed a corner of slanted skin and is outside again.
    void leave(std::size_t j) {
        if (!sameTissueAsBefore(j)) report(NeedleEventKind::withdrawn, j, f_n_, 0.0);
        f_n_ = 0.0;
        tissue_ = Tissue::air;
    }

    void finish(double force_n) {
        f_n_ = force_n;
        next_ = segments_.size();
    }

    void enter(std::size_t j, NeedleEventKind kind) {
        const double before_n = f_n_;
        f_n_ = clampToFriction(row(j), f_n_);
        const bool cut = kind == NeedleEventKind::puncture || !resists(row(j), before_n);
        if (cut && !sameTissueAsBefore(j) && segments_[j].tissue != Tissue::air && !isCut(j))
            cuts_.push_back(segments_[j]);
        tissue_ = segments_[j].tissue;
        report(kind, j, before_n, f_n_);
    }

    void report(NeedleEventKind kind, std::size_t j, double before_n, double after_n) {
        const Segment& s = segments_[j];
        out_.events.push_back({kind, s.tissue, s.label, s.begin_m, x_m_, before_n, after_n});
    }

    const patient::TissueTable& table_;
    const NeedleSettings& settings_;
    Bone bone_;
    const std::vector<Segment>& segments_;
    double length_m_;
    std::vector<Segment>& cuts_;
    ExactForce& out_;
    double x_m_ = 0.0, f_n_ = 0.0;
    Tissue tissue_ = Tissue::air;
    std::size_t next_ = 1, inside_from_ = 0;
};

void beginInAir(std::vector<Segment>& path) {
    if (path.empty() || path.front().tissue != Tissue::air) path.insert(path.begin(), Segment{});
}

}  // namespace

void segmentsAlong(const patient::TissueMap& map, const std::vector<VoxelPath::Visit>& walk, double length_m,
                   Borders borders, std::vector<Segment>& segments) {
    constexpr double kCorner_m = 1e-9;
    const double corner = borders == Borders::ofTissues ? kCorner_m / length_m : 0.0;
    segments.clear();
    patient::TrackFlags flags;
    int last = -1;
    for (std::size_t i = 0; i < walk.size(); ++i) {
        const VoxelPath::Visit& visit = walk[i];
        const patient::TissueMap::Code code = map.code(visit);
        if (code == last) continue;
        if (i + 1 < walk.size() && walk[i + 1].begin - visit.begin < corner) continue;
        last = code;
        const patient::TissueSample x = map.sample(code, flags);
        flags = map.flagsAfterEntering(code, flags);
        if (!segments.empty() && segments.back().tissue == x.tissue &&
            (borders == Borders::ofTissues || segments.back().label == x.label))
            continue;
        segments.push_back({visit.begin * length_m, x.tissue, x.label});
    }
}

void segmentsAlong(const patient::TissueMap& map, const Vec3& entry_m, const Vec3& end_m, VoxelPath& path,
                   std::vector<Segment>& segments) {
    const Vec3 along_m = end_m - entry_m;
    segmentsAlong(map, path.along(map.grid(), entry_m, end_m), std::sqrt(glm::dot(along_m, along_m)),
                  Borders::ofLabels, segments);
}

ExactForce solveExact(const patient::TissueTable& table, const std::vector<Segment>& segments,
                      double length_m, const NeedleSettings& settings, Bone bone) {
    std::vector<Segment> path = segments, cuts;
    std::erase_if(path, [&](const Segment& s) { return s.begin_m > length_m; });
    ExactForce force;
    beginInAir(path);
    PathSolver(table, settings, bone, {path, length_m}, cuts, force).solve();
    return force;
}

const ExactForce& ExactSolver::solveSegments(double length_m) {
    beginInAir(segments_);
    cuts_.clear();
    force_.pieces.clear();
    force_.events.clear();
    PathSolver(map_.tissues(), settings_, bone_, {segments_, length_m}, cuts_, force_).solve();
    return force_;
}

const ExactForce& ExactSolver::solve(const Vec3& entry_m, const Vec3& end_m) {
    const Vec3 along_m = end_m - entry_m;
    segmentsAlong(map_, entry_m, end_m, path_, segments_);
    return solveSegments(std::sqrt(glm::dot(along_m, along_m)));
}

const ExactForce& ExactSolver::solve(const std::vector<VoxelPath::Visit>& walk, double length_m,
                                     Borders borders) {
    segmentsAlong(map_, walk, length_m, borders, segments_);
    return solveSegments(length_m);
}

double ExactForce::at(double depth_m) const {
    if (pieces.empty()) return 0.0;
    auto after = std::upper_bound(pieces.begin(), pieces.end(), depth_m,
                                  [](double depth, const ForcePiece& p) { return depth < p.begin_m; });
    const ForcePiece& p = after == pieces.begin() ? pieces.front() : *(after - 1);
    const double x = std::clamp(depth_m, p.begin_m, p.end_m) - p.begin_m;
    return (p.c2_n_per_m2 * x + p.c1_n_per_m) * x + p.c0_n;
}

void sampleForce(const ExactForce& force, double first_m, double step_m, std::span<double> force_n) {
    std::size_t i = 0;
    for (const ForcePiece& p : force.pieces) {
        const bool is_last = &p == &force.pieces.back();
        // Number of depths before this piece's end: an estimate, corrected by the exact comparison.
        std::size_t end = force_n.size();
        if (!is_last) {
            const double count = std::ceil((p.end_m - first_m) / step_m);
            end = std::clamp(std::size_t(std::max(0.0, count)), i, force_n.size());
            while (end > i && !(first_m + double(end - 1) * step_m < p.end_m))
                --end;
            while (end < force_n.size() && first_m + double(end) * step_m < p.end_m)
                ++end;
        }
        if (p.c1_n_per_m == 0.0 && p.c2_n_per_m2 == 0.0) {
            std::fill(force_n.begin() + std::ptrdiff_t(i), force_n.begin() + std::ptrdiff_t(end), p.c0_n);
            i = end;
        }
        for (; i < end; ++i) {
            const double x = std::clamp(first_m + double(i) * step_m, p.begin_m, p.end_m) - p.begin_m;
            force_n[i] = (p.c2_n_per_m2 * x + p.c1_n_per_m) * x + p.c0_n;
        }
    }
    std::fill(force_n.begin() + std::ptrdiff_t(i), force_n.end(), 0.0);  // if there are no pieces
}

}  // namespace stylet::haptics
