#include "app/modeller/segmentation/fascia_spline.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "app/modeller/image/import_image.h"
#include "app/modeller/segmentation/morphology.h"
#include "base/statistics.h"

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

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
    double u = phi / kTurn * s.around;
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

double valueOf(const Support& at, const std::vector<double>& control) {
    double r = 0.0;
    for (std::size_t i = 0; i < 16; ++i)
        r += at.weight[i] * control[at.control[i]];
    return r;
}

// --- The fit ---

constexpr double kInsideBone_m = 0.0015, kOutsideOrgan_m = 0.0010;
constexpr double kFarOff_m = 0.4;

// The allowed range of the radius in each cell of the dense first fit.
struct Room {
    std::vector<double> low_m, high_m;
};

void cover(const Mask& mask, const WallSurface& s, const auto& see) {
    const Grid& g = mask.grid;
    const double half_m = 0.5 * std::max(g.spacing_m.x, g.spacing_m.y);
    for (int z = 0; z < g.dims.z; ++z) {
        const double height_m = g.centre({0, 0, z}).z;
        const int level =
            std::clamp(int(std::lround((height_m - s.z_begin_m) / s.z_step_m)), 0, s.levels - 1);
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                if (!mask[{x, y, z}]) continue;
                const Vec3 d = g.centre({x, y, z}) - s.axis_m;
                const double r = std::hypot(d.x, d.y), a = std::atan2(d.y, d.x) / kTurn * s.angles;
                const double reach = std::min(4.0, half_m / std::max(r, half_m) / kTurn * s.angles);
                for (int k = int(std::lround(a - reach)); k <= int(std::lround(a + reach)); ++k)
                    see(std::size_t(level * s.angles + (k + s.angles) % s.angles), r);
            }
    }
}

Room roomOf(const FasciaInput& in, const WallSurface& s) {
    const auto n = std::size_t(s.angles * s.levels);
    Room room{std::vector<double>(n, 0.0), std::vector<double>(n, kFarOff_m)};
    cover(in.bones, s, [&](std::size_t cell, double r) {
        room.high_m[cell] = std::min(room.high_m[cell], r - kInsideBone_m);
    });
    cover(in.organs, s, [&](std::size_t cell, double r) {
        room.low_m[cell] = std::max(room.low_m[cell], r + kOutsideOrgan_m);
    });
    for (std::size_t i = 0; i < n; ++i)
        room.low_m[i] = std::min(room.low_m[i], room.high_m[i]);
    return room;
}

// --- The belly wall ---

// One ray: the radius where the muscle begins below the skin's fat, and the muscle's thickness if fat
// behind it is visible. 0: not visible.
struct BellyRay {
    double outer_m = 0.0, thick_m = 0.0;
};

BellyRay bellyRay(const FasciaInput& in, const Mask& inner, const FloatVolume& hu, const Vec3& axis_m,
                  double phi, double z_m) {
    constexpr double kStep_m = 0.001, kMuscle_hu = 5.0, kFat_hu = -40.0, kMost_m = 0.030;
    const Grid& g = in.ct.grid;
    BellyRay out;
    int muscle = 0, fat = 0;
    for (double r = 0.35; r > 0.02; r -= kStep_m) {
        const Index3 i = g.nearest({axis_m.x + r * std::cos(phi), axis_m.y + r * std::sin(phi), z_m});
        if (!g.contains(i) || !inner[i]) continue;
        if (in.bones[i]) return {};
        const double v = double(hu[i]);
        if (out.outer_m == 0.0) {
            muscle = v > kMuscle_hu ? muscle + 1 : 0;
            if (muscle == 4) out.outer_m = r + 3.0 * kStep_m;
        } else if (in.organs[i] || out.outer_m - r > kMost_m) {
            return out;
        } else {
            fat = v < kFat_hu ? fat + 1 : 0;
            if (fat == 3) {
                out.thick_m = out.outer_m - r - 2.5 * kStep_m;
                return out;
            }
        }
    }
    return out;
}

bool boneNear(const Room& room, const WallSurface& s, int level, int angle) {
    const int reach_z = int(0.024 / s.z_step_m), reach = 3;
    for (int dz = -reach_z; dz <= reach_z; ++dz)
        for (int da = -reach; da <= reach; ++da) {
            const int z = std::clamp(level + dz, 0, s.levels - 1), a = (angle + da + s.angles) % s.angles;
            if (room.high_m[std::size_t(z * s.angles + a)] < kFarOff_m) return true;
        }
    return false;
}

