// The hollow organs. The patient lies on the back, so gas collects in front with a horizontal level.
#include "base/parallel.h"
#include "patient/synth/painters.h"
#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

constexpr Id kThisLoop = Id::count;  // temporary label of the loop being painted

std::uint8_t depthByte(double depth_mm) {
    return std::uint8_t(std::clamp(depth_mm * 12.0, 1.0, 255.0));
}

// Stamps a hollow tube. `detail` stores the depth below the outer wall until finishHollow() converts it to
// wall and content. Loops that touch keep their walls.
template <class Allowed>
void stampHollow(Canvas& canvas, const std::vector<Stroke>& strokes, IdSet onto, Id id,
                 const Allowed& allowed) {
    const auto brush = [&](const Vec3& p, const ConeHit& hit, const Stroke&, Voxel voxel) {
        if (!allowed(p)) return;
        const std::uint8_t depth = depthByte(-hit.distance);
        voxel.set(id, voxel.label == std::uint8_t(id) ? std::max(voxel.detail, depth) : depth);
    };
    stamp(canvas, strokes, onto | only(id), brush);
}
void stampHollow(Canvas& canvas, const std::vector<Stroke>& strokes, IdSet onto, Id id) {
    stampHollow(canvas, strokes, onto, id, [](const Vec3&) { return true; });
}

// Adds gas in front of one horizontal level for the whole part. The level lies `level` mean radii in front of
// the part's mean depth.
void stampGas(Canvas& canvas, std::vector<Stroke> strokes, Id id, double wall_mm, double level) {
    double depth = 0.0, radius = 0.0;
    for (Stroke& s : strokes) {
        depth += s.a.y / double(strokes.size());
        radius += s.ra / double(strokes.size());
        s.ra = std::max(s.ra - wall_mm, 0.0);
        s.rb = std::max(s.rb - wall_mm, 0.0);
    }
    const double level_y = depth + level * radius;
    const auto brush = [&](const Vec3& p, const ConeHit&, const Stroke&, Voxel voxel) {
        if (p.y >= level_y && voxel.detail >= depthByte(wall_mm)) voxel.set(Id::gas);
    };
    stamp(canvas, strokes, only(id), brush);
}

void finishHollow(Canvas& canvas, Id id, double wall_mm, double mottle, std::uint64_t seed) {
    canvas.paint(kWholeBody, only(id), [&](const Vec3& p, Voxel voxel) {
        const double depth = voxel.detail / 12.0;
        const double content =
            0.5 + mottle * valueNoise(p / 5.0, seed) + 0.5 * mottle * valueNoise(p / 2.3, seed ^ 1);
        const double wall = 1.0 - ramp(depth, wall_mm * 0.7, wall_mm * 1.3);
        voxel.detail = detailFrom(std::max(wall, std::clamp(content * 0.6, 0.0, 0.6)));
    });
}

std::vector<Stroke> part(const std::vector<Stroke>& strokes, double from, double to) {
    const auto n = double(strokes.size());
    return {strokes.begin() + std::ptrdiff_t(from * n), strokes.begin() + std::ptrdiff_t(to * n)};
}

void paintStomach(Canvas& canvas, const Anatomy& a, Random& random) {
    const Vec3 hiatus = a.aorta(118.0) + Vec3(-2.0, 20.0, 0.0);
    const Vec3 above = a.aorta(175.0) + Vec3(6.0, 17.0, 0.0);
    const IdSet gullet = anyOf({Id::visceralFat, Id::diaphragm});
    stampHollow(canvas, tube({{above, 7.0}, {hiatus, 7.0}, {{-36.0, -4.0, 88.0}, 8.0}}, 3.0), gullet,
                Id::stomach);
    const double full = random.uniform(0.9, 1.08);
    const Vec3 sway = random.jitter3(4.0);
    const std::vector<Stroke> body = tube({{Vec3(-52.0, -16.0, 93.0) + sway, 28.0 * full},
                                           {Vec3(-57.0, 2.0, 78.0) + sway, 35.0 * full},
                                           {Vec3(-57.0, 23.0, 50.0) + sway, 32.0 * full},
                                           {Vec3(-45.0, 35.0, 18.0) + sway, 26.0 * full},
                                           {Vec3(-18.0, 44.0, 0.0) + sway, 21.0 * full},
                                           {Vec3(10.0, 42.0, 1.0) + sway, 16.0 * full},
                                           {Vec3(27.0, 30.0, 6.0), 11.0}},
                                          3.0);
    stampHollow(canvas, body, kCavity, Id::stomach);
    // One gas level for the whole stomach.
    const double level_y = 24.0 + random.jitter(5.0);
    const auto gas = [&](const Vec3& p, Voxel voxel) {
        if (p.y > level_y && voxel.detail > depthByte(4.5) && p.z < 110.0) voxel.set(Id::gas);
    };
    canvas.paint(kWholeBody, only(Id::stomach), gas);
    finishHollow(canvas, Id::stomach, 4.0, 0.25, a.seed ^ 0x41);
}

