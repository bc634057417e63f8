#include "patient/synth/anatomy.h"

#include <cmath>

#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

constexpr Knot kCageWidth[] = {{-125, 116}, {-80, 116}, {-40, 118}, {0, 121},
                               {40, 124},   {80, 124},  {120, 120}, {180, 108}};
constexpr Knot kCageDepth[] = {{-125, 68}, {-80, 69}, {-40, 71}, {0, 73},
                               {40, 76},   {80, 77},  {120, 77}, {180, 73}};
constexpr Knot kCageCentre[] = {{-125, 2}, {-40, 3}, {40, 4}, {120, 3}, {180, 0}};
constexpr Knot kSpineDepth[] = {{-125, -40}, {-80, -38}, {-30, -41}, {30, -48}, {90, -55}, {180, -58}};
// The liver's lower surface from left to right, at middle depth.
constexpr Knot kLiverLow[] = {{-100, 112}, {-80, 98}, {-60, 86}, {-30, 66},  {0, 46},
                              {30, 20},    {60, -14}, {85, -38}, {105, -50}, {125, -52}};

CageSection usualCage(double z) noexcept {
    return {curve(kCageWidth, z), curve(kCageDepth, z), 0.0, curve(kCageCentre, z)};
}
CageSection resized(const CageSection& usual, const Anatomy& a) noexcept {
    return {usual.a + a.width_mm, usual.b + a.depth_mm, usual.xc, usual.yc};
}

}  // namespace

CageSection Anatomy::cage(double z) const noexcept {
    // Voxels are visited slice by slice: most calls ask for the same height as the one before. `usual`
    // depends on the height alone, not on the patient.
    static thread_local double last_z = std::nan("");
    static thread_local CageSection usual;
    if (z != last_z) {
        usual = usualCage(z);
        last_z = z;
    }
    return resized(usual, *this);
}

double Anatomy::cageDistance(const Vec3& p) const noexcept {
    const CageSection c = cage(p.z);
    const double ex = (p.x - c.xc) / c.a, ey = (p.y - c.yc) / c.b;
    const double rho = std::sqrt(ex * ex + ey * ey);
    const double gx = ex / c.a, gy = ey / c.b;
    const double gradient = std::sqrt(gx * gx + gy * gy);
    return gradient > 1e-9 ? (rho - 1.0) * rho / gradient : -c.b;
}

double Anatomy::front(const Vec3& p) const noexcept {
    const CageSection c = cage(p.z);
    const double ex = (p.x - c.xc) / c.a, ey = (p.y - c.yc) / c.b;
    const double rho = std::sqrt(ex * ex + ey * ey);
    return rho > 1e-9 ? ey / rho : 0.0;
}

Vec3 Anatomy::vertebra(double z) const noexcept {
    const double u = (z - 25.0) / 150.0;
    return {spine_x_mm * (1.0 - u * u), curve(kSpineDepth, z), z};
}

double Anatomy::psoas(const Vec3& p) const noexcept {
    // Psoas widens downwards from the first lumbar vertebra.
    const double grown = ramp(p.z, 5.0, -90.0);
    if (grown <= 0.0) return 1e3;
    const Vec3 v = vertebra(p.z);
    const double r = 5.0 + 14.0 * grown;
    const double side = 24.0 + r * 0.8;
    return ellipsoid({std::fabs(p.x - v.x) - side, p.y - v.y + 1.0, 0.0}, Vec3(0.0), {r, r * 1.15, 1e4});
}

double Anatomy::cavityDistance(const Vec3& p) const noexcept {
    const double wall = cageDistance(p);
    if (p.y > 0.0 || std::fabs(p.x) > 70.0) return wall;
    const Vec3 v = vertebra(p.z);
    const double column = ellipsoid({p.x - v.x, p.y - v.y + 10.0, 0.0}, Vec3(0.0),
                                    {22.5 + 3.5 * ramp(p.z, 60.0, 0.0), 29.0, 1e4});
    const double behind = smoothMin(column, psoas(p) - 2.0, 8.0);
    return smoothMax(wall, -behind, 10.0);
}

double Anatomy::costalMargin(double f) const noexcept {
    // Highest below the sternum, lowest at the side; ends at rib 12 in the back.
    return f > 0.0 ? -22.0 + 120.0 * f * f : -22.0 + 30.0 * ramp(f, -0.2, -0.9);
}