// Below the ribs, the wall is one muscle thickness inside the muscle's outer face. The thickness varies
// much more from the flank to the midline than from the ribs to the hip, and bowel hides it in places.
// Therefore each angle has one thickness, the median of its rays. It replaces a ray's own thickness if the
// two differ too much.
void seeBelly(const FasciaInput& in, const Room& room, const WallSurface& s, std::vector<double>& target) {
    constexpr double kSkin_m = 0.006, kAgree_m = 0.005;
    constexpr int kReach = 3;
    constexpr std::size_t kLeastRays = 5;
    const Mask inner = eroded(in.body, kSkin_m);
    FloatVolume hu(in.ct.grid);
    for (std::size_t i = 0; i < hu.voxels.size(); ++i)
        hu.voxels[i] = float(in.ct.voxels[i]);
    hu = boxMean(hu, 1);
    std::vector<BellyRay> rays(target.size());
    forEachSlab(s.levels, [&](int z) {
        for (int a = 0; a < s.angles; ++a) {
            const double phi = a * kTurn / s.angles;
            if (std::sin(phi) < -0.5 || boneNear(room, s, z, a))
                continue;  // the back's muscles do not show the wall
            rays[std::size_t(z * s.angles + a)] =
                bellyRay(in, inner, hu, s.axis_m, phi, s.z_begin_m + z * s.z_step_m);
        }
    });
    std::vector<double> near;
    const auto gather = [&](int z0, int z1, int a, int reach, double BellyRay::* what) {
        near.clear();
        for (int z = std::max(z0, 0); z <= std::min(z1, s.levels - 1); ++z)
            for (int da = -reach; da <= reach; ++da) {
                const BellyRay& r = rays[std::size_t(z * s.angles + (a + da + s.angles) % s.angles)];
                if (r.*what > 0.0) near.push_back(r.*what);
            }
        return near.size() >= kLeastRays ? upperMedian(near) : 0.0;
    };
    for (int a = 0; a < s.angles; ++a) {
        const double thick_m = gather(0, s.levels - 1, a, 2, &BellyRay::thick_m);
        if (thick_m == 0.0) continue;
        for (int z = 0; z < s.levels; ++z) {
            const std::size_t cell = std::size_t(z * s.angles + a);
            const BellyRay& ray = rays[cell];
            if (ray.outer_m == 0.0) continue;
            const double usual_m = gather(z - kReach, z + kReach, a, kReach, &BellyRay::outer_m);
            if (std::fabs(ray.outer_m - usual_m) > kAgree_m) continue;  // a fold, the navel or the midline
            const bool own = std::fabs(ray.thick_m - thick_m) < kAgree_m;
            target[cell] = ray.outer_m - (own ? ray.thick_m : thick_m);
        }
    }
}

// Between two ribs the fascia lies on the lung, or one diaphragm thickness outside the organ below the
// diaphragm.
void seeOrgans(const FasciaInput& in, const Room& room, const WallSurface& s, std::vector<double>& target) {
    constexpr double kNear_m = 0.009, kDiaphragm_m = 0.002, kDeep_m = 0.005;
    constexpr std::int16_t kLung_hu = -400;
    const Grid& g = in.ct.grid;
    for (int z = 0; z < s.levels; ++z)
        for (int a = 0; a < s.angles; ++a) {
            const std::size_t cell = std::size_t(z * s.angles + a);
            const double low_m = room.low_m[cell], gap_m = s.radius_m[cell] - low_m;
            if (low_m == 0.0 || room.high_m[cell] < kFarOff_m || gap_m > kNear_m || !boneNear(room, s, z, a))
                continue;
            const double phi = a * kTurn / s.angles, r = low_m - kDeep_m;
            const Index3 i = g.nearest({s.axis_m.x + r * std::cos(phi), s.axis_m.y + r * std::sin(phi),
                                        s.z_begin_m + z * s.z_step_m});
            const bool lung = g.contains(i) && in.ct[i] < kLung_hu;
            target[cell] = low_m + (lung ? 0.0 : kDiaphragm_m);
        }
}

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
            const double v = weight[n] * valueOf(at[n], c);
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
        const auto dotOf = [](const std::vector<double>& a, const std::vector<double>& b) {
            double sum = 0.0;
            for (std::size_t i = 0; i < a.size(); ++i)
                sum += a[i] * b[i];
            return sum;
        };
        std::vector<double> r = rightSide();
        const std::vector<double> begun = normal(c);
        for (std::size_t i = 0; i < r.size(); ++i)
            r[i] -= begun[i];
        std::vector<double> p = r;
        double rr = dotOf(r, r);
        const double enough = 1e-16 * std::max(rr, 1e-12);
        for (int step = 0; step < 150 && rr > enough; ++step) {
            const std::vector<double> ap = normal(p);
            const double alpha = rr / dotOf(p, ap);
            for (std::size_t i = 0; i < c.size(); ++i) {
                c[i] += alpha * p[i];
                r[i] -= alpha * ap[i];
            }
            const double next = dotOf(r, r);
            for (std::size_t i = 0; i < p.size(); ++i)
                p[i] = r[i] + next / rr * p[i];
            rr = next;
        }
    }
};

