#include "app/modeller/wall/fascia_spline.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/image/morphology.h"
#include "app/modeller/wall/fascia_surface.h"
#include "base/line_reader.h"
#include "base/parallel.h"
#include "base/text.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr double kRim_m = 0.0012;        // uncertainty of an organ's border
constexpr double kDiaphragm_m = 0.0015;  // its least thickness: the distance of diagonal voxels of 1 mm
constexpr double kStrayPiece_ml = 0.5, kAllStray_ml = 2.0;
constexpr double kUnseenWeight = 0.02;  // in the fit, of a ray that does not show the fascia

// --- The basis ---

std::array<double, 4> cubicWeights(double t) {
    const double s = 1.0 - t;
    return {s * s * s / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0, t * t * t / 6.0};
}

// The sixteen control points that influence (phi, h).
struct Support {
    std::array<std::size_t, 16> control;
    std::array<double, 16> weight;
};

Support supportAt(const FasciaSpline& s, double phi, double h_m) {
    double u = phi / kFullTurn * s.around;
    u -= std::floor(u / s.around) * s.around;
    const double v = std::clamp((h_m - s.h_begin_m) / s.h_step_m, 0.0, double(s.levels - 3));
    const int a = std::min(int(u), s.around - 1), row = std::min(int(v), s.levels - 4);
    const auto wu = cubicWeights(u - a), wv = cubicWeights(v - row);
    Support out;
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            const int k = (a + i - 1 + s.around) % s.around;
            out.control[std::size_t(4 * j + i)] = std::size_t((row + j) * s.around + k);
            out.weight[std::size_t(4 * j + i)] = wu[std::size_t(i)] * wv[std::size_t(j)];
        }
    return out;
}

double evaluate(const Support& at, const std::vector<double>& control) {
    double r = 0.0;
    for (std::size_t i = 0; i < 16; ++i)
        r += at.weight[i] * control[at.control[i]];
    return r;
}

// --- The fit ---

// Minimises sum weight (r - target)^2 + stiffness |second differences|^2 by conjugate gradients on the
// normal equations.
struct Fit {
    const FasciaSpline& shape;
    std::vector<Support> at;
    std::vector<double> target, weight;

    void addBending(const std::vector<double>& c, std::vector<double>& out) const {
        constexpr double kStiff = 0.02;
        const auto bend = [&](std::size_t a, std::size_t b, std::size_t d) {
            const double v = kStiff * (c[a] - 2.0 * c[b] + c[d]);
            out[a] += v;
            out[b] -= 2.0 * v;
            out[d] += v;
        };
        const auto n = std::size_t(shape.around), rows = std::size_t(shape.levels);
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t k = 0; k < n; ++k) {
                bend(row * n + k, row * n + (k + 1) % n, row * n + (k + 2) % n);
                if (row + 2 < rows) bend(row * n + k, (row + 1) * n + k, (row + 2) * n + k);
            }
    }
    std::vector<double> normal(const std::vector<double>& c) const {
        std::vector<double> out(c.size(), 0.0);
        for (std::size_t n = 0; n < at.size(); ++n) {
            const double v = weight[n] * evaluate(at[n], c);
            for (std::size_t i = 0; i < 16; ++i)
                out[at[n].control[i]] += at[n].weight[i] * v;
        }
        addBending(c, out);
        return out;
    }
    std::vector<double> rightSide() const {
        std::vector<double> out(std::size_t(shape.around * shape.levels), 0.0);
        for (std::size_t n = 0; n < at.size(); ++n)
            for (std::size_t i = 0; i < 16; ++i)
                out[at[n].control[i]] += at[n].weight[i] * weight[n] * target[n];
        return out;
    }
    void solve(std::vector<double>& c) const {
        const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
            double sum = 0.0;
            for (std::size_t i = 0; i < a.size(); ++i)
                sum += a[i] * b[i];
            return sum;
        };
        std::vector<double> r = rightSide();
        const std::vector<double> initial = normal(c);
        for (std::size_t i = 0; i < r.size(); ++i)
            r[i] -= initial[i];
        std::vector<double> p = r;
        double rr = dot(r, r);
        const double tolerance = 1e-16 * std::max(rr, 1e-12);
        for (int step = 0; step < 150 && rr > tolerance; ++step) {
            const std::vector<double> ap = normal(p);
            const double alpha = rr / dot(p, ap);
            for (std::size_t i = 0; i < c.size(); ++i) {
                c[i] += alpha * p[i];
                r[i] -= alpha * ap[i];
            }
            const double next = dot(r, r);
            for (std::size_t i = 0; i < p.size(); ++i)
                p[i] = r[i] + next / rr * p[i];
            rr = next;
        }
    }
};

// --- Text format ---