void paintColon(Canvas& canvas, const Anatomy& a, Random& random) {
    const double sag = random.uniform(-14.0, 8.0);
    const double flexure = a.organs.liver_low_mm - 4.0;  // just below the liver's lower surface
    const std::vector<TubePoint> course{{{86.0, -6.0, -135.0}, 25.0},
                                        {{93.0, -12.0, -100.0}, 25.0},
                                        {{94.0, -16.0, -70.0 + flexure}, 23.0},
                                        {{82.0, 8.0, -52.0 + flexure}, 21.0},
                                        {{58.0, 46.0, -44.0 + 0.5 * (sag + flexure)}, 20.0},
                                        {{18.0, 60.0, -46.0 + sag}, 19.0},
                                        {{-26.0, 60.0, -42.0 + sag}, 18.0},
                                        {{-66.0, 48.0, -18.0 + 0.4 * sag}, 17.0},
                                        {{-88.0, 27.0, 2.0}, 17.0},
                                        {{-98.0, 2.0, 2.0}, 16.0},
                                        {{-101.0, -20.0, -24.0}, 15.0},
                                        {{-100.0, -20.0, -70.0}, 14.0},
                                        {{-96.0, -10.0, -135.0}, 14.0}};
    const std::vector<Stroke> all = tube(course, 2.0, 0.13, 27.0);
    stampHollow(canvas, all, kCavity, Id::colon);
    // Gas where the colon lies in front; stool in the ascending and descending colon.
    stampGas(canvas, part(all, 0.0, 0.22), Id::colon, 3.0, 0.55);
    stampGas(canvas, part(all, 0.25, 0.62), Id::colon, 2.6, random.uniform(-0.35, 0.1));
    stampGas(canvas, part(all, 0.66, 0.76), Id::colon, 2.6, 0.3);
    finishHollow(canvas, Id::colon, 2.6, 0.9, a.seed ^ 0x42);
}

// Distance of p in front of the kidneys, great vessels and psoas. The small bowel lies in front of them.
double beforeRetroperitoneum(const Anatomy& a, const Vec3& p) {
    const double kidneys = std::min(a.organs.kidneyRight.distance(p), a.organs.kidneyLeft.distance(p)) - 4.0;
    const double middle =
        std::fabs(p.x) < 50.0 ? p.y - a.aorta(p.z).y - 11.0 + 6.0 * ramp(std::fabs(p.x), 20.0, 50.0) : 1e3;
    return std::min(kidneys, middle);
}

// A loop that winds through its region and avoids existing loops. Each step goes in the least crowded of a
// few random directions.
std::vector<TubePoint> wander(const Anatomy& a, Random& random, const Box& region,
                              std::vector<Vec3>& occupied, int steps, double radius) {
    const auto crowding = [&](const Vec3& p) {
        double nearest = 30.0;
        for (std::size_t i = 0; i + 2 < occupied.size(); ++i)
            nearest = std::min(nearest, length(p - occupied[i]));
        const Vec3 out = glm::max(glm::max(region.low - p, p - region.high), Vec3(0.0));
        return 3.0 * (out.x + out.y + out.z) + 3.0 * std::max(10.0 - beforeRetroperitoneum(a, p), 0.0) -
               nearest;
    };
    Vec3 at = random.uniform3(region.low, region.high);
    for (int i = 0; i < 12; ++i) {
        const Vec3 other = random.uniform3(region.low, region.high);
        if (crowding(other) < crowding(at)) at = other;
    }
    Vec3 heading = unitOr(random.jitter3(1.0), Vec3(1, 0, 0));
    std::vector<TubePoint> loop;
    for (int i = 0; i < steps; ++i) {
        loop.push_back({at, radius * random.uniform(0.86, 1.12)});
        occupied.push_back(at);
        Vec3 best = at + heading * 14.0;
        for (int k = 0; k < 10; ++k) {
            const Vec3 next = at + unitOr(heading + random.jitter3(1.6), heading) * 14.0;
            if (crowding(next) < crowding(best)) best = next;
        }
        heading = unitOr(best - at, heading);
        at = best;
    }
    return loop;
}

