// Spine, ribs 5 to 12 with their cartilages, sternum.
// Proportions after Gray's Anatomy (41st ed., ch. 54) and Mohr et al. 2007 (rib cross-sections).
#include "base/transcendental.h"
#include "patient/synth/painters.h"
#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

constexpr IdSet kWall = anyOf({Id::muscle, Id::fat});

// Centres of the vertebral bodies from L5 up to T5.
constexpr double kVertebraZ[] = {-142, -105, -69, -34, 0, 31, 60, 88, 115, 141, 166, 190, 213};

std::uint8_t cortex(double depth, double shell) {
    return detailFrom(1.0 - ramp(depth, shell * 0.6, shell * 1.5));
}

struct Vertebra {
    double z, half_height, rx, ry;
};

Vertebra vertebraAt(double z) {
    std::size_t best = 1;
    for (std::size_t i = 1; i + 1 < std::size(kVertebraZ); ++i)
        if (std::fabs(kVertebraZ[i] - z) < std::fabs(kVertebraZ[best] - z)) best = i;
    const double pitch =
        std::min(kVertebraZ[best + 1] - kVertebraZ[best], kVertebraZ[best] - kVertebraZ[best - 1]);
    const double lumbar = ramp(kVertebraZ[best], 100.0, -40.0);
    return {kVertebraZ[best], pitch * 0.5 - 2.0 - 1.3 * lumbar, 15.5 + 6.5 * lumbar, 14.5 + 2.5 * lumbar};
}

// Arch, spinous and transverse processes, facets; q is relative to the body's centre.
double posteriorElements(const Vertebra& v, const Vec3& q) {
    const double canal_y = -v.ry - 7.5;
    const double x = std::fabs(q.x);
    const double lumbar = ramp(v.z, 100.0, -40.0);
    const double ring = ellipsoid({q.x, q.y - canal_y, 0.0}, Vec3(0.0), {14.5, 12.5, 1e4});
    const double arch = std::max(ring, std::fabs(q.z + 2.0) - (q.y > canal_y + 2.0 ? 6.5 : 10.0));
    const double behind = canal_y - 9.0 - q.y;  // increases backwards
    const double droop = -4.0 - behind * (0.75 - 0.5 * lumbar);
    const double spinous = std::max({x - 3.2, -behind - 4.0, behind - 25.0 - 3.0 * lumbar,
                                     std::fabs(q.z - droop) - (6.0 + 5.0 * lumbar)});
    const double transverse = roundCone({x, q.y, q.z}, {9.0, canal_y + 1.0, 2.0},
                                        {33.0, canal_y - 7.0 + 4.0 * lumbar, 4.0}, 5.0, 4.2)
                                  .distance;
    const double facet =
        roundCone({x, q.y, q.z}, {14.5, canal_y - 4.0, -8.0}, {14.5, canal_y - 4.0, -20.0}, 4.5, 4.0)
            .distance;
    return std::min({arch, smoothMin(spinous, arch, 4.0), transverse, facet});
}

// Centre line of a rib: angle around the cage (0 at the back) and height.
struct Rib {
    double head_z, drop, end_deg, cartilage_deg, cartilage_z;  // cartilage_deg 0: floating rib
};
constexpr std::array<Rib, 8> kRibs{{{225, 100, 146, 173, 143},
                                    {201, 104, 140, 173, 127},
                                    {176, 108, 133, 174, 110},
                                    {150, 114, 123, 153, 88},
                                    {124, 122, 113, 139, 60},
                                    {95, 131, 103, 126, 32},
                                    {66, 124, 80, 0, 0},
                                    {36, 112, 50, 0, 0}}};
constexpr double kRibStart_deg = 13.0;

double ribHeight(const Anatomy& a, std::size_t i, double deg) {
    const double u = (deg - kRibStart_deg) / 127.0;
    const double spread = -a.rib_spread_mm * double(i) * ramp(deg, 20.0, 90.0);
    return kRibs[i].head_z + a.rib_shift_mm - a.rib_drop * kRibs[i].drop * (1.35 * u - 0.35 * u * u) + spread;
}

// A point at `depth` outside the cage; side is +1 (right) or -1.
Vec3 onCage(const Anatomy& a, double deg, double z, double depth, double side) {
    const CageSection c = a.cage(z);
    const double radians = deg * 3.14159265358979 / 180.0;
    const double s = detSin(radians), k = -detCos(radians);
    const Vec3 normal = unitOr({s / c.a, k / c.b, 0.0}, Vec3(1, 0, 0));
    const Vec3 p{c.xc + c.a * s + normal.x * depth, c.yc + c.b * k + normal.y * depth, z};
    return {side * p.x, p.y, z};
}

// A flat tube: the cross-section of a stroke, flattened along `normal` (which points out of the wall).
struct FlatStroke {
    Vec3 a, b, normal_a, normal_b;
};

struct FlatLine {
    Vec3 end, end_normal;
    std::vector<FlatStroke> strokes{};

    void lineTo(const Vec3& p, const Vec3& normal) {
        strokes.push_back({end, p, end_normal, normal});
        end = p, end_normal = normal;
    }
};

constexpr double kRibThick = 3.6, kRibHigh = 6.1;