constexpr int kMaxAround = 360, kMaxLevels = 1000;
constexpr double kMaxRadius_mm = 1000.0, kMaxPosition_mm = 10000.0;

class FasciaReader {
  public:
    FasciaReader(const fs::path& file, std::string_view text) : lines_(file, text) {}

    // Reads the next line that is not empty or a comment and splits it at blanks. Returns false at the end.
    bool next() {
        words_.clear();
        while (words_.empty() && !lines_.done()) {
            std::string_view line = lines_.next();
            line = trimmed(line.substr(0, line.find('#')));
            while (!line.empty()) {
                words_.push_back(line.substr(0, line.find_first_of(" \t\r")));
                line = trimmed(line.substr(words_.back().size()));
            }
        }
        if (words_.empty()) lines_.next();  // errors name the line after the last
        return !words_.empty();
    }
    [[noreturn]] void refuse(const std::string& why) const { lines_.refuse(why); }
    const std::vector<std::string_view>& words() const { return words_; }
    double number(std::size_t word, const std::string& field, double low, double high) const {
        const auto v = parseNumber<double>(words_[word]);
        if (!v) refuse(fmt::format("{} \"{}\" is not a number", field, words_[word].substr(0, 40)));
        if (!(*v >= low && *v <= high)) refuse(fmt::format("{} must be from {:g} to {:g}", field, low, high));
        return *v;
    }
    // Reads a line that starts with `key` and has `count` numbers.
    void expect(const std::string& key, std::size_t count) {
        if (!next()) refuse(key + " is missing");
        if (words_[0] != key)
            refuse(fmt::format("{} was expected, not \"{}\"", key, words_[0].substr(0, 40)));
        if (words_.size() != count + 1)
            refuse(fmt::format("{} needs {} {}, not {}", key, count, count == 1 ? "number" : "numbers",
                               words_.size() - 1));
    }
    double value(const std::string& key, double low, double high) {
        expect(key, 1);
        return number(1, key, low, high);
    }
    int wholeNumber(const std::string& key, int low, int high) {
        const double v = value(key, low, high);
        if (v != std::floor(v)) refuse(key + " is not a whole number");
        return int(v);
    }

  private:
    LineReader lines_;
    std::vector<std::string_view> words_;
};

std::string formatMm(double metres) {
    return fmt::format(" {:.2f}", 1e3 * metres);
}

}  // namespace

double FasciaSpline::radiusAt(double phi, double h_m) const {
    return evaluate(supportAt(*this, phi, h_m), control_m);
}

Mask withoutRim(const Mask& organs) {
    return eroded(organs, kRim_m);
}

FasciaSpline fitFascia(const FasciaInput& all) {
    const Mask bones = wallBones(all);
    const FasciaInput in{all.ct, all.body, bones, all.organs};
    const WallSurface wall = fitWall(in);
    RadiusBounds bounds = computeRadiusBounds(in, wall, 0.0, kMaxCells);
    for (std::size_t i = 0; i < bounds.low_m.size(); ++i)
        bounds.low_m[i] = std::min(bounds.low_m[i], bounds.high_m[i]);
    ObservedFascia seen = observeFascia(in, wall, bounds);
    for (double& w : seen.weight)
        w += kUnseenWeight;
    FasciaSpline s;
    s.axis_m = wall.axis_m;
    s.h_begin_m = wall.z_begin_m;
    const double height_m = (wall.levels - 1) * wall.z_step_m;
    s.levels = std::max(1, int(std::ceil(height_m / s.h_step_m))) + 3;
    double mean = 0.0;
    for (const double r : seen.radius_m)
        mean += r / double(seen.radius_m.size());
    s.control_m.assign(std::size_t(s.around * s.levels), mean);

    Fit fit{s, {}, seen.radius_m, seen.weight};
    for (int z = 0; z < wall.levels; ++z)
        for (int a = 0; a < wall.angles; ++a)
            fit.at.push_back(supportAt(s, a * kFullTurn / wall.angles, wall.z_begin_m + z * wall.z_step_m));
    // Where the surface still cuts bones or organs, pull it away. The weight grows in each round.
    constexpr int kRounds = 3;
    constexpr double kWeightGrowth = 2.0, kMaxWeight = 4.0;
    for (int round = 0; round < kRounds; ++round) {
        fit.solve(s.control_m);
        for (std::size_t n = 0; n < fit.at.size(); ++n) {
            const double r = evaluate(fit.at[n], s.control_m);
            if (r >= bounds.low_m[n] && r <= bounds.high_m[n]) continue;
            fit.target[n] = std::clamp(r, bounds.low_m[n], bounds.high_m[n]);
            fit.weight[n] = std::min(fit.weight[n] * kWeightGrowth, kMaxWeight);
        }
    }
    fit.solve(s.control_m);
    for (double& c : s.control_m)
        c = std::clamp(c, 0.001, 1e-3 * kMaxRadius_mm);
    return s;
}

