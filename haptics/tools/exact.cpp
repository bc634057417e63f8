// Based on Mastmeyer et al. 2017, Algorithm 2 and Eqs. 1-8, solved from event to event: between two events
// the force is a polynomial in the depth. Shares its formulas (tenting.h) with the sampled solver, but not
// its control flow.
#include "haptics/tools/exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "base/traversal.h"
#include "haptics/tools/tenting.h"

namespace stylet::haptics {

using patient::TissueRow;

namespace {

// Solves one straight path that starts in air. All segments begin within `length_m`. `cuts` and `out` must be
// empty.
struct PathSolver {
    const patient::TissueTable& table;
    const NeedleSettings& settings;
    Bone bone;
    const std::vector<Segment>& segments;
    double length_m;
    std::vector<Segment>& cuts;
    ExactForce& out;

    double x_m = 0.0, f_n = 0.0;
    Tissue tissue = Tissue::air;
    std::size_t next = 1, inside_from = 0;

    void solve() {
        while (inside_from < segments.size() &&
               (segments[inside_from].tissue == Tissue::air || segments[inside_from].tissue == Tissue::skin))
            ++inside_from;
        while (next < segments.size()) {
            passUntil(segments[next].begin_m);
            const std::size_t j = next++;
            if (isOutside(j)) {
                leaveBody(j);
            } else if (willTent(j)) {
                solveTenting(j);
            } else {
                enter(j, NeedleEventKind::entry);
            }
        }
        passUntil(length_m);
    }

    const TissueRow& row(Tissue t) const { return table[std::size_t(t)]; }
    const TissueRow& row(std::size_t segment) const { return row(segments[segment].tissue); }
    bool sameTissueAsBefore(std::size_t j) const { return segments[j].tissue == segments[j - 1].tissue; }

    // True for air with nothing but skin in front of it.
    bool isOutside(std::size_t j) const { return j < inside_from && segments[j].tissue == Tissue::air; }

    bool isCut(std::size_t j) const {
        return std::any_of(cuts.begin(), cuts.end(), [&](const Segment& c) {
            return c.tissue == segments[j].tissue &&
                   std::fabs(c.begin_m - segments[j].begin_m) <= settings.cut_reach_m;
        });
    }
    bool willTent(std::size_t j) const {
        if (isRigid(row(j))) return true;
        return !sameTissueAsBefore(j) && resists(row(j), f_n) && !isCut(j);
    }

    void piece(double end_m, double c1, double c2, Phase phase) {
        if (end_m <= x_m) return;
        out.pieces.push_back({x_m, end_m, f_n, c1, c2, tissue, phase});
        x_m = end_m;
    }

    // Phase 3: the force rises with the tissue's stiffness up to its friction, then stays constant.
    void passUntil(double to_m) {
        const TissueRow& t = row(tissue);
        const Phase phase = isOutside(next - 1) ? Phase::outside : Phase::pass;
        const double friction_n = frictionLimit(t, settings.friction_scale);
        if (t.stiffness_n_per_m > 0.0 && f_n < friction_n) {
            const double begin_m = x_m;
            const double full_m = begin_m + (friction_n - f_n) / t.stiffness_n_per_m;
            piece(std::min(to_m, full_m), t.stiffness_n_per_m, 0.0, phase);
            f_n = full_m <= to_m ? friction_n : f_n + t.stiffness_n_per_m * (x_m - begin_m);
        }
        piece(to_m, 0.0, 0.0, phase);
    }

