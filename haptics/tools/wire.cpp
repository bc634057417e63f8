#include "haptics/tools/wire.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/transcendental.h"
#include "haptics/tools/touch.h"

namespace stylet::haptics {

using patient::DuctSpace;
using patient::DuctWall;

namespace {

constexpr int kWireIterations = 5;
// Largest feed per tick, a quarter of a segment. A faster hand stretches the grip's spring.
constexpr double kMaxFeed_m = 0.0005;
// Compression of the whole chain at which it refuses to be fed.
constexpr double kMaxCompression_m = 0.0006;
constexpr double kMaxCorrection_m = 0.001;  // of a node in one iteration
// Cosine of the largest turn within twice kBendReach segments.
constexpr double kFold = -0.5;
// Share of a bend that one iteration removes.
constexpr double kShaftBend = 0.8, kTipBend = 0.3;
// The column is never shorter than this, and the hand's grip slips above the largest load.
constexpr double kShortestColumn_m = 0.002, kMaxColumn_n = 6.0;
// pi^2 / 0.7^2: one end clamped, the other pinned.
constexpr double kEuler = 20.142;
constexpr std::size_t kBendReach = 4;  // segments on either side over which a curvature is taken
constexpr double kMaxTurn_rad = 20.0;  // keeps the capstan's exponential finite
constexpr std::size_t kChainPoints = kMaxWireNodes + 2;

Vec3 directionOf(const Vec3& v) noexcept {
    return unitOr(v, Vec3(0.0));
}

int wireNodeCount(double fed_m) noexcept {
    return fed_m > 0.0 ? std::min(kMaxWireNodes, int(std::ceil(fed_m / kWireRest_m))) : 0;
}

// The chain during one solve. Point 0 is the tip, point `count` the base; the one behind it gives the
// direction of the needle.
class Chain {
  public:
    Chain(const WireState& s, const WireSettings& settings, const DuctSpace& ducts, const WireBase& base,
          double fed_m) noexcept
        : settings_(settings), ducts_(ducts), fed_m_(fed_m), count_(std::size_t(wireNodeCount(fed_m))) {
        const double free_from_m = s.in_lumen ? s.solid_m : fed_m;
        for (std::size_t i = 0; i < count_ + 2; ++i) {
            const double from_base_m = fed_m - double(i) * kWireRest_m;
            const bool pinned = i >= count_ || from_base_m <= free_from_m;
            free_[i] = pinned ? 0.0 : 1.0;
            touches_[i] = !pinned && from_base_m <= s.pierced_m;
            at_[i] = !pinned && i < std::size_t(s.count) ? s.nodes_m[i] : base.at_m + from_base_m * base.axis;
        }
        at_[count_] = base.at_m;
        at_[count_ + 1] = base.at_m - kWireRest_m * base.axis;
        start_m_ = at_[0];
    }

    void solve() noexcept {
        for (int i = 0; i < kWireIterations; ++i) {
            straighten();
            touchWalls();
            restoreLengths();
        }
        touchWalls();
    }
    double compression_m() const noexcept {
        double sum_m = 0.0;
        for (std::size_t i = 0; i < count_; ++i)
            sum_m += std::max(0.0, rest_m(i) - glm::length(at_[i] - at_[i + 1]));
        return sum_m;
    }
    // False if a node has left the lumen, or is not a number.
    bool isInLumen() const noexcept {
        for (std::size_t i = 0; i < count_; ++i)
            if (touches_[i] && !(patient::ductLevelAt(ducts_, at_[i]) <= 0.0)) return false;
        return true;
    }
    // True if the wire turns back on itself. In a duct of 3 mm radius that takes 0.3 N, more than the floppy
    // column carries.
    bool isFolded() const noexcept {
        for (std::size_t i = 2 * kBendReach; i < count_ + 2; ++i) {
            const Vec3& middle = at_[i - kBendReach];
            const Vec3 before = directionOf(at_[i - 2 * kBendReach] - middle);
            if (glm::dot(before, directionOf(middle - at_[i])) < kFold) return true;
        }
        return false;
    }
    void store(WireState& s) const noexcept {
        s.count = int(count_);
        std::copy_n(at_.begin(), count_, s.nodes_m.begin());
        s.fed_m = fed_m_;
    }

