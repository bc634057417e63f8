#include "tests/render/ultrasound/scan_reference.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>

namespace stylet::test {

using namespace render;
using Complex = std::complex<double>;

namespace {

struct Point {
    int tissue = 0;
    double fluid = 0.0, ln_impedance = 0.0, scatter = 0.0;
    double border_steps = 1e9, facing = -1.0;  // along the line, to the border in its voxel
    Complex noise;
};

double amplitude(double db) {
    return std::pow(10.0, db / 20.0);
}

Complex node(const glm::ivec3& at) {
    std::uint32_t h = std::uint32_t(at.x) * 0x9e3779b1u ^ std::uint32_t(at.y) * 0x85ebca77u ^
                      std::uint32_t(at.z) * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    h ^= h >> 15;
    const double scale = std::sqrt(0.5 / (2.0 * (256.0 * 256.0 - 1.0) / 12.0));
    return scale * Complex(double(h & 255) + double(h >> 8 & 255) - 255.0,
                           double(h >> 16 & 255) + double(h >> 24) - 255.0);
}

// Linear interpolation in the tetrahedra that result from sorting the fractional coordinates.
Complex noiseAt(const Vec3& p) {
    const glm::dmat3 turn = glm::mat3_cast(glm::normalize(glm::dquat(0.83, 0.31, -0.41, 0.22)));
    const Vec3 at = turn * p / kScatterers_m, low = glm::floor(at), f = at - low;
    std::array<int, 3> axes{0, 1, 2};
    std::sort(axes.begin(), axes.end(), [&](int a, int b) { return f[a] > f[b]; });
    glm::ivec3 corner(low);
    double before = 1.0, squares = 0.0;
    Complex sum = 0.0;
    for (int i = 0; i <= 3; ++i) {
        const double next = i < 3 ? f[axes[std::size_t(i)]] : 0.0, w = before - next;
        sum += w * node(corner);
        squares += w * w;
        before = next;
        if (i < 3) ++corner[axes[std::size_t(i)]];
    }
    return sum / std::sqrt(squares);
}

struct Scanner {
    const EncodedPatient& patient;
    const AcousticTable& table;
    const Undeform& undeform;
    const UltrasoundInput& input;
    const UltrasoundSettings& settings;
    const Transducer& probe;
    ScanPlan plan;

