#include "app/modeller/motion/motion_fit.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "app/modeller/motion/motion_cavity.h"
#include "base/line_reader.h"
#include "base/smoothstep.h"
#include "base/statistics.h"
#include "base/whole_file.h"

namespace stylet::modeller {

using patient::MotionModel;
using patient::Surrogate;

namespace {

constexpr double kMargin_m = 0.030;  // beyond the images; the fields fade out there
constexpr float kLeastWeight = 0.02f;
constexpr int kRelaxations = 200;
constexpr int kLevelPasses = 6;
// The registered field already slides along the wall: only the nodes on the surface itself are corrected.
constexpr double kNormalDepth_m = 0.0;
constexpr float kOutsidePicture_hu = -1000.0f;

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

// 1 inside the images, 0 on the outermost nodes.
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

template <typename Visit>
void eachNode(const Grid& nodes, const Visit& visit) {
    forEachSlab(nodes.dims.z, [&](int z) {
        Index3 i{0, 0, z};
        for (i.y = 0; i.y < nodes.dims.y; ++i.y)
            for (i.x = 0; i.x < nodes.dims.x; ++i.x)
                visit(i, nodes.offset(i));
    });
}

// Sets unknown nodes to the mean of their neighbours, for a field as smooth as possible.
void fillUnknown(const Grid& nodes, const std::vector<unsigned char>& known, std::vector<Vec3>& values) {
    std::vector<unsigned char> set = known;
    const std::size_t strides[3] = {1, std::size_t(nodes.dims.x),
                                    std::size_t(nodes.dims.x) * std::size_t(nodes.dims.y)};
    std::vector<Vec3> next = values;
    for (int pass = 0; pass < kRelaxations; ++pass) {
        std::vector<unsigned char> next_set = set;
        eachNode(nodes, [&](const Index3& i, std::size_t at) {
            if (known[at]) return;
            Vec3 sum(0.0);
            int count = 0;
            for (int d = 0; d < 3; ++d)
                for (const int way : {-1, 1}) {
                    if (i[d] + way < 0 || i[d] + way >= nodes.dims[d]) continue;
                    const std::size_t other = way < 0 ? at - strides[d] : at + strides[d];
                    if (set[other]) sum += values[other], ++count;
                }
            if (count > 0) next[at] = sum / double(count), next_set[at] = 1;
        });
        std::swap(values, next);
        next = values;
        set = next_set;
    }
}

// The field at the nodes: its mean around each node, over voxels weighted by `inside`.
std::vector<Vec3> atNodes(const VectorField& field, const FloatVolume& inside, const Grid& nodes,
                          const Grid& image) {
    std::vector<Vec3> values(nodes.voxelCount(), Vec3(0.0));
    std::vector<unsigned char> known(values.size(), 0);
    const Grid& g = field.grid;
    const double sigma_m = 0.5 * nodes.spacing_m.x;
    eachNode(nodes, [&](const Index3& n, std::size_t at) {
        const Vec3 p = nodes.centre(n), v = g.toVoxels(p);
        Index3 low, high;
        for (int d = 0; d < 3; ++d) {
            const double reach = 2.0 * sigma_m / g.spacing_m[d];
            low[d] = std::max(0, int(std::ceil(v[d] - reach)));
            high[d] = std::min(g.dims[d] - 1, int(std::floor(v[d] + reach)));
        }
        Vec3 sum(0.0);
        double weights = 0.0;
        Index3 i;
        for (i.z = low.z; i.z <= high.z; ++i.z)
            for (i.y = low.y; i.y <= high.y; ++i.y)
                for (i.x = low.x; i.x <= high.x; ++i.x) {
                    const Vec3 away = (g.centre(i) - p) / sigma_m;
                    const double w = double(inside[i]) *
                                     std::exp(-0.5 * (away.x * away.x + away.y * away.y + away.z * away.z));
                    sum += w * Vec3(field[i]);
                    weights += w;
                }
        if (weights < double(kLeastWeight)) return;
        values[at] = sum / weights;
        known[at] = 1;
    });
    fillUnknown(nodes, known, values);
    eachNode(nodes, [&](const Index3& i, std::size_t at) { values[at] *= window(nodes, image, i); });
    return values;
}

// The share of each of the field's voxels that is inside the mask.
FloatVolume weightsOf(const Mask& mask, const Grid& grid) {
    FloatVolume fine(mask.grid), out(grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        fine.voxels[i] = mask.voxels[i] ? 1.0f : 0.0f;
    eachNode(grid,
             [&](const Index3& i, std::size_t at) { out.voxels[at] = valueAt(fine, grid.centre(i), 0.0f); });
    return out;
}

// Voxels inside and outside the chest cavity.
struct FitMasks {
    const Mask& cavity;
    const Mask& outside;
};

// Registers a phase twice. First the outside of the cavity; then, with that motion undone, the inside, so
// that both images share one mask.
NodeVelocities velocitiesOf(const Phase& fixed, const Phase& moving, const FitMasks& masks, const Grid& nodes,
                            const FitSettings& settings, double& log_error_m) {
    NodeVelocities out;
    const auto field = [&](const FloatVolume& picture, const Mask& mask) {
        double error_m = 0.0;
        VectorField velocity =
            logarithm(registerPhases(fixed.hu, picture, mask, settings.registration), error_m);
        log_error_m = std::max(log_error_m, error_m);
        return velocity;
    };
    const VectorField wall = field(moving.hu, masks.outside);
    out.wall_m = atNodes(wall, weightsOf(masks.outside, wall.grid), nodes, fixed.hu.grid);
    // Undo the motion as the model will apply it, interpolated from the nodes.
    VectorField coarse(nodes);
    for (std::size_t i = 0; i < coarse.voxels.size(); ++i)
        coarse.voxels[i] = glm::vec3(out.wall_m[i]);
    const FloatVolume rested = warped(moving.hu, exponential(coarse), kOutsidePicture_hu);
    const VectorField slide = field(rested, masks.cavity);
    out.slide_m = atNodes(slide, weightsOf(masks.cavity, slide.grid), nodes, fixed.hu.grid);
    return out;
}

// Smooths the voxel steps out of the level at the nodes.
void smoothLevel(MotionModel& m) {
    const std::size_t strides[3] = {1, std::size_t(m.grid.dims.x),
                                    std::size_t(m.grid.dims.x) * std::size_t(m.grid.dims.y)};
    for (int pass = 0; pass < kLevelPasses; ++pass)
        for (int d = 0; d < 3; ++d) {
            const std::vector<float> old = m.level_m;
            eachNode(m.grid, [&](const Index3& i, std::size_t at) {
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
    const FloatVolume level = levelOf(cavity);
    const Vec3 low = level.grid.origin_m, high = level.grid.centre(level.grid.dims - 1);
    eachNode(nodes, [&](const Index3& i, std::size_t at) {
        m.level_m[at] = valueAt(level, glm::clamp(nodes.centre(i), low, high), 0.0f);
    });
    smoothLevel(m);
    return m;
}

Residual residualOf(const MotionModel& m, const Surrogate& now, const DomeMap& from, const DomeMap& to,
                    const DomeColumns& judged) {
    Residual r;
    std::vector<double> all_m;
    double slice_m = 0.0;
    int slice_count = 0;
    for (const auto& [x, y] : judged.columns) {
        const Vec3 p(from.grid.origin_m.x + x * from.grid.spacing_m.x,
                     from.grid.origin_m.y + y * from.grid.spacing_m.y, double(from.at(x, y)));
        const Vec3 moved = deformedFromReference(m, now, p);
        const double off_m = moved.z - to.heightAt(moved.x, moved.y);
        if (!std::isfinite(off_m)) continue;
        r.mean_m += off_m;
        all_m.push_back(std::fabs(off_m));
        r.mean_abs_m += all_m.back();
        if (y == judged.slice_y) slice_m += all_m.back(), ++slice_count;
    }
    if (all_m.empty() || slice_count == 0) throw ImportError("a phase shows no dome where the others do");
    r.mean_m /= double(all_m.size());
    r.mean_abs_m /= double(all_m.size());
    r.slice_mean_abs_m = slice_m / slice_count;
    r.p95_m = lowerQuantile(std::move(all_m), 0.95);
    return r;
}

// Travel of the dome from end-exhale to end-inhale.
double travelOf(const MotionModel& m, const DomeMap& reference, const DomeColumns& judged) {
    double sum_m = 0.0;
    for (const auto& [x, y] : judged.columns) {
        const Vec3 p(reference.grid.origin_m.x + x * reference.grid.spacing_m.x,
                     reference.grid.origin_m.y + y * reference.grid.spacing_m.y, double(reference.at(x, y)));
        sum_m += p.z - deformedFromReference(m, {m.v.high, 0.0}, p).z;
    }
    return std::max(0.0, sum_m / double(judged.columns.size()) / (m.v.high - m.reference.v));
}

double domeHeight(const DomeMap& map, const DomeMap& reference, const DomeColumns& judged) {
    double sum_m = 0.0;
    for (const auto& [x, y] : judged.columns)
        sum_m += double(map.at(x, y)) - double(reference.at(x, y));
    return sum_m / double(judged.columns.size());
}

patient::SurrogateRange rangeOf(const std::vector<Surrogate>& surrogates, double Surrogate::* what) {
    patient::SurrogateRange range{surrogates.front().*what, surrogates.front().*what};
    for (const Surrogate& s : surrogates)
        range.low = std::min(range.low, s.*what), range.high = std::max(range.high, s.*what);
    return range;
}

std::size_t lowestOf(const std::vector<Surrogate>& s) {
    return std::size_t(
        std::min_element(s.begin(), s.end(), [](const auto& a, const auto& b) { return a.v < b.v; }) -
        s.begin());
}

}  // namespace

std::vector<Surrogate> surrogateFrom(const std::vector<double>& densities, double period_s) {
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
             std::size_t reference, std::size_t without, MotionModel& m) {
    // The regressors are the same at every node, and so are the weights of the phases.
    double vv = 0.0, vr = 0.0, rr = 0.0;
    const auto dv = [&](std::size_t p) { return surrogates[p].v - surrogates[reference].v; };
    const auto dr = [&](std::size_t p) {
        return surrogates[p].rate_per_s - surrogates[reference].rate_per_s;
    };
    const auto used = [&](std::size_t p) { return p != reference && p != without; };
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
        domes.push_back(domeOf(phase.hu));
    DomeColumns judged = judgedColumns(domes, 0);
    const auto surrogates = [&] {
        return settings.signal.empty() ? surrogateFrom(lungDensityAway(phases, judged), settings.period_s)
                                       : readPhaseSignal(settings.signal, phases.size());
    };
    FittedMotion out;
    out.reference = lowestOf(surrogates());
    judged = judgedColumns(domes, out.reference);
    const std::vector<Surrogate> driven = surrogates();
    settings.progress("surrogate, " + std::to_string(judged.columns.size()) + " columns of the dome");

    const Mask cavity = chestCavity(phases);
    Mask outside(cavity.grid);
    for (std::size_t i = 0; i < cavity.voxels.size(); ++i)
        outside.voxels[i] = cavity.voxels[i] == 0;
    settings.progress("cavity");

    const Phase& fixed = phases[out.reference];
    const Grid nodes = nodeGrid(fixed.hu.grid, settings.grid_m);
    std::vector<NodeVelocities> velocities(phases.size());
    out.phases.resize(phases.size());
    for (std::size_t p = 0; p < phases.size(); ++p) {
        if (p == out.reference) continue;
        velocities[p] =
            velocitiesOf(fixed, phases[p], {cavity, outside}, nodes, settings, out.phases[p].log_error_m);
        settings.progress("registered " + phases[p].name);
    }
    velocities[out.reference] = {std::vector<Vec3>(nodes.voxelCount()),
                                 std::vector<Vec3>(nodes.voxelCount())};

    // A package's reference frame is a breathing state at rest (rate 0).
    out.model = emptyModel(nodes, cavity, {driven[out.reference].v, 0.0});
    MotionModel left_out = out.model;
    regress(velocities, driven, out.reference, phases.size(), out.model);
    makeTangential(out.model, kNormalDepth_m);
    out.model.v = rangeOf(driven, &Surrogate::v);
    // A rate that is the same in every phase has no effect.
    if (const auto rates = rangeOf(driven, &Surrogate::rate_per_s); rates.low < rates.high)
        out.model.rate_per_s = rates;
    out.model.dome_travel_m = travelOf(out.model, domes[out.reference], judged);
    // No clamping: a phase at the end of the range is judged by extrapolation beyond the other phases.
    left_out.v = left_out.rate_per_s = {-1e3, 1e3};
    for (std::size_t p = 0; p < phases.size(); ++p) {
        regress(velocities, driven, out.reference, p, left_out);
        makeTangential(left_out, kNormalDepth_m);
        const DomeMap &from = domes[out.reference], &to = domes[p];
        PhaseReport& report = out.phases[p];
        report.name = phases[p].name;
        report.surrogate = driven[p];
        report.dome_m = domeHeight(to, from, judged);
        report.still = residualOf({}, driven[p], from, to, judged);
        report.fitted = residualOf(out.model, driven[p], from, to, judged);
        report.left_out = residualOf(left_out, driven[p], from, to, judged);
    }
    out.reference_hu = fixed.hu;
    out.voxel_m = fixed.hu.grid.spacing_m;
    out.columns = judged.columns.size();
    return out;
}

std::vector<Surrogate> readPhaseSignal(const std::filesystem::path& csv, std::size_t phases) {
    constexpr std::size_t kMaxBytes = 64 << 10;
    return parsePhaseSignal(readWholeFile(csv, kMaxBytes), csv, phases);
}

std::vector<Surrogate> parsePhaseSignal(std::string_view csv, const std::filesystem::path& file,
                                        std::size_t phases) {
    std::vector<Surrogate> out;
    LineReader lines(file, csv);
    if (lines.next() != "phase,v,rate_per_s") lines.refuse("the header is not phase,v,rate_per_s");
    while (!lines.done()) {
        const std::string_view text = lines.next();
        const std::size_t first = text.find(','), second = text.find(',', first + 1);
        if (second == std::string_view::npos) lines.refuse("not three fields");
        const auto number = [&](std::string_view field, double most) {
            double value = 0.0;
            const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
            if (error != std::errc() || stop != field.data() + field.size() || !(std::fabs(value) <= most))
                lines.refuse("\"" + std::string(field.substr(0, 40)) + "\" is no number of this size");
            return value;
        };
        out.push_back({number(text.substr(first + 1, second - first - 1), 10.0),
                       number(text.substr(second + 1), 100.0)});
        if (out.size() > phases) lines.refuse("more lines than phases");
    }
    if (out.size() != phases)
        throw DataError(file, "phase",
                        std::to_string(out.size()) + " lines for " + std::to_string(phases) + " phases");
    return out;
}

}  // namespace stylet::modeller