  private:
    // Of the segment between points i and i + 1.
    double rest_m(std::size_t i) const noexcept {
        return i + 1 < count_ ? kWireRest_m : fed_m_ - double(count_ - 1) * kWireRest_m;
    }

    void straighten() noexcept {
        for (std::size_t i = 1; i <= count_; ++i) {
            const double before_m = rest_m(i - 1), after_m = i < count_ ? rest_m(i) : kWireRest_m;
            const Vec3 straight = (after_m * at_[i - 1] + before_m * at_[i + 1]) / (before_m + after_m);
            const bool floppy = double(i) * kWireRest_m < settings_.tip_length_m;
            const Vec3 step = (floppy ? kTipBend : kShaftBend) * (straight - at_[i]);
            at_[i - 1] -= 0.25 * free_[i - 1] * step;
            at_[i] += 0.5 * free_[i] * step;
            at_[i + 1] -= 0.25 * free_[i + 1] * step;
        }
    }

    void touchWalls() noexcept {
        for (std::size_t i = 0; i < count_; ++i) {
            // Most nodes lie off the wall and need no normal.
            if (!touches_[i] || !(patient::ductLevelAt(ducts_, at_[i]) + settings_.radius_m() > 0.0))
                continue;
            const DuctWall wall = patient::ductWallAt(ducts_, at_[i]);
            const double depth_m = wall.level_m + settings_.radius_m();
            at_[i] = i == 0 && sticks(wall) ? start_m_ : at_[i] - depth_m * wall.outward;
        }
    }
    // True if the tip meets the wall so steeply that friction holds it (Coulomb's cone).
    bool sticks(const DuctWall& wall) const noexcept {
        const double head_on = glm::dot(directionOf(at_[0] - at_[1]), wall.outward);
        const double mu = settings_.tip_friction;
        return head_on * std::sqrt(1.0 + mu * mu) > 1.0;
    }

    // One Newton step for the lengths of all segments at once: a tridiagonal system of their tensions, solved
    // by elimination from the tip on.
    void restoreLengths() noexcept {
        std::array<Vec3, kChainPoints> along;
        std::array<double, kChainPoints> upper{}, tension{};
        for (std::size_t i = 0; i < count_; ++i) {
            const Vec3 d = at_[i] - at_[i + 1];
            const double l = glm::length(d);
            along[i] = l > 0.0 ? d / l : Vec3(0.0);
            double diagonal = free_[i] + free_[i + 1] + 1e-9, right = l - rest_m(i);
            if (i > 0) {
                const double lower = -free_[i] * glm::dot(along[i - 1], along[i]);
                upper[i - 1] = lower / upper[i - 1];  // holds the diagonal until here
                diagonal -= lower * upper[i - 1];
                right -= lower * tension[i - 1];
            }
            upper[i] = diagonal;
            tension[i] = right / diagonal;
        }
        for (std::size_t i = count_; i-- > 1;)
            tension[i - 1] -= upper[i - 1] * tension[i];
        // Where the chain folds, the system is nearly singular. The limit keeps every node near its place.
        for (std::size_t i = 0; i < count_; ++i) {
            Vec3 step = tension[i] * along[i];
            if (i > 0) step -= tension[i - 1] * along[i - 1];
            const double travel_m = glm::length(step);
            if (travel_m > kMaxCorrection_m) step *= kMaxCorrection_m / travel_m;
            at_[i] -= free_[i] * step;
        }
    }