// --- The text ---

constexpr int kMostAround = 360, kMostLevels = 1000;
constexpr double kMostRadius_mm = 1000.0, kMostPlace_mm = 10000.0;

class Reader {
  public:
    Reader(const fs::path& file, std::string_view text) : file_(file), rest_(text) {}

    // Reads the next line that is not empty or a comment and splits it at blanks. Returns false at the end.
    bool next() {
        while (!rest_.empty()) {
            std::string_view line = rest_.substr(0, rest_.find('\n'));
            rest_.remove_prefix(std::min(line.size() + 1, rest_.size()));
            ++number_;
            line = line.substr(0, line.find('#'));
            words_.clear();
            while (true) {
                const auto from = line.find_first_not_of(" \t\r");
                if (from == std::string_view::npos) break;
                line.remove_prefix(from);
                const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
                words_.push_back(word);
                line.remove_prefix(word.size());
            }
            if (!words_.empty()) return true;
        }
        ++number_;
        return false;
    }
    [[noreturn]] void refuse(const std::string& why) const {
        throw ImportError(file_.string() + ": line " + std::to_string(number_) + ": " + why);
    }
    const std::vector<std::string_view>& words() const { return words_; }
    double number(std::size_t word, const std::string& field, double low, double high) const {
        double v = 0.0;
        const std::string_view w = words_[word];
        const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), v);
        if (error != std::errc() || end != w.data() + w.size())
            refuse(field + " \"" + std::string(w.substr(0, 40)) + "\" is not a number");
        if (!(v >= low && v <= high)) {
            char range[80];
            std::snprintf(range, sizeof range, " must be from %g to %g", low, high);
            refuse(field + range);
        }
        return v;
    }
    // Reads a line that starts with `key` and has `count` numbers.
    void expect(const std::string& key, std::size_t count) {
        if (!next()) refuse(key + " is missing");
        if (words_[0] != key)
            refuse(key + " was expected, not \"" + std::string(words_[0].substr(0, 40)) + "\"");
        if (words_.size() != count + 1)
            refuse(key + " needs " + std::to_string(count) + (count == 1 ? " number" : " numbers") +
                   ", not " + std::to_string(words_.size() - 1));
    }
    double value(const std::string& key, double low, double high) {
        expect(key, 1);
        return number(1, key, low, high);
    }
    int whole(const std::string& key, int low, int high) {
        const double v = value(key, low, high);
        if (v != std::floor(v)) refuse(key + " is not a whole number");
        return int(v);
    }

  private:
    fs::path file_;
    std::string_view rest_;
    std::vector<std::string_view> words_;
    int number_ = 0;
};

std::string mm(double metres) {
    char out[40];
    std::snprintf(out, sizeof out, " %.2f", 1e3 * metres);
    return out;
}

}  // namespace

double FasciaSpline::radiusAt(double phi, double h_m) const {
    return valueOf(supportAt(*this, phi, h_m), control_m);
}

