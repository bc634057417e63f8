// The hollow organs. The patient lies on the back: gas collects in front, with a level.
#include "patient/synth/painters.h"
#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

constexpr IdSet kCavity = only(Id::visceralFat);

std::uint8_t depthByte(double depth_mm) {
    return std::uint8_t(std::clamp(depth_mm * 12.0, 1.0, 255.0));
}

// Stamps a hollow tube; the detail holds the depth under the outer wall until `finishHollow` turns it into
// wall and content. Loops that touch keep their walls.
void stampHollow(Canvas& canvas, const std::vector<Stroke>& strokes, IdSet onto, Id id) {
    stamp(canvas, strokes, onto | only(id),
          [id](const Vec3&, const ConeHit& hit, const Stroke&, std::uint8_t& label, std::uint8_t& detail) {
              const std::uint8_t depth = depthByte(-hit.distance);
              detail = label == std::uint8_t(id) ? std::max(detail, depth) : depth;
              label = std::uint8_t(id);
          });
}

// Gas in the part of a hollow organ that lies in front of `level` of its radius.
void stampGas(Canvas& canvas, std::vector<Stroke> strokes, Id id, double wall_mm, double level) {
    for (Stroke& s : strokes)
        s.ra = std::max(s.ra - wall_mm, 0.0), s.rb = std::max(s.rb - wall_mm, 0.0);
    stamp(canvas, strokes, only(id),
          [&](const Vec3& p, const ConeHit& hit, const Stroke& s, std::uint8_t& label, std::uint8_t& detail) {
              const double centre = mixed(s.a, s.b, hit.share).y;
              const double radius = s.ra + (s.rb - s.ra) * hit.share;
              if (p.y < centre + level * radius || detail < depthByte(wall_mm)) return;
              label = std::uint8_t(Id::gas);
              detail = 0;
          });
}

void finishHollow(Canvas& canvas, Id id, double wall_mm, double mottle, std::uint64_t seed) {
    canvas.paint(kWholeBody, only(id), [&](const Vec3& p, std::uint8_t&, std::uint8_t& detail) {
        const double depth = detail / 12.0;
        const double content =
            0.5 + mottle * valueNoise(p / 5.0, seed) + 0.5 * mottle * valueNoise(p / 2.3, seed ^ 1);
        const double wall = 1.0 - ramp(depth, wall_mm * 0.7, wall_mm * 1.3);
        detail = detailFrom(std::max(wall, std::clamp(content * 0.6, 0.0, 0.6)));
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
    const std::vector<Stroke> body = tube({{Vec3(-50.0, -18.0, 84.0) + sway, 25.0 * full},
                                           {Vec3(-56.0, -2.0, 72.0) + sway, 31.0 * full},
                                           {Vec3(-56.0, 20.0, 46.0) + sway, 28.0 * full},
                                           {Vec3(-44.0, 34.0, 18.0) + sway, 23.0 * full},
                                           {Vec3(-18.0, 44.0, 2.0) + sway, 19.0 * full},
                                           {Vec3(10.0, 42.0, 2.0) + sway, 15.0 * full},
                                           {Vec3(27.0, 30.0, 6.0), 10.0}},
                                          3.0);
    stampHollow(canvas, body, kCavity, Id::stomach);
    // One level for the whole stomach.
    const double level_y = 24.0 + random.jitter(5.0);
    canvas.paint(kWholeBody, only(Id::stomach),
                 [&](const Vec3& p, std::uint8_t& label, std::uint8_t& detail) {
                     if (p.y > level_y && detail > depthByte(4.5) && p.z < 110.0 && p.x < 5.0)
                         label = std::uint8_t(Id::gas), detail = 0;
                 });
    finishHollow(canvas, Id::stomach, 4.0, 0.25, a.seed ^ 0x41);
}

void paintColon(Canvas& canvas, const Anatomy& a, Random& random) {
    const double sag = random.uniform(-14.0, 8.0);
    const std::vector<TubePoint> course{{{86.0, -6.0, -135.0}, 25.0},
                                        {{93.0, -12.0, -100.0}, 25.0},
                                        {{94.0, -16.0, -72.0}, 22.0},
                                        {{84.0, 8.0, -56.0}, 20.0},
                                        {{58.0, 46.0, -56.0 + 0.5 * sag}, 20.0},
                                        {{18.0, 60.0, -62.0 + sag}, 19.0},
                                        {{-26.0, 60.0, -58.0 + sag}, 18.0},
                                        {{-66.0, 48.0, -28.0 + 0.4 * sag}, 17.0},
                                        {{-92.0, 20.0, 8.0}, 17.0},
                                        {{-101.0, -8.0, 16.0}, 16.0},
                                        {{-102.0, -22.0, -14.0}, 15.0},
                                        {{-100.0, -20.0, -70.0}, 14.0},
                                        {{-96.0, -10.0, -135.0}, 14.0}};
    const std::vector<Stroke> all = tube(course, 2.0, 0.13, 27.0);
    stampHollow(canvas, all, kCavity, Id::colon);
    // Gas where the colon lies in front; stool in the ascending and descending parts.
    stampGas(canvas, part(all, 0.0, 0.22), Id::colon, 3.0, 0.55);
    stampGas(canvas, part(all, 0.25, 0.62), Id::colon, 2.6, random.uniform(-0.35, 0.1));
    stampGas(canvas, part(all, 0.62, 0.74), Id::colon, 2.6, 0.25);
    finishHollow(canvas, Id::colon, 2.6, 0.9, a.seed ^ 0x42);
}

void paintSmallBowel(Canvas& canvas, const Anatomy& a, Random& random) {
    // Duodenum around the head of the pancreas.
    stampHollow(canvas,
                tube({{{28.0, 28.0, 7.0}, 11.0},
                      {{42.0, 18.0, 6.0}, 12.0},
                      {{49.0, 4.0, -14.0}, 12.5},
                      {{44.0, -2.0, -40.0}, 12.0},
                      {{20.0, 0.0, -54.0}, 11.0},
                      {{-8.0, 4.0, -52.0}, 11.0},
                      {{-26.0, 10.0, -34.0}, 11.0}},
                     3.0),
                kCavity, Id::bowel);
    // Jejunum and ileum: loops to and fro in layers.
    for (int layer = 0; layer < 4; ++layer)
        for (int row = 0; row < 3; ++row) {
            std::vector<TubePoint> loop;
            const double z = -66.0 - 23.0 * layer + (row == 1 ? 8.0 : 0.0) + random.jitter(4.0);
            const double y = -4.0 + 24.0 * row;
            for (int i = 0; i < 9; ++i) {
                const double x = (layer + row) % 2 ? 68.0 - 17.0 * i : -68.0 + 17.0 * i;
                const double wave = i % 2 ? 8.0 : -8.0;
                loop.push_back(
                    {Vec3(x, y + 0.6 * wave, z + wave) + random.jitter3(6.0), random.uniform(9.5, 12.5)});
            }
            const std::vector<Stroke> strokes = tube(loop, 3.0, 0.06, 13.0);
            stampHollow(canvas, strokes, kCavity, Id::bowel);
            if (random.unit() < 0.3) stampGas(canvas, part(strokes, 0.2, 0.5), Id::bowel, 2.6, 0.35);
        }
    finishHollow(canvas, Id::bowel, 2.0, 0.3, a.seed ^ 0x43);
}

}  // namespace

void paintBowel(Canvas& canvas, const Anatomy& a) {
    Random random(a.seed, 3);
    paintStomach(canvas, a, random);
    paintColon(canvas, a, random);
    paintSmallBowel(canvas, a, random);
}

}  // namespace stylet::patient::synth