    // Phases 1 and 2, repeated until no further border tents.
    void solveTenting(std::size_t j) {
        for (bool tents = true; tents;) {
            report(NeedleEventKind::border, j, f_n, f_n);
            if (isRigid(row(j))) return pressOnBone(j);
            const TentingCurve curve = tentingCurve(row(j), f_n, settings.a1_share);
            const double begin_m = x_m, cut_m = begin_m + curve.cut_depth_m;

            // The borders that the tip passes before the puncture.
            std::size_t last = next;
            for (; last < segments.size() && segments[last].begin_m < cut_m; ++last) {
                const bool dropped = !row(j).membrane && !sameTissueAsBefore(last);
                if (!isRigid(row(last)) && !dropped && !isOutside(last)) continue;
                const double at_m = std::max(begin_m, segments[last].begin_m);
                piece(at_m, curve.a1_n_per_m, curve.a2_n_per_m2, Phase::tenting);
                f_n = curve.force_n(at_m - begin_m);
                if (isOutside(last)) {
                    next = last + 1;
                    return leaveBody(last);
                }
                if (isRigid(row(last))) {
                    report(NeedleEventKind::border, last, f_n, f_n);
                    return pressOnBone(last);
                }
                enter(j, NeedleEventKind::entry);
                for (; next < last; ++next)
                    enter(next, NeedleEventKind::entry);
                return;
            }
            piece(std::min(cut_m, length_m), curve.a1_n_per_m, curve.a2_n_per_m2, Phase::tenting);
            if (cut_m > length_m) return finish(curve.force_n(length_m - begin_m));
            f_n = row(j).cut_force_n;
            enter(j, NeedleEventKind::puncture);
            tents = handlePassedBorders(last, j);
        }
    }

    // Handles the borders of the segments from `next` to `last`, which the tip has already passed. Returns
    // true if one of them tents; `j` is then its index.
    bool handlePassedBorders(std::size_t last, std::size_t& j) {
        while (next < last) {
            const std::size_t k = next++;
            bool left_behind = false;
            for (std::size_t m = k + 1; m < last; ++m)
                left_behind = left_behind || !sameTissueAsBefore(m);
            if (willTent(k) && (row(k).membrane || !left_behind)) {
                j = k;
                return true;
            }
            enter(k, NeedleEventKind::entry);
        }
        return false;
    }

    // Pressing against bone, to the end of the path.
    void pressOnBone(std::size_t j) {
        const double k = row(j).stiffness_n_per_m;
        const double max_n = std::max(settings.max_force_n, f_n);
        const double begin_m = x_m;
        if (bone == Bone::immediateMaximum) f_n = max_n;
        piece(std::min(length_m, x_m + (max_n - f_n) / k), k, 0.0, Phase::tenting);
        f_n += k * (x_m - begin_m);
        piece(length_m, 0.0, 0.0, Phase::tenting);
        finish(f_n);
    }

    // The needle grazed a corner of slanted skin and is outside again.
    void leaveBody(std::size_t j) {
        if (!sameTissueAsBefore(j)) report(NeedleEventKind::withdrawn, j, f_n, 0.0);
        f_n = 0.0;
        tissue = Tissue::air;
    }

    void finish(double force_n) {
        f_n = force_n;
        next = segments.size();
    }

    void enter(std::size_t j, NeedleEventKind kind) {
        const double before_n = f_n;
        f_n = clampToFriction(row(j), f_n, settings.friction_scale);
        const bool cut = kind == NeedleEventKind::puncture || !resists(row(j), before_n);
        if (cut && !sameTissueAsBefore(j) && segments[j].tissue != Tissue::air && !isCut(j))
            cuts.push_back(segments[j]);
        tissue = segments[j].tissue;
        report(kind, j, before_n, f_n);
    }

