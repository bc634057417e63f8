#include "app/modeller/motion/motion_fit.h"

#include <algorithm>
#include <cmath>

#include "app/modeller/motion/motion_cavity.h"
#include "base/csv.h"
#include "base/smoothstep.h"
#include "base/statistics.h"
#include "base/whole_file.h"

namespace stylet::modeller {

using patient::MotionModel;
using patient::Surrogate;

namespace {

constexpr double kMargin_m = 0.030;  // beyond the images; the fields fade out there
constexpr float kMinWeight = 0.02f;
constexpr int kRelaxations = 200;
constexpr int kLevelPasses = 6;
// The registered field already slides along the wall, so only nodes on the surface itself are corrected.
constexpr double kNormalDepth_m = 0.0;
constexpr float kOutsideImage_hu = -1000.0f;

Grid nodeGrid(const Grid& image, double step_m) {
    Grid nodes;
    const Vec3 low = image.origin_m - kMargin_m,
               size_m = image.spacing_m * Vec3(image.dims - 1) + 2.0 * kMargin_m;
    nodes.spacing_m = Vec3(step_m);
    nodes.origin_m = low;
    for (int d = 0; d < 3; ++d)
        nodes.dims[d] = int(std::ceil(size_m[d] / step_m)) + 1;
    return nodes;
}

// Returns a weight: 1 inside the images, 0 on the outermost nodes.
double window(const Grid& nodes, const Grid& image, const Index3& i) {
    double w = 1.0;
    const Vec3 p = nodes.centre(i), high = image.centre(image.dims - 1);
    for (int d = 0; d < 3; ++d) {
        if (i[d] == 0 || i[d] == nodes.dims[d] - 1) return 0.0;
        const double beyond_m = std::max({0.0, image.origin_m[d] - p[d], p[d] - high[d]});
        w *= 1.0 - smoothStep(0.0, kMargin_m - nodes.spacing_m[d], beyond_m);
    }
    return w;
}

// Sets unknown nodes to the mean of their neighbours, so that the field is as smooth as possible.
void fillUnknown(const Grid& nodes, const std::vector<unsigned char>& known, std::vector<Vec3>& values) {
    std::vector<unsigned char> set = known;
    const std::size_t strides[3] = {1, std::size_t(nodes.dims.x),
                                    std::size_t(nodes.dims.x) * std::size_t(nodes.dims.y)};
    std::vector<Vec3> next = values;
    for (int pass = 0; pass < kRelaxations; ++pass) {
        std::vector<unsigned char> next_set = set;
        parallelVoxels(nodes, [&](const Index3& i) {
            const std::size_t at = nodes.offset(i);
            if (known[at]) return;
            Vec3 sum(0.0);
            int count = 0;
            for (int d = 0; d < 3; ++d)
                for (const int direction : {-1, 1}) {
                    if (i[d] + direction < 0 || i[d] + direction >= nodes.dims[d]) continue;
                    const std::size_t other = direction < 0 ? at - strides[d] : at + strides[d];
                    if (set[other]) sum += values[other], ++count;
                }
            if (count > 0) next[at] = sum / double(count), next_set[at] = 1;
        });
        std::swap(values, next);
        next = values;
        set = next_set;
    }
}

// Samples the field at the nodes: the mean around each node, over voxels weighted by `inside`.
std::vector<Vec3> sampleAtNodes(const VectorField& field, const FloatVolume& inside, const Grid& nodes,
                                const Grid& image) {
    std::vector<Vec3> values(nodes.voxelCount(), Vec3(0.0));
    std::vector<unsigned char> known(values.size(), 0);
    const Grid& g = field.grid;
    const double sigma_m = 0.5 * nodes.spacing_m.x;
    parallelVoxels(nodes, [&](const Index3& n) {
        const std::size_t at = nodes.offset(n);
        const Vec3 p = nodes.centre(n), v = g.toVoxels(p);
        Index3 low, high;
        for (int d = 0; d < 3; ++d) {
            const double reach = 2.0 * sigma_m / g.spacing_m[d];
            low[d] = std::max(0, int(std::ceil(v[d] - reach)));
            high[d] = std::min(g.dims[d] - 1, int(std::floor(v[d] + reach)));
        }
        Vec3 sum(0.0);
        double weights = 0.0;
        forEachVoxel(VoxelBox{low, high}, [&](const Index3& i) {
            const Vec3 away = (g.centre(i) - p) / sigma_m;
            const double w =
                double(inside[i]) * std::exp(-0.5 * (away.x * away.x + away.y * away.y + away.z * away.z));
            sum += w * Vec3(field[i]);
            weights += w;
        });
        if (weights < double(kMinWeight)) return;
        values[at] = sum / weights;
        known[at] = 1;
    });
    fillUnknown(nodes, known, values);
    parallelVoxels(nodes, [&](const Index3& i) { values[nodes.offset(i)] *= window(nodes, image, i); });
    return values;
}

// Returns, for each voxel of `grid`, the share of it that is inside the mask.
FloatVolume maskWeights(const Mask& mask, const Grid& grid) {
    const FloatVolume fine = toFloat(mask);
    FloatVolume out(grid);
    parallelVoxels(grid, [&](const Index3& i) { out[i] = valueAt(fine, grid.centre(i), 0.0f); });
    return out;
}

// Masks of the tissue inside and outside the chest cavity.
struct FitMasks {
    const Mask& cavity;
    const Mask& outside;
};

// Registers a phase twice: first the tissue outside the cavity, then the tissue inside. The motion of the
// first registration is undone before the second one, so that one mask fits both images.
NodeVelocities computeVelocities(const Phase& fixed, const Phase& moving, const FitMasks& masks,
                                 const Grid& nodes, const FitSettings& settings, double& log_error_m) {
    NodeVelocities out;
    const auto field = [&](const FloatVolume& picture, const Mask& mask) {
        double error_m = 0.0;
        VectorField velocity =
            logarithm(registerPhases(fixed.hu, picture, mask, settings.registration), error_m);
        log_error_m = std::max(log_error_m, error_m);
        return velocity;
    };
    const VectorField wall = field(moving.hu, masks.outside);
    out.wall_m = sampleAtNodes(wall, maskWeights(masks.outside, wall.grid), nodes, fixed.hu.grid);
    // Undo the motion as the model will apply it, interpolated from the nodes.
    VectorField coarse(nodes);
    for (std::size_t i = 0; i < coarse.voxels.size(); ++i)
        coarse.voxels[i] = glm::vec3(out.wall_m[i]);
    const FloatVolume wall_aligned = warped(moving.hu, exponential(coarse), kOutsideImage_hu);
    const VectorField slide = field(wall_aligned, masks.cavity);
    out.slide_m = sampleAtNodes(slide, maskWeights(masks.cavity, slide.grid), nodes, fixed.hu.grid);
    return out;
}

// Smooths the level (signed distance to the wall) at the nodes. It has steps from the voxels of the mask.
void smoothLevel(MotionModel& m) {
    const std::size_t strides[3] = {1, std::size_t(m.grid.dims.x),
                                    std::size_t(m.grid.dims.x) * std::size_t(m.grid.dims.y)};
    for (int pass = 0; pass < kLevelPasses; ++pass)
        for (int d = 0; d < 3; ++d) {
            const std::vector<float> old = m.level_m;
            parallelVoxels(m.grid, [&](const Index3& i) {
                const std::size_t at = m.grid.offset(i);
                const std::size_t low = i[d] > 0 ? at - strides[d] : at,
                                  high = i[d] + 1 < m.grid.dims[d] ? at + strides[d] : at;
                m.level_m[at] = 0.25f * old[low] + 0.5f * old[at] + 0.25f * old[high];
            });
        }
}

MotionModel emptyModel(const Grid& nodes, const Mask& cavity, const Surrogate& reference) {
    MotionModel m;
    m.grid = nodes;
    m.reference = reference;
    m.wall.resize(nodes.voxelCount());
    m.slide.resize(nodes.voxelCount());
    m.level_m.resize(nodes.voxelCount());
    const FloatVolume level = signedDistance(cavity);
    const Vec3 low = level.grid.origin_m, high = level.grid.centre(level.grid.dims - 1);
    parallelVoxels(nodes, [&](const Index3& i) {
        const std::size_t at = nodes.offset(i);
        m.level_m[at] = valueAt(level, glm::clamp(nodes.centre(i), low, high), 0.0f);
    });
    smoothLevel(m);
    return m;
}

Residual computeResidual(const MotionModel& m, const Surrogate& now, const DomeMap& from, const DomeMap& to,
                         const DomeColumns& dome_columns) {
    Residual r;
    std::vector<double> all_m;
    double slice_m = 0.0;
    int slice_count = 0;
    for (const auto& [x, y] : dome_columns.columns) {
        const Vec3 moved = deformedFromReference(m, now, from.point(x, y));
        const double off_m = moved.z - to.heightAt(moved.x, moved.y);
        if (!std::isfinite(off_m)) continue;
        r.mean_m += off_m;
        all_m.push_back(std::fabs(off_m));
        r.mean_abs_m += all_m.back();
        if (y == dome_columns.slice_y) slice_m += all_m.back(), ++slice_count;
    }
    if (all_m.empty() || slice_count == 0) throw ImportError("a phase shows no dome where the others do");
    r.mean_m /= double(all_m.size());
    r.mean_abs_m /= double(all_m.size());
    r.slice_mean_abs_m = slice_m / slice_count;
    r.p95_m = lowerQuantile(std::move(all_m), 0.95);
    return r;
}

// Computes the travel of the dome from end-exhale to end-inhale.
double computeDomeTravel(const MotionModel& m, const DomeMap& reference, const DomeColumns& dome_columns) {
    double sum_m = 0.0;
    for (const auto& [x, y] : dome_columns.columns) {
        const Vec3 p = reference.point(x, y);
        sum_m += p.z - deformedFromReference(m, {m.v.high, 0.0}, p).z;
    }
    return std::max(0.0, sum_m / double(dome_columns.columns.size()) / (m.v.high - m.reference.v));
}

double domeHeight(const DomeMap& map, const DomeMap& reference, const DomeColumns& dome_columns) {
    double sum_m = 0.0;
    for (const auto& [x, y] : dome_columns.columns)
        sum_m += double(map.at(x, y)) - double(reference.at(x, y));
    return sum_m / double(dome_columns.columns.size());
}

patient::SurrogateRange surrogateRange(const std::vector<Surrogate>& surrogates, double Surrogate::* what) {
    patient::SurrogateRange range{surrogates.front().*what, surrogates.front().*what};
    for (const Surrogate& s : surrogates)
        range.low = std::min(range.low, s.*what), range.high = std::max(range.high, s.*what);
    return range;
}

std::size_t findEndExhale(const std::vector<Surrogate>& s) {
    return std::size_t(
        std::min_element(s.begin(), s.end(), [](const auto& a, const auto& b) { return a.v < b.v; }) -
        s.begin());
}

}  // namespace

std::vector<Surrogate> makeSurrogates(const std::vector<double>& densities, double period_s) {
    const auto [low, high] = std::minmax_element(densities.begin(), densities.end());
    if (!(*high - *low > 1.0))
        throw ImportError("the lung's density hardly changes: these phases do not breathe");
    const std::size_t n = densities.size();
    const auto v = [&](std::size_t p) { return (*high - densities[p % n]) / (*high - *low); };
    std::vector<Surrogate> out;
    for (std::size_t p = 0; p < n; ++p)
        out.push_back({v(p), (v(p + 1) - v(p + n - 1)) / (2.0 * period_s / double(n))});
    return out;
}

void regress(const std::vector<NodeVelocities>& phases, const std::vector<Surrogate>& surrogates,
             std::size_t reference, std::size_t left_out_phase, MotionModel& m) {
    // The regressors are the same at every node, and so are the weights of the phases.
    double vv = 0.0, vr = 0.0, rr = 0.0;
    const auto dv = [&](std::size_t p) { return surrogates[p].v - surrogates[reference].v; };
    const auto dr = [&](std::size_t p) {
        return surrogates[p].rate_per_s - surrogates[reference].rate_per_s;
    };
    const auto used = [&](std::size_t p) { return p != reference && p != left_out_phase; };
    for (std::size_t p = 0; p < phases.size(); ++p)
        if (used(p)) vv += dv(p) * dv(p), vr += dv(p) * dr(p), rr += dr(p) * dr(p);
    const double det = vv * rr - vr * vr;
    const bool both = det > 1e-3 * vv * rr;
    if (!(vv > 0.0)) throw ImportError("the surrogate is the same in every phase");
    for (const auto& [field, to] : {std::pair{&NodeVelocities::wall_m, &MotionModel::wall},
                                    std::pair{&NodeVelocities::slide_m, &MotionModel::slide}})
        for (std::size_t i = 0; i < (m.*to).size(); ++i) {
            Vec3 wv(0.0), wr(0.0);
            for (std::size_t p = 0; p < phases.size(); ++p)
                if (used(p)) wv += dv(p) * (phases[p].*field)[i], wr += dr(p) * (phases[p].*field)[i];
            const Vec3 a1 = both ? (rr * wv - vr * wr) / det : wv / vv;
            const Vec3 a2 = both ? (vv * wr - vr * wv) / det : Vec3(0.0);
            for (int d = 0; d < 3; ++d) {
                (m.*to)[i].a1_m[std::size_t(d)] = float(a1[d]);
                (m.*to)[i].a2_m_s[std::size_t(d)] = float(a2[d]);
            }
        }
}

FittedMotion fitMotion(const FitSettings& settings) {
    const std::vector<Phase> phases = readPhases(settings.phases);
    std::vector<DomeMap> domes;
    for (const Phase& phase : phases)
        domes.push_back(findDome(phase.hu));
    DomeColumns dome_columns = selectDomeColumns(domes, 0);
    const auto surrogates = [&] {
        return settings.signal.empty()
                   ? makeSurrogates(lungDensityOutsideDome(phases, dome_columns), settings.period_s)
                   : readPhaseSignal(settings.signal, phases.size());
    };
    FittedMotion out;
    out.reference = findEndExhale(surrogates());
    dome_columns = selectDomeColumns(domes, out.reference);
    const std::vector<Surrogate> phase_surrogates = surrogates();
    settings.progress("surrogate, " + std::to_string(dome_columns.columns.size()) + " columns of the dome");

    const Mask cavity = chestCavity(phases);
    const Mask outside = inverted(cavity);
    settings.progress("cavity");

    const Phase& fixed = phases[out.reference];
    const Grid nodes = nodeGrid(fixed.hu.grid, settings.grid_m);
    std::vector<NodeVelocities> velocities(phases.size());
    out.phases.resize(phases.size());
    for (std::size_t p = 0; p < phases.size(); ++p) {
        if (p == out.reference) continue;
        velocities[p] = computeVelocities(fixed, phases[p], {cavity, outside}, nodes, settings,
                                          out.phases[p].log_error_m);
        settings.progress("registered " + phases[p].name);
    }
    velocities[out.reference] = {std::vector<Vec3>(nodes.voxelCount()),
                                 std::vector<Vec3>(nodes.voxelCount())};

    // A package's reference frame is a breathing state at rest (rate 0).
    out.model = emptyModel(nodes, cavity, {phase_surrogates[out.reference].v, 0.0});
    MotionModel left_out = out.model;
    regress(velocities, phase_surrogates, out.reference, phases.size(), out.model);
    makeTangential(out.model, kNormalDepth_m);
    out.model.v = surrogateRange(phase_surrogates, &Surrogate::v);
    // A rate that is the same in every phase has no effect.
    if (const auto rates = surrogateRange(phase_surrogates, &Surrogate::rate_per_s); rates.low < rates.high)
        out.model.rate_per_s = rates;
    out.model.dome_travel_m = computeDomeTravel(out.model, domes[out.reference], dome_columns);
    // Do not clamp the surrogate. If the phase at an end of the range is left out, its prediction must
    // extrapolate.
    left_out.v = left_out.rate_per_s = {-1e3, 1e3};
    for (std::size_t p = 0; p < phases.size(); ++p) {
        regress(velocities, phase_surrogates, out.reference, p, left_out);
        makeTangential(left_out, kNormalDepth_m);
        const DomeMap &from = domes[out.reference], &to = domes[p];
        PhaseReport& report = out.phases[p];
        report.name = phases[p].name;
        report.surrogate = phase_surrogates[p];
        report.dome_m = domeHeight(to, from, dome_columns);
        report.no_motion = computeResidual({}, phase_surrogates[p], from, to, dome_columns);
        report.fitted = computeResidual(out.model, phase_surrogates[p], from, to, dome_columns);
        report.left_out = computeResidual(left_out, phase_surrogates[p], from, to, dome_columns);
    }
    out.reference_hu = fixed.hu;
    out.voxel_m = fixed.hu.grid.spacing_m;
    out.columns = dome_columns.columns.size();
    return out;
}

std::vector<Surrogate> readPhaseSignal(const std::filesystem::path& csv, std::size_t phases) {
    constexpr std::size_t kMaxBytes = 64 << 10;
    return parsePhaseSignal(readWholeFile(csv, kMaxBytes), csv, phases);
}

std::vector<Surrogate> parsePhaseSignal(std::string_view csv, const std::filesystem::path& file,
                                        std::size_t phases) {
    std::vector<Surrogate> out;
    CsvReader rows(file, csv, "phase,v,rate_per_s");
    while (rows.next()) {
        if (out.size() == phases) rows.refuseRow("more rows than phases");
        rows.text();  // the phase's name
        const auto v = rows.number(-10.0, 10.0);
        out.push_back({v, rows.number(-100.0, 100.0)});
    }
    if (out.size() != phases)
        throw DataError(file, "phase",
                        std::to_string(out.size()) + " rows for " + std::to_string(phases) + " phases");
    return out;
}

}  // namespace stylet::modeller
