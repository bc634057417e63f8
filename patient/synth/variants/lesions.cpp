#include "patient/synth/variants/lesions.h"

#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

// Calls change(p, label, include) for every voxel of the box with a label of `onto`; include(hu) adds an
// inclusion there. One thread, so that the inclusions keep their order.
template <typename Change>
void change(Painting& painting, const Box& box, IdSet onto, const Change& change) {
    Canvas& canvas = painting.canvas;
    Index3 first, last;
    canvas.range(box, first, last);
    forEachVoxel(first, last, [&](const Index3& i) {
        const std::size_t n = canvas.grid().offset(i);
        if (!contains(onto, canvas.labels.voxels[n])) return;
        change(canvas.at(i), Voxel{canvas.labels.voxels[n], canvas.detail[n]},
               [&](double hu) { painting.inclusions.push_back({n, float(hu)}); });
    });
}

// A tumour in the liver: rim of tumour tissue, core as the caller wants.
template <typename Core>
void paintLiverTumour(Painting& painting, const Vec3& centre, double radius_mm, const Core& core) {
    const std::uint64_t seed = painting.anatomy.seed;
    change(painting, boxAround(centre, centre, radius_mm + 4.0), only(Id::liver),
           [&](const Vec3& p, Voxel voxel, const auto& include) {
               const double d = length(p - centre) - radius_mm + 3.0 * valueNoise(p / 9.0, seed ^ 0x91);
               if (d >= 0.0) return;
               voxel.set(Id::tumour);
               core(p, d, include);
           });
}

// Fills the inside of strokes and leaves their core alone, like the mesh of a stent.
void includeShell(Painting& painting, const std::vector<Stroke>& strokes, double thick_mm, double hu) {
    for (const Stroke& s : strokes)
        change(painting, boxAround(s.a, s.b, s.ra + thick_mm), only(Id::ducts),
               [&](const Vec3& p, Voxel, const auto& include) {
                   if (std::fabs(roundCone(p, s.a, s.b, s.ra, s.rb).distance) < thick_mm) include(hu);
               });
}

}  // namespace

void paintCalcifiedTumour(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    const CageSection cage = a.cage(40.0);
    const Vec3 centre(cage.xc + cage.a - 24.0, cage.yc + 8.0, 40.0);
    paintLiverTumour(painting, centre, 17.0, [&](const Vec3& p, double d, const auto& include) {
        const double clot = valueNoise(p / 4.0, a.seed ^ 0x92);
        if (d > -5.0 ? clot > -0.1 : clot > 0.45) include(550.0 + 350.0 * clot);
    });
}

void paintNecroticTumour(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    const OrientedEllipsoid& bladder = a.organs.gallbladder;
    const Vec3 centre = bladder.centre + Vec3(28.0, -8.0, 34.0);
    paintLiverTumour(painting, centre, 27.0, [&](const Vec3& p, double d, const auto& include) {
        if (d < -6.0) include(20.0 + 8.0 * valueNoise(p / 6.0, a.seed ^ 0x93));
    });
}

void paintCysts(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    Random random(a.seed, 0x94);
    for (int i = 0; i < 6; ++i) {
        const Vec3 centre = random.uniform3({20.0, -45.0, 20.0}, {95.0, 45.0, 95.0});
        const double radius_mm = random.uniform(7.0, 18.0);
        change(painting, boxAround(centre, centre, radius_mm), only(Id::liver),
               [&](const Vec3& p, Voxel, const auto& include) {
                   if (length(p - centre) < radius_mm) include(5.0);
               });
    }
}

void paintFissureFat(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    // Between the caudate lobe and the left lobe.
    change(painting, {{-40.0, -25.0, 35.0}, {24.0, 20.0, 95.0}}, only(Id::liver),
           [&](const Vec3& p, Voxel voxel, const auto&) {
               const double sheet = p.y + 2.0 - 0.25 * p.x + 3.0 * valueNoise(p / 18.0, a.seed ^ 0x95);
               if (std::fabs(sheet) < 1.3) voxel.set(Id::visceralFat);
           });
}

void paintAorticPlaque(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    change(painting, {{-40.0, -60.0, -1000.0}, {30.0, 40.0, 1000.0}}, only(Id::aorta),
           [&](const Vec3& p, Voxel, const auto& include) {
               const Vec3 axis = a.aorta(p.z);
               const double r = length(Vec3(p.x - axis.x, p.y - axis.y, 0.0));
               if (r > 6.4 && r < 12.0 && valueNoise(p / 9.0, a.seed ^ 0x96) > 0.15) include(700.0);
           });
}

void paintCalcifiedCartilage(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    change(painting, {{-1000.0, 0.0, -1000.0}, {1000.0, 1000.0, 1000.0}}, only(Id::cartilage),
           [&](const Vec3& p, Voxel, const auto& include) {
               if (valueNoise(p / 5.0, a.seed ^ 0x97) > 0.1) include(380.0);
           });
}

void paintStent(Painting& painting) {
    includeShell(painting, painting.trees.extrahepatic_duct, 0.9, 1800.0);
}

void paintScrews(Painting& painting) {
    for (const double side : {-1.0, 1.0}) {
        const Vec3 v = painting.anatomy.vertebra(0.0);
        const Vec3 tip = v + Vec3(side * 9.0, 8.0, 0.0), head = v + Vec3(side * 20.0, -42.0, 0.0);
        change(painting, boxAround(tip, head, 4.0), ~only(Id::air),
               [&](const Vec3& p, Voxel, const auto& include) {
                   if (roundCone(p, tip, head, 3.0, 3.5).distance < 0.0) include(3000.0);
               });
    }
}

void paintAscites(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    change(painting, kWholeBody, only(Id::visceralFat), [&](const Vec3& p, Voxel, const auto& include) {
        const bool around_liver = p.z > -60.0 && a.liverDistance(p) < 16.0;
        const bool gutter = std::fabs(p.x) > 70.0 && p.y < 10.0 && a.cageDistance(p) > -28.0;
        if (around_liver || gutter) include(9.0);
    });
}

void paintEffusion(Painting& painting) {
    const Anatomy& a = painting.anatomy;
    change(painting, kWholeBody, anyOf({Id::lungRight, Id::lungLeft}),
           [&](const Vec3& p, Voxel, const auto& include) {
               if (p.y < a.cage(p.z).yc - 22.0) include(12.0);
           });
}

void paintArms(Painting& painting) {
    const double skin_mm = std::max(2.0, 1.3 * painting.canvas.voxel_mm());
    change(painting, kWholeBody, only(Id::air), [&](const Vec3& p, Voxel voxel, const auto& include) {
        const Vec3 q{std::fabs(p.x) - 205.0, p.y + 8.0, 0.0};
        const double d = ellipsoid(q, Vec3(0.0), {30.0, 38.0, 1e4});
        if (d >= 0.0) return;
        voxel.set(d > -skin_mm ? Id::skin : d > -skin_mm - 6.0 ? Id::fat : Id::muscle, 204);
        if (length(Vec3(q.x, q.y, 0.0)) < 9.0) include(650.0);
    });
}

}  // namespace stylet::patient::synth