Mask insideFascia(const FasciaSpline& s, const FasciaInput& in) {
    const Grid& g = in.body.grid;
    WallSurface fine;
    fine.axis_m = s.axis_m;
    fine.z_begin_m = g.origin_m.z;
    fine.z_step_m = g.spacing_m.z;
    fine.angles = 720;
    fine.levels = std::max(2, g.dims.z);
    for (int z = 0; z < fine.levels; ++z)
        for (int a = 0; a < fine.angles; ++a)
            fine.radius_m.push_back(
                s.radiusAt(a * kFullTurn / fine.angles, fine.z_begin_m + z * fine.z_step_m));
    return insideWall(fine, in);
}

Mask fasciaVoxels(const Mask& inside, const FasciaInput& in) {
    const Mask free = maskWhere(in.body.grid, [&](std::size_t i) {
        return in.body.voxels[i] && !in.bones.voxels[i] && !in.organs.voxels[i];
    });
    return rasteriseBoundary(inside, free);
}

Mask muscleAtFascia(const Mask& organs, const Mask& liver_and_spleen, const Mask& inside,
                    const Mask& fascia) {
    const Mask cut_off = intersect(subtract(organs, inside), dilated(fascia, kRim_m));
    const Mask behind = intersect(intersect(liver_and_spleen, inside), dilated(fascia, kDiaphragm_m));
    return subtract(unite(cut_off, behind), fascia);
}

Mask strayLiver(const Mask& liver, const Mask& inside) {
    const Components pieces = findComponents(subtract(liver, inside), Connectivity::corners);
    const double voxel_ml = voxelVolume_ml(liver.grid);
    const Mask stray = componentsWhere(
        pieces, [&](std::size_t n) { return double(pieces.size[n]) * voxel_ml < kStrayPiece_ml; });
    return volume_ml(stray) > kAllStray_ml ? Mask(liver.grid) : stray;
}

std::string writeFascia(const FasciaSpline& s) {
    std::string out =
        "# The fascia's control radii about an upright axis, in mm: rows from the feet to the head, columns\n"
        "# from the patient's right side by the front, the left side and the back. Edit and build again.\n"
        "stylet-fascia 1\naxis_mm" +
        formatMm(s.axis_m.x) + formatMm(s.axis_m.y) + "\nh_begin_mm" + formatMm(s.h_begin_m) + "\nh_step_mm" +
        formatMm(s.h_step_m) + fmt::format("\naround {}\nlevels {}\n", s.around, s.levels);
    for (int row = 0; row < s.levels; ++row) {
        out += "row " + std::to_string(row);
        for (int k = 0; k < s.around; ++k)
            out += formatMm(s.control_m[std::size_t(row * s.around + k)]);
        out += "\n";
    }
    return out;
}

FasciaSpline parseFascia(const fs::path& file, std::string_view text) {
    FasciaReader in(file, text);
    FasciaSpline s;
    if (in.value("stylet-fascia", 1, kMaxLevels) != 1.0)
        in.refuse("stylet-fascia: this version is not known");
    in.expect("axis_mm", 2);
    s.axis_m = 1e-3 * Vec3(in.number(1, "axis_mm", -kMaxPosition_mm, kMaxPosition_mm),
                           in.number(2, "axis_mm", -kMaxPosition_mm, kMaxPosition_mm), 0.0);
    s.h_begin_m = 1e-3 * in.value("h_begin_mm", -kMaxPosition_mm, kMaxPosition_mm);
    s.h_step_m = 1e-3 * in.value("h_step_mm", 1.0, 1000.0);
    s.around = in.wholeNumber("around", 4, kMaxAround);
    s.levels = in.wholeNumber("levels", 4, kMaxLevels);
    for (int row = 0; row < s.levels; ++row) {
        const std::string field = "row " + std::to_string(row);
        if (!in.next()) in.refuse(field + " is missing");
        if (in.words().size() < 2 || in.words()[0] != "row" || in.words()[1] != std::to_string(row))
            in.refuse(field + " was expected");
        if (in.words().size() != std::size_t(s.around) + 2)
            in.refuse(fmt::format("{} needs {} radii, not {}", field, s.around, in.words().size() - 2));
        for (std::size_t k = 0; k < std::size_t(s.around); ++k)
            s.control_m.push_back(
                1e-3 * in.number(k + 2, field + ", radius " + std::to_string(k), 1.0, kMaxRadius_mm));
    }
    if (in.next()) in.refuse("nothing may follow the last row");
    return s;
}

}  // namespace stylet::modeller