void paintFlat(Canvas& canvas, const std::vector<FlatStroke>& ribs, Id id, double thick, double high,
               double shell) {
    std::vector<Stroke> strokes;
    for (const FlatStroke& f : ribs)
        strokes.push_back({f.a, f.b, high + 0.5, high + 0.5});
    const Stroke* first = strokes.data();
    stamp(canvas, strokes, kWall | only(id),
          [&](const Vec3& p, const ConeHit& hit, const Stroke& s, Voxel voxel) {
              const FlatStroke& f = ribs[std::size_t(&s - first)];
              const Vec3 across = p - mixed(f.a, f.b, hit.share);
              const Vec3 normal = unitOr(mixed(f.normal_a, f.normal_b, hit.share), Vec3(1, 0, 0));
              const double n = dot(across, normal);
              const double rest = std::max(dot(across, across) - n * n, 0.0);
              const double q = std::sqrt(n * n / (thick * thick) + rest / (high * high));
              if (q >= 1.0) return;
              const std::uint8_t rim =
                  shell > 0.0 ? cortex((1.0 - q) * (thick + 1.0), shell) : std::uint8_t(0);
              voxel.set(id, voxel.label == std::uint8_t(id) ? std::min(voxel.detail, rim) : rim);
          });
}

Vec3 outward(const Anatomy& a, const Vec3& p) {
    const CageSection c = a.cage(p.z);
    return unitOr({(p.x - c.xc) / (c.a * c.a), (p.y - c.yc) / (c.b * c.b), 0.0}, Vec3(1, 0, 0));
}

std::vector<FlatStroke> ribLine(const Anatomy& a, std::size_t i, double side) {
    // The neck leaves the vertebral body, meets the transverse process and turns onto the cage.
    const Vec3 begin = onCage(a, kRibStart_deg, ribHeight(a, i, kRibStart_deg), 5.6, side);
    const Vec3 body = a.vertebra(begin.z);
    FlatLine line{{body.x + side * 15.0, body.y - 9.0, begin.z + 2.0}, outward(a, begin)};
    const double end = kRibs[i].end_deg;
    for (double deg = kRibStart_deg; deg <= end; deg += 1.5) {
        const Vec3 p = onCage(a, deg, ribHeight(a, i, deg), 5.6, side);
        line.lineTo(p, outward(a, p));
    }
    return line.strokes;
}

std::vector<FlatStroke> cartilageLine(const Anatomy& a, std::size_t i, double side) {
    const Rib& rib = kRibs[i];
    if (rib.cartilage_deg == 0.0) return {};
    const double z0 = ribHeight(a, i, rib.end_deg), z1 = rib.cartilage_z + a.rib_shift_mm;
    const Vec3 begin = onCage(a, rib.end_deg, z0, 5.6, side);
    FlatLine line{begin, outward(a, begin)};
    for (int k = 1; k <= 20; ++k) {
        const double t = k / 20.0;
        const double deg = rib.end_deg + (rib.cartilage_deg - rib.end_deg) * t;
        // The cartilage first continues downwards a little, then turns up to the sternum.
        const double z = z0 + (z1 - z0) * t * t - 12.0 * t * (1.0 - t);
        const Vec3 p = onCage(a, deg, z, 5.4, side);
        line.lineTo(p, outward(a, p));
    }
    return line.strokes;
}

}  // namespace

void paintSpine(Canvas& canvas, const Anatomy& a) {
    const Box box{{-50.0, -130.0, -1000.0}, {50.0, 0.0, 1000.0}};
    canvas.paint(box, kWall, [&](const Vec3& p, Voxel voxel) {
        const Vec3 centre = a.vertebra(p.z);
        const Vertebra v = vertebraAt(p.z);
        const Vec3 q{p.x - centre.x, p.y - centre.y, p.z - v.z};
        const double waist = 1.5 * (1.0 - (q.z / v.half_height) * (q.z / v.half_height));
        const double column = ellipsoid({q.x, q.y, 0.0}, Vec3(0.0), {v.rx, v.ry, 1e4});
        const double body = smoothMax(column + waist, std::fabs(q.z) - v.half_height, 3.0);
        const double canal = ellipsoid({q.x, q.y + v.ry + 7.5, 0.0}, Vec3(0.0), {9.5, 7.5, 1e4});
        const double back = posteriorElements(v, q);
        if (canal < 0.0 && body > 0.0) {
            const double cord = ellipsoid({q.x, q.y + v.ry + 7.5, 0.0}, Vec3(0.0), {5.5, 4.5, 1e4});
            voxel.set(Id::spinalCanal, detailFrom(cord < 0.0 ? 1.0 : 0.35));
        } else if (std::min(body, back) < 0.0) {
            voxel.set(Id::spine, cortex(-std::min(body, back), body < back ? 1.3 : 1.8));
        } else if (column + 1.0 < 0.0) {
            voxel.set(Id::cartilage);
        }
    });
}

void paintRibs(Canvas& canvas, const Anatomy& a) {
    for (const double side : {1.0, -1.0})
        for (std::size_t i = 0; i < kRibs.size(); ++i) {
            const double lean = i >= 6 ? 0.88 : 1.0;  // floating ribs are thinner
            paintFlat(canvas, ribLine(a, i, side), side > 0.0 ? Id::ribsRight : Id::ribsLeft,
                      kRibThick * lean, kRibHigh * lean, 1.5);
            paintFlat(canvas, cartilageLine(a, i, side), Id::cartilage, 4.0, 6.6, 0.0);
        }
    // The body of the sternum and the xiphoid process.
    const Box box{{-30.0, 40.0, 60.0}, {30.0, 130.0, 1000.0}};
    canvas.paint(box, kWall | only(Id::cartilage), [&](const Vec3& p, Voxel voxel) {
        const double d = a.cageDistance(p);
        const double half_width = p.z > 110.0 ? 15.0 : 4.0 + 6.0 * ramp(p.z, 84.0, 106.0);
        const double in =
            smoothMax(std::max(std::fabs(p.x) - half_width, 84.0 - p.z), std::fabs(d - 5.8) - 4.2, 4.0);
        if (in < 0.0) voxel.set(Id::sternum, cortex(-in, 1.4));
    });
}

}  // namespace stylet::patient::synth
