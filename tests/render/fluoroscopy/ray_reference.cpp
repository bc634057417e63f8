#include "tests/render/fluoroscopy/ray_reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "patient/displacement/tool_displacement.h"
#include "tests/render/phantoms.h"

namespace stylet::test {
namespace {

constexpr double kMuWater = 19.3;

double attenuationFromHu(std::int16_t hu) {
    return hu < -970 ? 0.0 : kMuWater * (1.0 + hu / 1000.0);
}

struct Box {
    Vec3 low, high;
};
Box patientBox(const Grid& grid, double beyond_ends_m) {
    const Vec3 half = 0.5 * grid.spacing_m + Vec3(0.0, 0.0, beyond_ends_m);
    return {grid.origin_m - half, grid.centre(grid.dims - 1) + half};
}

// Computes the shares of the line, 0 to 1, at which it enters and leaves the box. Returns false if it misses
// the box.
bool clip(const XrayLine& line, const Box& box, double& begin, double& end) {
    begin = 0.0, end = 1.0;
    const Vec3 way = line.pixel_m - line.source_m;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = box.low[axis] - line.source_m[axis], b = box.high[axis] - line.source_m[axis];
        if (way[axis] == 0.0) {
            if (a > 0.0 || b < 0.0) return false;
            continue;
        }
        begin = std::max(begin, std::min(a / way[axis], b / way[axis]));
        end = std::min(end, std::max(a / way[axis], b / way[axis]));
    }
    return end > begin;
}

double sampleTrilinear(const patient::ContrastTable& table, const Vec3& p) {
    const Vec3 at = table.grid.toVoxels(p);
    const Index3 low(glm::floor(at));
    const Vec3 f = at - Vec3(low);
    double sum = 0.0;
    for (int k = 0; k < 8; ++k) {
        const Index3 corner(k & 1, (k >> 1) & 1, k >> 2), i = low + corner;
        if (!table.grid.contains(i)) continue;
        const Vec3 w = glm::mix(1.0 - f, f, Vec3(corner));
        sum += w.x * w.y * w.z * double(table.added_per_m[table.grid.offset(i)]);
    }
    return sum;
}

}  // namespace

XrayLine xrayLine(const render::FluoroscopyInput& input, int column, int row, int pixels, double detector_m) {
    // C-arm frame: x to the patient's right, y from source to detector, z toward the head.
    const double x = (0.5 - (column + 0.5) / pixels) * detector_m;
    const double z = (0.5 - (row + 0.5) / pixels) * detector_m;
    const double o = input.arm.orbital_rad, a = input.arm.angulation_rad;
    const auto turned = [&](const Vec3& p) {
        const Vec3 slid(p.x * std::cos(o) - p.y * std::sin(o), p.x * std::sin(o) + p.y * std::cos(o), p.z);
        const Vec3 tilted(slid.x, slid.y * std::cos(a) - slid.z * std::sin(a),
                          slid.y * std::sin(a) + slid.z * std::cos(a));
        return input.patient_from_isocentre * tilted;
    };
    return {turned({0.0, -0.720, 0.0}), turned({x, 0.380, z})};
}

double exactPath(const CtVolume& ct, const XrayLine& line) {
    double begin = 0.0, end = 1.0;
    if (!clip(line, patientBox(ct.grid, 0.0), begin, end)) return 0.0;
    const Vec3 way = line.pixel_m - line.source_m;
    std::vector<double> crossings{begin, end};
    for (int axis = 0; axis < 3; ++axis) {
        if (way[axis] == 0.0) continue;
        for (int plane = 0; plane <= ct.grid.dims[axis]; ++plane) {
            const double at = ct.grid.origin_m[axis] + (plane - 0.5) * ct.grid.spacing_m[axis];
            const double share = (at - line.source_m[axis]) / way[axis];
            if (share > begin && share < end) crossings.push_back(share);
        }
    }
    std::sort(crossings.begin(), crossings.end());
    double sum = 0.0;
    for (std::size_t i = 1; i < crossings.size(); ++i) {
        const Vec3 middle = line.source_m + 0.5 * (crossings[i - 1] + crossings[i]) * way;
        sum += (crossings[i] - crossings[i - 1]) * attenuationFromHu(ct.nearestOr(middle, -1000));
    }
    return sum * glm::length(way);
}

double finePath(const XrayPatient& patient, const XrayLine& line) {
    const CtVolume& ct = patient.package->ct;
    double begin = 0.0, end = 1.0;
    if (!clip(line, patientBox(ct.grid, patient.beyond_ends_m), begin, end)) return 0.0;
    const Vec3 way = line.pixel_m - line.source_m;
    const double length_m = (end - begin) * glm::length(way);
    const int steps = int(std::ceil(length_m / patient.step_m));
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        Vec3 p = line.source_m + (begin + (end - begin) * (i + 0.5) / steps) * way;
        if (patient.tool) p -= displacementAt(*patient.tool, p);
        p = referenceFromDeformed(patient.package->motion, patient.breath, p);
        sum += attenuationFromHu(ct[glm::clamp(ct.grid.nearest(p), Index3(0), ct.grid.dims - 1)]);
        if (patient.contrast) sum += sampleTrilinear(*patient.contrast, p);
    }
    return sum * length_m / steps;
}

