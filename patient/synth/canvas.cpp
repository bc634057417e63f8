#include "patient/synth/canvas.h"

#include "base/smoothstep.h"
#include "base/transcendental.h"

namespace stylet::patient::synth {

namespace {

TubePoint between(const std::vector<TubePoint>& points, std::size_t i, double t) {
    const TubePoint& b = points[i];
    const TubePoint& c = points[i + 1];
    const TubePoint& a = points[i > 0 ? i - 1 : i];
    const TubePoint& d = points[std::min(i + 2, points.size() - 1)];
    const double t2 = t * t, t3 = t2 * t;
    const Vec3 p = (b.p * 2.0 + (c.p - a.p) * t + (a.p * 2.0 - b.p * 5.0 + c.p * 4.0 - d.p) * t2 +
                    (b.p * 3.0 - a.p - c.p * 3.0 + d.p) * t3) *
                   0.5;
    return {p, b.radius + (c.radius - b.radius) * smoothStep(t)};
}

}  // namespace

void paintStrokes(Canvas& canvas, const std::vector<Stroke>& strokes, IdSet onto, Id id) {
    stamp(canvas, strokes, onto,
          [id](const Vec3&, const ConeHit&, const Stroke&, Voxel voxel) { voxel.set(id); });
}

std::vector<Stroke> tube(const std::vector<TubePoint>& points, double step_mm, double bulge,
                         double period_mm) {
    std::vector<Stroke> strokes;
    double along = 0.0;
    TubePoint last = points.front();
    const auto radius = [&](double r) {
        return r * (1.0 + bulge * detSin(2.0 * 3.14159265358979 * along / period_mm));
    };
    double last_radius = radius(last.radius);
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const int parts = std::max(1, int(length(points[i + 1].p - points[i].p) / step_mm));
        for (int k = 1; k <= parts; ++k) {
            const TubePoint next = between(points, i, double(k) / parts);
            along += length(next.p - last.p);
            const double next_radius = radius(next.radius);
            strokes.push_back({last.p, next.p, last_radius, next_radius});
            last = next;
            last_radius = next_radius;
        }
    }
    return strokes;
}

}  // namespace stylet::patient::synth