    double drawnIn(int tissue) const {
        return plan.step_m * kAssumedSpeed_m_per_s / table.acoustics[std::size_t(tissue)].speed_m_per_s;
    }
    double passesIn(int tissue) const {
        const double lost = attenuation_np_per_m(table.acoustics[std::size_t(tissue)], plan.frequency_hz);
        return std::exp(plan.amplified_np_per_m * drawnIn(tissue) - lost * plan.step_m);
    }
    double drawn(const Point& p) const { return std::lerp(drawnIn(p.tissue), drawnIn(table.gel), p.fluid); }
    double passes(const Point& p) const {
        return std::lerp(passesIn(p.tissue), passesIn(table.gel), p.fluid);
    }
    Point pointAt(const Vec3& reference, const Vec3& direction) const;
    std::vector<NeedleEcho> needleEchoes() const;  // one for each line
    std::vector<Complex> makeLine(const ScanLine&, const NeedleEcho&) const;
    void addPlane(const ScanLine&, std::size_t plane, std::vector<Complex>& bins, double* needle_at,
                  double* needle_left, double needle_m) const;
};

Point Scanner::pointAt(const Vec3& reference, const Vec3& direction) const {
    Point point;
    const Index3 cell = patient.grid.nearest(reference);
    AcousticVoxel voxel;
    voxel.tissue = table.air;
    if (patient.grid.contains(cell)) voxel = unpack(patient.voxels[patient.grid.offset(cell)]);
    point.tissue = voxel.tissue;
    double variation = voxel.variation, to_border_m = 1e9;
    if (voxel.border) {
        const double to_border =
            voxel.near - glm::dot(voxel.normal, patient.grid.toVoxels(reference) - Vec3(cell));
        const Vec3 normal = voxel.normal / patient.grid.spacing_m;
        point.border_steps = to_border / (glm::dot(normal, direction) * plan.step_m);
        point.facing = std::fabs(glm::dot(normal, direction)) / glm::length(normal);
        to_border_m = std::fabs(to_border) / glm::length(normal);
        if (to_border < 0.0) {
            point.tissue = voxel.other;
            variation = 0.0;
        }
    }
    if (point.tissue != table.air && !table.acoustics[std::size_t(point.tissue)].solid)
        point.fluid = fluidShare(input.depots, reference);
    const Acoustic& a = table.acoustics[std::size_t(point.tissue)];
    point.ln_impedance = std::log(a.impedance_rayl) + std::log1p(a.impedance_by_hu) * variation;
    point.ln_impedance = std::lerp(
        point.ln_impedance, std::log(table.acoustics[std::size_t(table.gel)].impedance_rayl), point.fluid);
    point.scatter = amplitude(a.scatter_db + a.scatter_by_hu_db * variation);
    if (a.wall_db && to_border_m < a.wall_m) point.scatter = amplitude(*a.wall_db);
    point.scatter *= 1.0 - point.fluid;
    point.noise = noiseAt(reference);
    return point;
}

void Scanner::addPlane(const ScanLine& line, std::size_t plane, std::vector<Complex>& bins, double* needle_at,
                       double* needle_left, double needle_m) const {
    const int n = settings.samples;
    const Pose& patient_from_probe = *input.patient_from_probe;
    const Vec3 direction = patient_from_probe.direction(line.direction);
    std::vector<Point> points;
    for (int i = 0; i < n; ++i) {
        const double y = plan.planes[plane].sigmas * plan.depths[std::size_t(i)].thickness_sigma_m;
        const Vec3 p = line.origin_m + i * plan.step_m * line.direction + Vec3(0, y, 0);
        points.push_back(pointAt(undeform(patient_from_probe * p), direction));
    }
    points.push_back(points.back());
    struct Change {
        double begins = 0.0, ends = 0.0, at = 0.0, left = 0.0, mirrored = 0.0, jump = 0.0, passes = 1.0;
    };
    std::vector<Change> changes;
    double t = 0.0, left = 1.0;
    for (int k = 0; k < n; ++k) {
        const Point &a = points[std::size_t(k)], &b = points[std::size_t(k) + 1];
        const bool other = a.tissue != b.tissue;
        const bool ahead = a.border_steps >= 0.0 && a.border_steps <= 1.0;
        const bool behind = b.border_steps <= 0.0 && b.border_steps >= -1.0;
        const double share = !other ? 0.5 : ahead ? a.border_steps : behind ? 1.0 + b.border_steps : 0.5;
        const double facing = ahead ? a.facing : b.facing;
        Change c;
        c.jump = 0.5 * (b.ln_impedance - a.ln_impedance);
        const double mirror = std::tanh(c.jump);
        c.mirrored = mirror * (other && facing >= 0.0 ? facing : double(gpu::kUnknownFacing));
        c.begins = t;
        c.at = t + drawn(a) * share;
        c.ends = t + drawn(a) * share + drawn(b) * (1.0 - share);
        c.left = left;
        c.passes = (passes(a) * share + passes(b) * (1.0 - share)) * (1.0 - mirror * mirror);
        const double needle_step = needle_m / plan.step_m - k;
        if (needle_at && needle_step >= 0.0 && needle_step < 1.0) {
            *needle_at = t + (c.ends - t) * needle_step;
            *needle_left = left;
        }
        t = c.ends;
        left *= c.passes;
        changes.push_back(c);
    }
    for (int j = 0; j < n; ++j) {
        const double here = j * plan.bin_m;
        Complex sum = 0.0;
        for (std::size_t k = 0; k < changes.size(); ++k) {
            const Change& c = changes[k];
            const double near = 1.5 - std::fabs(here - c.at) / plan.bin_m;
            sum += plan.mirror_scale * c.mirrored * c.left * std::clamp(near, 0.0, 1.0);
            if (!(here >= c.begins && here < c.ends)) continue;
            const bool after = here >= c.at;
            const Point &p = points[k], &q = points[k + 1];
            const double f = (here - c.begins) / (c.ends - c.begins);
            const double strength =
                (1 - f) * (1 - f) + f * f + 2 * f * (1 - f) * scattererCorrelation(plan.step_m);
            const double grains = (after ? q : p).scatter + table.roughness * std::fabs(c.jump);
            sum += ((1 - f) * p.noise + f * q.noise) / std::sqrt(strength) * grains *
                   (after ? c.left * c.passes : c.left) * plan.depths[std::size_t(j)].speckle;
        }
        bins[std::size_t(j)] += plan.planes[plane].weight * sum;
    }
}

std::vector<NeedleEcho> Scanner::needleEchoes() const {
    std::vector<NeedleEcho> echoes(std::size_t(settings.lines));
    if (!input.patient_from_needle) return echoes;
    const double pitch = linePitch_m(probe, settings.lines, 0.5 * plan.depth_m);
    const double glint =
        reflectivity(table.acoustics[std::size_t(table.gel)], table.acoustics[std::size_t(table.steel)]);
    for (int l = 0; l < settings.lines; ++l)
        echoes[std::size_t(l)] =
            needleEcho(probe, scanLine(probe, 2.0 * l / (settings.lines - 1) - 1.0), pitch,
                       input.patient_from_probe->inverse() * *input.patient_from_needle, input.needle, glint);
    spreadShadows(probe, echoes);
    return echoes;
}

std::vector<Complex> Scanner::makeLine(const ScanLine& line, const NeedleEcho& needle) const {
    const std::size_t n = std::size_t(settings.samples);
    double at = 1e6, left = 0.0;
    std::vector<Complex> raw(n), bins(n);
    for (std::size_t p = 0; p < plan.planes.size(); ++p) {
        const bool middle = p == plan.planes.size() / 2 && needle.depth_m > 0.0;
        addPlane(line, p, raw, middle ? &at : nullptr, &left, needle.depth_m);
    }
    for (std::size_t j = 0; j < n; ++j) {
        for (int d = -6; d <= 6; ++d) {
            const std::ptrdiff_t i = std::ptrdiff_t(j) + d;
            if (i >= 0 && i < std::ptrdiff_t(n))
                bins[j] += plan.pulse[std::size_t(std::abs(d))] * raw[std::size_t(i)];
        }
        const double behind = double(j) * plan.bin_m - at, x = std::clamp(behind / 0.002, 0.0, 1.0);
        bins[j] *= 1.0 - needle.shadow * x * x * (3.0 - 2.0 * x);
        if (needle.amplitude == 0.0) continue;
        double echo = std::exp(-0.5 * behind * behind / (plan.bin_m * plan.bin_m));
        if (behind > 0.0)
            echo += double(gpu::kComet) * std::exp(-behind / double(gpu::kComet_m)) *
                    (0.5 + 0.5 * std::cos(2.0 * M_PI * behind / input.needle.outer_m));
        bins[j] += needle.amplitude * left * echo;
    }
    return bins;
}

}  // namespace

double fluidShare(const std::vector<UltrasoundInput::Depot>& depots, const Vec3& p) {
    double share = 0.0;
    const Vec3 q = p * double(gpu::kLobesPer_m);
    const double lobes =
        (std::sin(q.x + 1.7 * q.y) + std::sin(1.3 * q.y - q.z) + std::sin(1.6 * q.z - 0.7 * q.x)) / 3.0;
    for (const UltrasoundInput::Depot& depot : depots) {
        const double away = glm::distance(p, depot.centre_reference_m) / depot.radius_m *
                            (1.0 + double(gpu::kLobeHeight) * lobes);
        const double x =
            std::clamp((away - double(gpu::kFluidFrom)) / double(gpu::kFluidTo - gpu::kFluidFrom), 0.0, 1.0);
        share = std::max(share, 1.0 - x * x * (3.0 - 2.0 * x));
    }
    return double(gpu::kMostFluid) * share;
}

EncodedPatient encode(const patient::Patient& patient, const AcousticTable& table) {
    Workers workers;
    EncodedPatient encoded{patient.grid(), std::vector<std::uint32_t>(patient.grid().voxelCount())};
    AcousticEncoder(patient, table, workers).encode(0, patient.grid().dims.z, encoded.voxels.data());
    return encoded;
}

ReferenceScan referenceScan(const EncodedPatient& patient, const AcousticTable& table,
                            const Undeform& undeform, const UltrasoundInput& input,
                            const UltrasoundSettings& settings, const Transducer& probe) {
    const Scanner scanner{patient, table, undeform, input, settings, probe, makeScanPlan(probe, settings)};
    std::vector<std::vector<Complex>> field;
    const std::vector<NeedleEcho> needles = scanner.needleEchoes();
    for (int l = 0; l < settings.lines; ++l)
        field.push_back(
            scanner.makeLine(scanLine(probe, 2.0 * l / (settings.lines - 1) - 1.0), needles[std::size_t(l)]));
    ReferenceScan scan{settings.lines, settings.samples, scanner.plan.bin_m, {}};
    for (int l = 0; l < scan.lines; ++l)
        for (int j = 0; j < scan.bins; ++j) {
            const double sigma = scanner.plan.depths[std::size_t(j)].width_sigma_lines;
            const int taps = int(std::ceil(settings.reach_sigma * sigma));
            Complex sum = 0.0;
            double total = 0.0;
            for (int m = std::max(l - taps, 0); m <= std::min(l + taps, scan.lines - 1); ++m) {
                const double w = std::exp(-0.5 * (m - l) * (m - l) / (sigma * sigma));
                sum += w * field[std::size_t(m)][std::size_t(j)];
                total += w;
            }
            scan.envelope.push_back(std::abs(sum) / total);
        }
    return scan;
}

std::vector<double> referencePicture(const ReferenceScan& scan, const UltrasoundSettings& settings,
                                     const Transducer& probe) {
    const ScanPlan plan = makeScanPlan(probe, settings);
    const PictureView view = pictureView(probe, settings, plan.depth_m);
    const auto greyAt = [&](int l, int j) {
        l = std::clamp(l, 0, scan.lines - 1);
        j = std::clamp(j, 0, scan.bins - 1);
        const double e = scan.envelope[std::size_t(l) * std::size_t(scan.bins) + std::size_t(j)];
        const double db = 20.0 * std::log10(std::max(e * plan.depths[std::size_t(j)].gain, 1e-12));
        return std::clamp(1.0 + db / settings.dynamic_range_db, 0.0, 1.0);
    };
    std::vector<double> picture;
    for (int y = 0; y < settings.height; ++y)
        for (int x = 0; x < settings.width; ++x) {
            const double px = view.left_m + (x + 0.5) * view.pixel_m,
                         pz = view.top_m + (y + 0.5) * view.pixel_m;
            double share = px / probe.width_m + 0.5, depth = pz;
            if (probe.shape == TransducerShape::convex) {
                share = std::atan2(px, pz + probe.radius_m) / probe.half_angle_rad * 0.5 + 0.5;
                depth = std::hypot(px, pz + probe.radius_m) - probe.radius_m;
            }
            double grey = 0.0;
            if (share >= 0.0 && share <= 1.0 && depth >= 0.0 && depth <= plan.depth_m) {
                const double l = share * (scan.lines - 1), t = depth / scan.bin_m;
                const int l0 = int(l), t0 = int(t);
                const double u = l - l0, v = t - t0;
                grey = (1 - u) * ((1 - v) * greyAt(l0, t0) + v * greyAt(l0, t0 + 1)) +
                       u * ((1 - v) * greyAt(l0 + 1, t0) + v * greyAt(l0 + 1, t0 + 1));
            }
            picture.push_back(grey);
        }
    return picture;
}

}  // namespace stylet::test