double shaftPath(const render::XrayShape& shape, const XrayLine& line) {
    const Vec3 d = glm::normalize(line.pixel_m - line.source_m), o = line.source_m - shape.begin_m;
    const Vec3 axis = shape.end_m - shape.begin_m, u = glm::normalize(axis);
    const double du = glm::dot(d, u), ou = glm::dot(o, u);
    const double s0 = -ou / du, s1 = (glm::length(axis) - ou) / du;
    const auto chord_m = [&](double radius_m) {
        const Vec3 across = d - du * u, off = o - ou * u;
        const double a = glm::dot(across, across), b = glm::dot(across, off);
        const double rest = b * b - a * (glm::dot(off, off) - radius_m * radius_m);
        if (rest <= 0.0) return 0.0;
        const double low = std::max((-b - std::sqrt(rest)) / a, std::min(s0, s1));
        const double high = std::min((-b + std::sqrt(rest)) / a, std::max(s0, s1));
        return std::max(high - low, 0.0);
    };
    return shape.per_m * (chord_m(shape.radius_m) - (shape.bore_m > 0.0 ? chord_m(shape.bore_m) : 0.0));
}

ShaftErrors shaftErrors(const std::function<std::vector<double>(const render::XrayShape&)>& draw,
                        const render::FluoroscopySettings& settings, double radius_m, double turned_rad,
                        double tilted_rad, const Vec3& isocentre_m) {
    constexpr int kOffsets = 5, kRows = 4;  // rows to either side of the middle
    const int pixels = settings.pixels;
    const double pitch_m =
        settings.detector_m / pixels * render::kSourceToIsocentre_m / render::kSourceToDetector_m;
    const bool by_rows = std::fabs(std::cos(turned_rad)) >= std::sqrt(0.5);
    // Distance between neighbouring rays of a row or column, across the shaft.
    const double step_m =
        pitch_m * std::max(std::fabs(std::cos(turned_rad)), std::fabs(std::sin(turned_rad)));
    const Vec3 along(std::sin(turned_rad) * std::cos(tilted_rad), std::sin(tilted_rad),
                     std::cos(turned_rad) * std::cos(tilted_rad));
    const double expected =
        render::kSteelPerM * std::numbers::pi * radius_m * radius_m / std::cos(tilted_rad);
    ShaftErrors errors;
    double palest = std::numeric_limits<double>::infinity(), densest = 0.0;
    for (int offset = 0; offset < kOffsets; ++offset) {
        const double aside_m = pitch_m * offset / kOffsets;
        const Vec3 middle = isocentre_m + (by_rows ? Vec3(aside_m, 0.0, 0.0) : Vec3(0.0, 0.0, aside_m));
        const std::vector<double> paths =
            draw({.begin_m = middle - 0.05 * along, .end_m = middle + 0.05 * along, .radius_m = radius_m});
        for (int row = pixels / 2 - kRows; row < pixels / 2 + kRows; ++row) {
            double sum = 0.0, peak = 0.0;
            for (int i = 0; i < pixels; ++i) {
                const double path = paths[std::size_t(by_rows ? row * pixels + i : i * pixels + row)];
                sum += path * step_m, peak = std::max(peak, path);
            }
            errors.area = std::max(errors.area, std::fabs(sum / expected - 1.0));
            palest = std::min(palest, peak), densest = std::max(densest, peak);
        }
    }
    errors.flicker = 1.0 - palest / densest;
    return errors;
}

double zncc(const std::vector<double>& a, const std::vector<double>& b) {
    double mean_a = 0.0, mean_b = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        mean_a += a[i] / double(a.size()), mean_b += b[i] / double(a.size());
    double ab = 0.0, aa = 0.0, bb = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ab += (a[i] - mean_a) * (b[i] - mean_b);
        aa += (a[i] - mean_a) * (a[i] - mean_a);
        bb += (b[i] - mean_b) * (b[i] - mean_b);
    }
    return ab / std::sqrt(aa * bb);
}

double pathPsnr(const std::vector<double>& reference, const std::vector<double>& other) {
    const auto [low, high] = std::minmax_element(reference.begin(), reference.end());
    double sum = 0.0;
    for (std::size_t i = 0; i < reference.size(); ++i)
        sum += (reference[i] - other[i]) * (reference[i] - other[i]) / double(reference.size());
    return 10.0 * std::log10((*high - *low) * (*high - *low) / sum);
}

patient::Package makeXrayPhantom(const Vec3& half_m, double spacing_m,
                                 const std::function<double(const Vec3&)>& hu) {
    patient::Package package = emptyPackage(half_m, spacing_m);
    const Grid& grid = package.ct.grid;
    forEachVoxel(grid, [&](const Index3& i) {
        double sum = 0.0;
        for (int k = 0; k < 64; ++k)
            sum += hu(grid.centre(i) + spacing_m * (Vec3(k % 4, k / 4 % 4, k / 16) - 1.5) / 4.0);
        package.ct[i] = std::int16_t(std::lround(sum / 64.0));
    });
    return package;
}

patient::Package finerCt(const patient::Package& coarse) {
    const CtVolume& from = coarse.ct;
    Grid grid = from.grid;
    grid.dims *= 2;
    grid.spacing_m *= 0.5;
    grid.origin_m -= 0.5 * grid.spacing_m;
    patient::Package fine = coarse;
    fine.ct = CtVolume(grid);
    fine.labels = LabelVolume(grid);
    forEachVoxel(grid, [&](const Index3& i) {
        const Index3 low = (i - 1) / 2, last = from.grid.dims - 1;  // i - 1 = -1 rounds to 0
        double sum = 0.0;
        for (int k = 0; k < 8; ++k) {
            const Index3 corner(k & 1, (k >> 1) & 1, k >> 2);
            double weight = 1.0;
            for (int axis = 0; axis < 3; ++axis) {
                const double f = std::clamp(0.5 * i[axis] - 0.25 - low[axis], 0.0, 1.0);
                weight *= corner[axis] ? f : 1.0 - f;
            }
            if (weight > 0.0) sum += weight * double(from[glm::min(low + corner, last)]);
        }
        fine.ct[i] = std::int16_t(std::lround(sum));
    });
    return fine;
}

}  // namespace stylet::test