double Anatomy::muscleDepth(const Vec3& p) const noexcept {
    const double f = front(p);
    const double x = std::fabs(p.x);
    const double chest = 10.0;
    const double back = ramp(f, -0.35, -0.88), ahead = ramp(f, 0.45, 0.85);
    const double side = chest + 7.0;
    // The erector muscles lie on either side of the spinous processes.
    const double erectors =
        chest + 5.0 + 21.0 * (1.0 - ramp(x, 50.0, 74.0)) - 5.0 * (1.0 - ramp(x, 2.0, 14.0));
    // Rectus muscles on either side of the linea alba below the costal margin; chest wall above it.
    const double u = std::min(std::fabs(x - 33.0) / 31.0, 1.0);
    const double belly = 4.0 + 8.0 * std::sqrt(1.0 - u * u * u) + 10.0 * ramp(x, 62.0, 80.0);
    const double margin = costalMargin(f);
    const double above = ramp(p.z, margin - 18.0, margin + 4.0);
    const double front_wall = belly * (1.0 - above) + (chest + 3.0) * above;
    const double flank = side + 2.0 * ramp(p.z, 0.0, -60.0);
    return (flank * (1.0 - back) + erectors * back) * (1.0 - ahead) + front_wall * ahead;
}

double Anatomy::skinDepth(const Vec3& p) const noexcept {
    const double f = front(p);
    const double x = std::fabs(p.x);
    const double back = ramp(f, -0.3, -0.9), ahead = ramp(f, 0.3, 0.9);
    const double belly = 5.0 * ramp(p.z, 30.0, -90.0);
    const double love_handle = 7.0 * ramp(p.z, 10.0, -90.0) * (1.0 - ramp(f, 0.3, 0.9));
    const double furrow = 4.0 * (1.0 - ramp(x, 0.0, 22.0)) * back;  // over the spinous processes
    const double fat = fat_side_mm * (1.0 - back - ahead) + fat_back_mm * back +
                       (fat_front_mm + belly) * ahead + love_handle - furrow +
                       0.9 * valueNoise(p / 45.0, seed ^ 0x51);
    // The skin follows a smoothed wall; fat fills the steps between muscles.
    const double wall = (18.0 * (1.0 - back) + 32.0 * back) * (1.0 - ahead) + 12.5 * ahead;
    const double navel = bump(((p.x * p.x) + (p.z + 108.0) * (p.z + 108.0)) / 60.0) * ahead;
    return wall + std::max(fat, 3.0) + 2.0 - 9.0 * navel;
}

double Anatomy::diaphragmHeight(const Vec3& p) const noexcept {
    // Uses the cage's cross-section at the height of the domes, so that the result depends on (x, y) only.
    static const CageSection usual = usualCage(90.0);
    const CageSection c = resized(usual, *this);
    const double ex = (p.x - c.xc) / c.a, ey = (p.y - c.yc) / c.b;
    const double r2 = ex * ex + ey * ey;
    const double f = r2 > 1e-12 ? ey / std::sqrt(r2) : 0.0;
    const double border = f > 0.0 ? 93.0 + 5.0 * f * f : 93.0 - 18.0 * f * f;
    const double right = bump(((p.x - 56.0) * (p.x - 56.0) + (p.y - 6.0) * (p.y - 6.0)) / 3400.0);
    const double left = bump(((p.x + 58.0) * (p.x + 58.0) + (p.y - 2.0) * (p.y - 2.0)) / 3000.0);
    const double crown = 112.0 + (dome_right_mm - 106.0) * right + (dome_left_mm - 106.0) * left;
    const double fall = r2 < 1.0 ? std::sqrt(1.0 - r2) * (1.0 + 0.12 * (1.0 - r2)) : 0.0;
    return border + (crown - border) * fall;
}

double Anatomy::liverDistance(const Vec3& p) const noexcept {
    const double dome = (p.z - diaphragmHeight(p) + 3.2) * 0.8;
    const double wall = cageDistance(p) + 2.8;
    // The lower surface rises to the left and is concave towards the hilum. Its front edge is lower than
    // its back.
    const Vec3& h = organs.hilum;
    const double hollow =
        13.0 * bump(((p.x - h.x - 6.0) * (p.x - h.x - 6.0) + (p.y - h.y) * (p.y - h.y)) / 500.0);
    const double low = curve(kLiverLow, p.x) + organs.liver_low_mm - 0.16 * (p.y - 10.0) + hollow +
                       3.0 * valueNoise(p / 38.0, seed ^ 0x11);
    const double below = (low - p.z) * 0.75;
    // In the back, the right lobe reaches the wall and the left lobe ends in front of the stomach.
    const double right_of_spine = (20.0 - p.x) * 0.8 + (-30.0 - p.y) * 0.6;
    const double ahead_of_stomach = (-2.0 + 0.22 * std::fabs(std::min(p.x, 0.0))) - p.y;
    const double behind = smoothMin(right_of_spine, ahead_of_stomach, 16.0);
    const double tip = -84.0 + organs.liver_left_mm - p.x;
    double d = smoothMax(smoothMax(dome, wall, 3.0), smoothMax(below, behind, 20.0), 16.0);
    d = smoothMax(d, tip, 24.0);
    const double caudate = ellipsoid(p, {4.0, -19.0, 66.0}, {15.0, 12.0, 24.0});
    d = smoothMin(d, caudate, 8.0);
    // Fissure of the round ligament, starting at the lower front edge.
    const double cleft = fissure_mm * ramp(p.y, 38.0, 72.0) - 0.2;
    const double fissure =
        std::max(std::fabs(p.x + 9.0 + 0.2 * (p.y - 30.0) + 2.5 * valueNoise(p / 25.0, seed ^ 0x12)) - cleft,
                 p.z - low - 34.0);
    d = smoothMax(d, -fissure, 3.0);
    if (nodules_mm > 0.0) d += nodules_mm * (1.0 + valueNoise(p / 8.0, seed ^ 0x13));
    d = smoothMax(d, 4.0 - organs.kidneyRight.distance(p), 10.0);
    d = smoothMax(d, 1.5 - organs.gallbladder.distance(p), 6.0);
    return smoothMax(d, cavityDistance(p) + 3.5, 4.0);
}