    const WireSettings& settings_;
    const DuctSpace& ducts_;
    double fed_m_;
    std::size_t count_;
    Vec3 start_m_{0.0};
    std::array<Vec3, kChainPoints> at_;
    std::array<double, kChainPoints> free_{};  // inverse mass: 0 for a pinned point
    std::array<bool, kChainPoints> touches_{};
};

// Point of the wire `i` segments behind the tip; straight in the needle.
Vec3 wirePoint(const WireState& s, const WireBase& base, int i) noexcept {
    if (i < s.count) return s.nodes_m[std::size_t(i)];
    return base.at_m + (s.fed_m - i * kWireRest_m) * base.axis;
}

// Curvature [1/m] over 16 mm. |t - t'| is the angle for small bends.
double curvatureAt(const WireState& s, const WireBase& base, int i) noexcept {
    const Vec3 at = wirePoint(s, base, i);
    const Vec3 before = directionOf(wirePoint(s, base, i - int(kBendReach)) - at);
    const Vec3 after = directionOf(at - wirePoint(s, base, i + int(kBendReach)));
    return glm::length(before - after) / (double(kBendReach) * kWireRest_m);
}

// Updates the sum of all bends and the force for moving the wire's stiffness profile through them: feeding by
// dx bends dx more of the tip, and dx of the shaft where the floppy end was.
void measureBends(WireState& s, const WireSettings& settings, const WireBase& base) noexcept {
    s.turn_rad = 0.0;
    Vec3 along = base.axis;
    for (int i = s.count - 1; i >= 0; --i) {
        const Vec3 next =
            directionOf(wirePoint(s, base, i) - (i + 1 < s.count ? wirePoint(s, base, i + 1) : base.at_m));
        s.turn_rad += glm::length(next - along);
        along = next;
    }
    const int shaft =
        std::max(int(kBendReach),
                 int(std::clamp(settings.tip_length_m / kWireRest_m, 0.0, double(kMaxWireNodes)) + 0.5));
    const double tip = curvatureAt(s, base, int(kBendReach)), after = curvatureAt(s, base, shaft);
    const double stiffer = std::max(0.0, settings.shaft_stiffness_n_m2 - settings.tip_stiffness_n_m2);
    s.bend_n = 0.5 * (settings.tip_stiffness_n_m2 * tip * tip + stiffer * after * after);
}

// Tracks where the wire enters the lumen of a duct, and where it leaves it through the wall.
void updatePlace(WireState& s, const WireSettings& settings, const DuctSpace& ducts,
                 const WireBase& base) noexcept {
    if (s.fed_m < s.pierced_m) s.pierced_m = std::numeric_limits<double>::infinity();
    if (s.in_lumen && s.fed_m <= s.solid_m) s.in_lumen = false;
    if (s.in_lumen || s.fed_m <= 0.0) return;
    if (patient::ductWallAt(ducts, wireTip(s, base)).level_m + settings.radius_m() > 0.0) return;
    s.in_lumen = true;
    s.solid_m = s.fed_m;
}

// Returns the length by which the wire was fed: `feed_m`, or 0 if the lumen has no room for it.
double feed(WireState& s, const WireSettings& settings, const DuctSpace& ducts, const WireBase& base,
            double feed_m) noexcept {
    const double fed_m = s.fed_m + feed_m;
    if (fed_m > kMaxWire_m) return 0.0;
    if (fed_m <= 0.0) {
        s.fed_m = fed_m, s.count = 0, s.turn_rad = s.bend_n = 0.0;
        updatePlace(s, settings, ducts, base);
        return feed_m;
    }
    if (!s.in_lumen && s.fed_m <= 0.0) {  // it enters the lumen at once if the needle's tip is there
        s.in_lumen = patient::isInTargetDuct(ducts, base.at_m);
        s.solid_m = 0.0;
    }
    Chain chain(s, settings, ducts, base, fed_m);
    chain.solve();
    const bool inside = chain.isInLumen();
    const bool room =
        feed_m <= 0.0 || (inside && !chain.isFolded() && chain.compression_m() <= kMaxCompression_m);
    if (room && inside) {
        chain.store(s);
    } else if (room) {  // pulled: the rest of the wire stays where it was
        s.fed_m = fed_m;
        s.count = wireNodeCount(fed_m);
    } else {  // the chain relaxes without being fed
        Chain still(s, settings, ducts, base, s.fed_m);
        still.solve();
        if (still.isInLumen()) still.store(s);
    }
    updatePlace(s, settings, ducts, base);
    measureBends(s, settings, base);
    return room ? feed_m : 0.0;
}

}  // namespace

Vec3 wireTip(const WireState& s, const WireBase& base) noexcept {
    return wirePoint(s, base, 0);
}

double columnLoad_n(const WireSettings& settings, double fed_m) noexcept {
    const double column_m = std::max(kShortestColumn_m, std::min(fed_m, settings.tip_length_m));
    return std::min(kMaxColumn_n, kEuler * settings.tip_stiffness_n_m2 / (column_m * column_m));
}

double wireFriction_n(const WireSettings& settings, double fed_m, double turn_rad) noexcept {
    return settings.bore_friction_n + settings.drag_n_per_m * std::max(0.0, fed_m) *
                                          detExp(settings.friction * std::min(turn_rad, kMaxTurn_rad));
}

double stepWire(WireState& s, const WireSettings& settings, const DuctSpace& ducts, const WireBase& base,
                double moved_m) noexcept {
    const double k = settings.grip_n_per_m;
    if (!std::isfinite(moved_m)) moved_m = 0.0;
    s.extension_m += moved_m;
    const double friction_n = wireFriction_n(settings, s.fed_m, s.turn_rad);
    const double slide_n = friction_n + s.bend_n;
    if (k * s.extension_m > slide_n) {
        const bool solid = s.fed_m > 0.0 && (!s.in_lumen || s.fed_m >= s.pierced_m);
        const double column_n = columnLoad_n(settings, s.fed_m);
        const double tip_n = solid ? settings.blunt_n : 0.0;
        const double wanted_m = std::min(s.extension_m - (slide_n + tip_n) / k, kMaxFeed_m);
        double fed_m = 0.0;
        bool stopped = column_n < tip_n;
        if (!stopped && wanted_m > 0.0) {
            fed_m = feed(s, settings, ducts, base, wanted_m);
            stopped = fed_m == 0.0;
        }
        s.extension_m -= fed_m;
        // The tip pierces the wall if the column carries the force for it. It is short then.
        if (stopped && !solid && column_n >= settings.blunt_n &&
            k * s.extension_m >= slide_n + settings.blunt_n)
            s.pierced_m = s.fed_m;
        const double most_m = (slide_n + std::max(column_n, tip_n * double(!stopped))) / k + kMaxFeed_m;
        s.buckled = stopped && s.extension_m >= most_m - kMaxFeed_m;
        s.extension_m = std::min(s.extension_m, stopped ? most_m - kMaxFeed_m : most_m);
    } else if (k * s.extension_m < -friction_n) {
        const double pulled_m = std::max(s.extension_m + friction_n / k, -2.0 * kMaxFeed_m);
        feed(s, settings, ducts, base, pulled_m);
        s.extension_m = std::max(s.extension_m - pulled_m, -friction_n / k - kMaxFeed_m);
        s.buckled = false;
    }
    return k * s.extension_m;
}

double wireEnergy_j(const WireState& s, const WireSettings& settings) noexcept {
    return 0.5 * settings.grip_n_per_m * s.extension_m * s.extension_m;
}

void hashWire(StateHash& hash, const WireState& s) noexcept {
    hash.add(std::uint64_t(s.count) | std::uint64_t(s.in_lumen) << 32 | std::uint64_t(s.buckled) << 33);
    hash.add(s.fed_m, s.extension_m, s.solid_m, s.pierced_m, s.turn_rad, s.bend_n);
    for (int i = 0; i < s.count; ++i)
        hash.add(s.nodes_m[std::size_t(i)]);
}

}  // namespace stylet::haptics