// Branching vessels of the mesentery, painted where two noise fields are both near zero.
void paintMesentery(Canvas& canvas, const Anatomy& a) {
    const auto brush = [&](const Vec3& p, Voxel voxel) {
        const double u = valueNoise(p / 24.0, a.seed ^ 0x44), v = valueNoise(p / 24.0, a.seed ^ 0x45);
        voxel.detail = detailFrom(ramp(u * u + v * v, 0.008, 0.002));
    };
    canvas.paint({{-70.0, -25.0, -1000.0}, {70.0, 45.0, 0.0}}, kCavity, brush);
}

void paintSmallBowel(Canvas& canvas, const Anatomy& a, Random& random) {
    // Duodenum around the head of the pancreas.
    stampHollow(canvas,
                tube({{{28.0, 28.0, 7.0}, 11.0},
                      {{42.0, 18.0, 6.0}, 12.0},
                      {{49.0, 4.0, -14.0}, 12.5},
                      {{44.0, -2.0, -40.0}, 12.0},
                      {{20.0, 6.0, -56.0}, 11.0},
                      {{-8.0, 10.0, -54.0}, 10.0},
                      {{-26.0, 10.0, -34.0}, 11.0}},
                     3.0),
                kCavity, Id::bowel);
    // Jejunum under the stomach, ileum below.
    std::vector<Vec3> occupied;
    const Box upper{{-88.0, -22.0, -70.0}, {-14.0, 62.0, 12.0}},
        lower{{-76.0, -20.0, -150.0}, {74.0, 66.0, -66.0}};
    for (int loop = 0; loop < 13; ++loop) {
        const bool jejunum = loop < 4;
        const std::vector<TubePoint> centre_line =
            wander(a, random, jejunum ? upper : lower, occupied, jejunum ? 16 : 18, jejunum ? 12.5 : 11.5);
        const std::vector<Stroke> strokes = tube(centre_line, 3.0, 0.05, 11.0);
        stampHollow(canvas, strokes, kCavity, kThisLoop,
                    [&](const Vec3& p) { return beforeRetroperitoneum(a, p) > 0.0; });
        if (random.unit() < 0.3) stampGas(canvas, part(strokes, 0.2, 0.5), kThisLoop, 2.6, 0.35);
        // The loop now becomes bowel. Until here its temporary label has protected the walls of earlier
        // loops.
        canvas.paint(kWholeBody, only(kThisLoop),
                     [](const Vec3&, Voxel voxel) { voxel.label = std::uint8_t(Id::bowel); });
    }
    finishHollow(canvas, Id::bowel, 2.0, 0.3, a.seed ^ 0x43);
}

// Adds a wall where another organ has cut into a hollow one and exposed its gas.
void sealGas(Canvas& canvas) {
    const Grid& grid = canvas.grid();
    const IdSet hollow = anyOf({Id::stomach, Id::colon, Id::bowel});
    const int wall = std::max(1, int(2.0 / canvas.voxel_mm()));
    std::vector<std::vector<std::pair<std::size_t, std::uint8_t>>> sealed(std::size_t(grid.dims.z));
    // Returns the first label along `axis` within `reach` voxels that is not gas.
    const auto look = [&](Index3 at, int axis, int step, int reach) {
        auto found = std::uint8_t(Id::gas);
        for (int k = 0; k < reach && found == std::uint8_t(Id::gas); ++k) {
            at[axis] += step;
            if (!grid.contains(at)) break;
            found = canvas.labels[at];
        }
        return found;
    };
    parallelVoxels(canvas.threads, grid, [&](const Index3& i) {
        if (canvas.labels[i] != std::uint8_t(Id::gas)) return;
        bool bare = false;
        std::uint8_t host = std::uint8_t(Id::colon);
        for (int axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
                bare = bare || !contains(hollow | only(Id::gas), look(i, axis, step, wall));
                const std::uint8_t organ = look(i, axis, step, 40);
                if (contains(hollow, organ)) host = organ;
            }
        if (bare) sealed[std::size_t(i.z)].push_back({grid.offset(i), host});
    });
    for (const auto& slice : sealed)
        for (const auto& [n, host] : slice)
            canvas.labels.voxels[n] = host, canvas.detail[n] = 255;
}

}  // namespace

void paintBowel(Canvas& canvas, const Anatomy& a) {
    Random random(a.seed, 3);
    paintStomach(canvas, a, random);
    paintColon(canvas, a, random);
    paintSmallBowel(canvas, a, random);
    sealGas(canvas);
    paintMesentery(canvas, a);
}

}  // namespace stylet::patient::synth