Vec3 Anatomy::aorta(double z) const noexcept {
    const Vec3 v = vertebra(z);
    return {v.x - 8.0 - 8.0 * ramp(z, 40.0, 150.0), v.y + 31.5 - 7.0 * ramp(z, 70.0, 150.0), z};
}

Vec3 Anatomy::cava(double z) const noexcept {
    const Vec3 v = vertebra(z);
    const double lift = ramp(z, 10.0, 120.0);
    const double atrium = ramp(z, 116.0, 146.0);
    return {v.x + 19.0 + 2.0 * lift - 10.0 * atrium, v.y + 31.0 + 20.0 * lift + 16.0 * atrium, z};
}

Anatomy drawAnatomy(std::uint64_t seed) {
    Random random(seed, 1);
    Anatomy a;
    a.seed = mixBits(seed);
    a.scale = {1.0 + random.jitter(0.035), 1.0 + random.jitter(0.03), 1.0 + random.jitter(0.04)};
    a.width_mm = random.jitter(4.0);
    a.depth_mm = random.jitter(2.5);
    a.fat_side_mm = random.uniform(8.0, 13.0);
    a.fat_front_mm = a.fat_side_mm + random.uniform(0.0, 4.0);
    a.fat_back_mm = random.uniform(7.0, 12.0);
    a.dome_right_mm = 132.0 + random.jitter(6.0);
    a.dome_left_mm = a.dome_right_mm - 14.0 + random.jitter(4.0);
    a.rib_shift_mm = random.jitter(3.0);
    a.rib_drop = 1.0 + random.jitter(0.05);
    a.rib_spread_mm = random.uniform(0.0, 2.0);
    a.spine_x_mm = random.jitter(3.0);

    OrganPlan& o = a.organs;
    o.hilum = Vec3(26.0, 0.0, 48.0) + random.jitter3(3.0);
    o.liver_low_mm = random.jitter(12.0);
    o.liver_left_mm = random.jitter(12.0);
    const Vec3 neck = Vec3(38.0, 16.0, 26.0) + random.jitter3(2.0);
    const Vec3 fundus = Vec3(60.0, 56.0, -18.0) + random.jitter3(4.0);
    const double bladder = random.uniform(14.0, 17.5);
    o.gallbladder = orientedEllipsoid((neck + fundus) * 0.5, fundus - neck, Vec3(1, 0, 0),
                                      {length(fundus - neck) * 0.5, bladder, bladder});
    const double right = random.uniform(50.0, 56.0), left = random.uniform(50.0, 57.0);
    o.kidneyRight = orientedEllipsoid(Vec3(63.0, -33.0, -32.0) + random.jitter3(4.0), {0.22, -0.12, -1.0},
                                      {0.75, -0.65, 0.0}, {right, 28.0, 22.0});
    o.kidneyLeft = orientedEllipsoid(Vec3(-63.0, -33.0, -12.0) + random.jitter3(4.0), {-0.22, -0.12, -1.0},
                                     {-0.75, -0.65, 0.0}, {left, 28.0, 22.0});
    // One random draw per statement, because the evaluation order of arguments is unspecified.
    const Vec3 spleen = Vec3(-91.0, -24.0, 52.0) + random.jitter3(4.0);
    const double spleen_long = random.uniform(50.0, 60.0), spleen_wide = random.uniform(38.0, 44.0);
    o.spleen =
        orientedEllipsoid(spleen, {-0.15, 0.75, -0.65}, {0.3, 0.65, 0.7}, {spleen_long, spleen_wide, 26.0});
    o.heart = orientedEllipsoid(Vec3(-22.0, 28.0, 158.0) + random.jitter3(3.0), {-0.85, 0.45, -0.25},
                                {0, 0, 1}, {60.0, 44.0, 44.0});
    o.tumour = Vec3(27.0, 5.0, -6.0) + random.jitter3(2.0);
    o.tumour_radius = random.uniform(9.0, 13.0);
    return a;
}

}  // namespace stylet::patient::synth