    void report(NeedleEventKind kind, std::size_t j, double before_n, double after_n) {
        const Segment& s = segments[j];
        out.events.push_back({kind, s.tissue, s.label, s.begin_m, x_m, before_n, after_n});
    }
};

bool isMembrane(const patient::TissueMap& map, const VoxelPath::Visit& visit, patient::TrackFlags flags) {
    return map.tissues()[std::size_t(map.sample(map.code(visit), flags).tissue)].membrane;
}

// The path passes from the first voxel to the last through the edge or corner that they share. A membrane one
// voxel thick is closed across faces only. It separates the two voxels if every path over face neighbours
// between them meets it.
bool crossesMembrane(const patient::TissueMap& map, std::span<const VoxelPath::Visit> visits,
                     patient::TrackFlags flags) {
    std::array<std::int64_t, 3> steps{};
    const std::size_t count = visits.size() - 1;
    const auto isOutside = [](const VoxelPath::Visit& v) { return v.offset == VoxelPath::kOutside; };
    if (count > steps.size() || std::any_of(visits.begin(), visits.end(), isOutside)) return false;
    if (isMembrane(map, visits.front(), flags) || isMembrane(map, visits.back(), flags)) return false;
    for (std::size_t k = 0; k < count; ++k)
        steps[k] = visits[k + 1].offset - visits[k].offset;
    const auto end = steps.begin() + std::ptrdiff_t(count);
    std::sort(steps.begin(), end);
    do {
        bool meets = false;
        VoxelPath::Visit at = visits.front();
        for (std::size_t k = 0; k + 1 < count && !meets; ++k) {
            at.offset += steps[k];
            meets = isMembrane(map, at, flags);
        }
        if (!meets) return false;
    } while (std::next_permutation(steps.begin(), end));
    return true;
}

void prependAir(std::vector<Segment>& path) {
    if (path.empty() || path.front().tissue != Tissue::air) path.insert(path.begin(), Segment{});
}

}  // namespace

void segmentsAlong(const patient::TissueMap& map, const std::vector<VoxelPath::Visit>& walk, double length_m,
                   Borders borders, std::vector<Segment>& segments) {
    constexpr double kGrazed_m = 1e-9;
    const double grazed = borders == Borders::tissueChanges ? kGrazed_m / length_m : 0.0;
    const auto isGrazed = [&](std::size_t i) {
        return i + 1 < walk.size() && walk[i + 1].begin - walk[i].begin < grazed;
    };
    segments.clear();
    patient::TrackFlags flags;
    int last = -1;
    for (std::size_t i = 0; i < walk.size(); ++i) {
        const VoxelPath::Visit& visit = walk[i];
        const patient::TissueMap::Code code = map.code(visit);
        if (code == last) continue;
        if (isGrazed(i)) {
            std::size_t before = i, after = i;
            while (before > 0 && isGrazed(before))
                --before;
            while (isGrazed(after))
                ++after;
            const std::span<const VoxelPath::Visit> visits(&walk[before], after - before + 1);
            if (!isMembrane(map, visit, flags) || !crossesMembrane(map, visits, flags)) continue;
        }
        last = code;
        const patient::TissueSample x = map.sample(code, flags);
        flags = map.flagsAfterEntering(code, flags);
        if (!segments.empty() && segments.back().tissue == x.tissue &&
            (borders == Borders::tissueChanges || segments.back().label == x.label))
            continue;
        segments.push_back({visit.begin * length_m, x.tissue, x.label});
    }
}

void segmentsAlong(const patient::TissueMap& map, const Vec3& entry_m, const Vec3& end_m, VoxelPath& path,
                   std::vector<Segment>& segments) {
    segmentsAlong(map, path.traverse(map.grid(), entry_m, end_m), glm::length(end_m - entry_m),
                  Borders::labelChanges, segments);
}

ExactForce solveExact(const patient::TissueTable& table, const std::vector<Segment>& segments,
                      double length_m, const NeedleSettings& settings, Bone bone) {
    std::vector<Segment> path = segments, cuts;
    std::erase_if(path, [&](const Segment& s) { return s.begin_m > length_m; });
    ExactForce force;
    prependAir(path);
    PathSolver{table, settings, bone, path, length_m, cuts, force}.solve();
    return force;
}

const ExactForce& ExactSolver::solveSegments(double length_m) {
    prependAir(segments_);
    cuts_.clear();
    force_.pieces.clear();
    force_.events.clear();
    PathSolver{map_.tissues(), settings_, bone_, segments_, length_m, cuts_, force_}.solve();
    return force_;
}

const ExactForce& ExactSolver::solve(const Vec3& entry_m, const Vec3& end_m) {
    segmentsAlong(map_, entry_m, end_m, path_, segments_);
    return solveSegments(glm::length(end_m - entry_m));
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
    return (after == pieces.begin() ? pieces.front() : *(after - 1)).at(depth_m);
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
        for (; i < end; ++i)
            force_n[i] = p.at(first_m + double(i) * step_m);
    }
    std::fill(force_n.begin() + std::ptrdiff_t(i), force_n.end(), 0.0);  // if there are no pieces
}

}  // namespace stylet::haptics