FasciaSpline fitFascia(const FasciaInput& in) {
    // The first fit, cell by cell, has determined what each ray shows and which rays are misleading.
    const WallSurface seen = fitWall(in);
    const Room room = roomOf(in, seen);
    FasciaSpline s;
    s.axis_m = seen.axis_m;
    s.h_begin_m = seen.z_begin_m;
    const double height_m = (seen.levels - 1) * seen.z_step_m;
    s.levels = std::max(1, int(std::ceil(height_m / s.h_step_m))) + 3;
    double mean = 0.0;
    for (const double r : seen.radius_m)
        mean += r / double(seen.radius_m.size());
    s.control_m.assign(std::size_t(s.around * s.levels), mean);

    Fit fit{s, {}, seen.radius_m, std::vector<double>(seen.radius_m.size(), 1.0)};
    for (int z = 0; z < seen.levels; ++z)
        for (int a = 0; a < seen.angles; ++a)
            fit.at.push_back(supportAt(s, a * kTurn / seen.angles, seen.z_begin_m + z * seen.z_step_m));
    seeBelly(in, room, seen, fit.target);
    seeOrgans(in, room, seen, fit.target);
    // Where the surface still cuts bones or organs, pull it away, with more weight in each round.
    constexpr int kRounds = 6;
    constexpr double kHarder = 6.0, kHardest = 400.0;
    for (int round = 0; round < kRounds; ++round) {
        fit.solve(s.control_m);
        for (std::size_t n = 0; n < fit.at.size(); ++n) {
            const double r = valueOf(fit.at[n], s.control_m);
            if (r >= room.low_m[n] && r <= room.high_m[n]) continue;
            fit.target[n] = std::clamp(r, room.low_m[n], room.high_m[n]);
            fit.weight[n] = std::min(fit.weight[n] * kHarder, kHardest);
        }
    }
    fit.solve(s.control_m);
    for (double& c : s.control_m)
        c = std::clamp(c, 0.001, 1e-3 * kMostRadius_mm);
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
            fine.radius_m.push_back(s.radiusAt(a * kTurn / fine.angles, fine.z_begin_m + z * fine.z_step_m));
    return insideWall(fine, in);
}

Mask fasciaVoxels(const FasciaSpline& s, const FasciaInput& in) {
    Mask free(in.body.grid);
    for (std::size_t i = 0; i < free.voxels.size(); ++i)
        free.voxels[i] = in.body.voxels[i] && !in.bones.voxels[i] && !in.organs.voxels[i];
    return rasteriseBoundary(insideFascia(s, in), free);
}

std::string writeFascia(const FasciaSpline& s) {
    std::string out =
        "# The fascia's control radii about an upright axis, in mm: rows from the feet to the head, columns\n"
        "# from the patient's right side by the front, the left side and the back. Edit and build again.\n"
        "stylet-fascia 1\naxis_mm" +
        mm(s.axis_m.x) + mm(s.axis_m.y) + "\nh_begin_mm" + mm(s.h_begin_m) + "\nh_step_mm" + mm(s.h_step_m) +
        "\naround " + std::to_string(s.around) + "\nlevels " + std::to_string(s.levels) + "\n";
    for (int row = 0; row < s.levels; ++row) {
        out += "row " + std::to_string(row);
        for (int k = 0; k < s.around; ++k)
            out += mm(s.control_m[std::size_t(row * s.around + k)]);
        out += "\n";
    }
    return out;
}

FasciaSpline parseFascia(const fs::path& file, std::string_view text) {
    Reader in(file, text);
    FasciaSpline s;
    if (in.value("stylet-fascia", 1, kMostLevels) != 1.0)
        in.refuse("stylet-fascia: this version is not known");
    in.expect("axis_mm", 2);
    s.axis_m = 1e-3 * Vec3(in.number(1, "axis_mm", -kMostPlace_mm, kMostPlace_mm),
                           in.number(2, "axis_mm", -kMostPlace_mm, kMostPlace_mm), 0.0);
    s.h_begin_m = 1e-3 * in.value("h_begin_mm", -kMostPlace_mm, kMostPlace_mm);
    s.h_step_m = 1e-3 * in.value("h_step_mm", 1.0, 1000.0);
    s.around = in.whole("around", 4, kMostAround);
    s.levels = in.whole("levels", 4, kMostLevels);
    for (int row = 0; row < s.levels; ++row) {
        const std::string field = "row " + std::to_string(row);
        if (!in.next()) in.refuse(field + " is missing");
        if (in.words().size() < 2 || in.words()[0] != "row" || in.words()[1] != std::to_string(row))
            in.refuse(field + " was expected");
        if (in.words().size() != std::size_t(s.around) + 2)
            in.refuse(field + " needs " + std::to_string(s.around) + " radii, not " +
                      std::to_string(in.words().size() - 2));
        for (std::size_t k = 0; k < std::size_t(s.around); ++k)
            s.control_m.push_back(
                1e-3 * in.number(k + 2, field + ", radius " + std::to_string(k), 1.0, kMostRadius_mm));
    }
    if (in.next()) in.refuse("nothing may follow the last row");
    return s;
}

}  // namespace stylet::modeller
