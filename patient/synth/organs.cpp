// The solid organs and the great vessels.
#include "patient/synth/painters.h"
#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

// Cortex outside, medullary pyramids inside, fat in the sinus.
void paintKidney(Canvas& canvas, const Anatomy& a, const OrientedEllipsoid& kidney, Id id, double side) {
    const Vec3 hilum = kidney.centre + Vec3(-side * 17.0, 10.0, 0.0);
    const OrientedEllipsoid sinus =
        orientedEllipsoid(hilum, kidney.axes[0], kidney.axes[1], {24.0, 13.0, 9.0});
    const Box box = boxAround(kidney.centre, kidney.centre, kidney.radii.x + 4.0);
    canvas.paint(box, kCavity, [&](const Vec3& p, Voxel voxel) {
        const double d = kidney.distance(p) + 1.2 * valueNoise(p / 16.0, a.seed ^ 0x31);
        if (d >= 0.0 || sinus.distance(p) < 0.0) return;
        const double column = valueNoise(p / 9.0, a.seed ^ 0x32);
        const double medulla = ramp(-d, 5.0, 7.5) * ramp(column, -0.25, 0.05);
        voxel.set(id, detailFrom(1.0 - medulla));
    });
}

void paintRenalVessels(Canvas& canvas, const Anatomy& a) {
    for (const double side : {1.0, -1.0}) {
        const OrientedEllipsoid& kidney = side > 0.0 ? a.organs.kidneyRight : a.organs.kidneyLeft;
        const Vec3 hilum = kidney.centre + Vec3(-side * 14.0, 8.0, 2.0);
        const Vec3 cava = a.cava(hilum.z + 8.0), aorta = a.aorta(hilum.z + 12.0);
        const Vec3 over = side > 0.0 ? mixed(cava, hilum, 0.5) : aorta + Vec3(-4.0, 14.0, -4.0);
        paintStrokes(canvas, tube({{cava, 4.6}, {over, 4.2}, {hilum, 3.8}}, 2.0), kCavity, Id::cava);
        const Vec3 behind = mixed(aorta, hilum, 0.5) + Vec3(0.0, -3.0, 2.0);
        paintStrokes(canvas, tube({{aorta, 3.0}, {behind, 2.8}, {hilum, 2.5}}, 2.0), kCavity, Id::aorta);
    }
}

void paintPancreas(Canvas& canvas, const Anatomy& a) {
    const Vec3& spleen = a.organs.spleen.centre;
    const std::vector<Stroke> body = tube({{{24.0, 4.0, -28.0}, 11.0},
                                           {{23.0, 10.0, -10.0}, 15.0},
                                           {{8.0, 17.0, 0.0}, 11.0},
                                           {{-16.0, 16.0, 12.0}, 12.5},
                                           {{-44.0, -3.0, 22.0}, 12.0},
                                           {spleen + Vec3(20.0, 4.0, -16.0), 9.5}},
                                          3.0);
    stamp(canvas, body, kCavity, [&](const Vec3& p, const ConeHit& hit, const Stroke&, Voxel voxel) {
        // Lobules separated by fat.
        const double lobes = 2.6 * valueNoise(p / 6.5, a.seed ^ 0x33);
        if (hit.distance + 1.5 + lobes <= 0.0) voxel.set(Id::pancreas);
    });
}

// The crura of the diaphragm: bands on either side of the aorta down to the lumbar spine.
void paintCrura(Canvas& canvas, const Anatomy& a) {
    canvas.fill({{-45.0, -60.0, -45.0}, {45.0, 10.0, 105.0}}, kCavity, Id::diaphragm, [&](const Vec3& p) {
        const double up = ramp(p.z, -45.0, 50.0);
        const Vec3 aorta = a.aorta(p.z);
        const Vec3 q{std::fabs(p.x - aorta.x) - 11.5 - 1.5 * up, p.y - aorta.y + 5.0 - 2.0 * up, 0.0};
        return ellipsoid(q, Vec3(0.0), {1.0 + 2.8 * up, 5.0 + 5.0 * up, 1e4});
    });
}

}  // namespace

void paintGreatVessels(Canvas& canvas, const Anatomy& a) {
    paintCrura(canvas, a);
    const Box box{{-40.0, -60.0, -1000.0}, {60.0, 40.0, 1000.0}};
    const IdSet onto = anyOf({Id::visceralFat, Id::diaphragm, Id::heart});
    canvas.paint(box, onto, [&](const Vec3& p, Voxel voxel) {
        const Vec3 aorta = a.aorta(p.z), cava = a.cava(p.z);
        const double radius = 8.6 + 2.2 * ramp(p.z, -60.0, 120.0);
        const double in_aorta =
            ellipsoid({p.x - aorta.x, p.y - aorta.y, 0.0}, Vec3(0.0), {radius, radius, 1e4});
        const double in_cava = ellipsoid({p.x - cava.x, p.y - cava.y, 0.0}, Vec3(0.0), {11.5, 9.5, 1e4});
        const bool in_heart = voxel.label == std::uint8_t(Id::heart);
        if (in_aorta < 0.0 && !in_heart)
            voxel.set(Id::aorta);
        else if (in_cava < 0.0 && p.z < 152.0)
            voxel.set(Id::cava);
    });
}

void paintLiver(Canvas& canvas, const Anatomy& a) {
    const OrganPlan& o = a.organs;
    paintKidney(canvas, a, o.kidneyRight, Id::kidneyRight, 1.0);
    paintKidney(canvas, a, o.kidneyLeft, Id::kidneyLeft, -1.0);
    canvas.paint(boxAround(o.gallbladder.centre, o.gallbladder.centre, 60.0), kCavity,
                 [&](const Vec3& p, Voxel voxel) {
                     // Pear-shaped: narrower towards the neck.
                     const double along =
                         dot(p - o.gallbladder.centre, o.gallbladder.axes[0]) / o.gallbladder.radii.x;
                     const double d = o.gallbladder.distance(p) + 4.0 * ramp(along, 0.3, -1.0);
                     if (d < 0.0) voxel.set(Id::gallbladder, detailFrom(1.0 - ramp(-d, 0.8, 2.0)));
                 });
    canvas.fill(kLiverBox, kCavity, Id::liver, [&](const Vec3& p) { return a.liverDistance(p); });
}

void paintSolidOrgans(Canvas& canvas, const Anatomy& a) {
    const OrganPlan& o = a.organs;
    paintRenalVessels(canvas, a);
    // Coeliac trunk with the splenic and hepatic arteries, superior mesenteric artery.
    const Vec3 coeliac = a.aorta(22.0), mesenteric = a.aorta(8.0);
    paintStrokes(
        canvas,
        tube({{coeliac, 3.4}, {coeliac + Vec3(2.0, 17.0, 3.0), 3.2}, {coeliac + Vec3(20.0, 20.0, 8.0), 2.4}},
             2.0),
        kCavity, Id::aorta);
    paintStrokes(canvas,
                 tube({{mesenteric, 3.4},
                       {mesenteric + Vec3(1.0, 16.0, -8.0), 3.2},
                       {mesenteric + Vec3(6.0, 26.0, -50.0), 3.0},
                       {mesenteric + Vec3(6.0, 30.0, -130.0), 2.6}},
                      2.0),
                 kCavity, Id::aorta);
    const IdSet tumour_onto = anyOf({Id::visceralFat, Id::ducts});
    canvas.fill(boxAround(o.tumour, o.tumour, o.tumour_radius + 3.0), tumour_onto, Id::tumour,
                [&](const Vec3& p) {
                    return length(p - o.tumour) - o.tumour_radius + 2.0 * valueNoise(p / 7.0, a.seed ^ 0x34);
                });
    canvas.fill(boxAround(o.spleen.centre, o.spleen.centre, o.spleen.radii.x + 4.0), kCavity, Id::spleen,
                [&](const Vec3& p) {
                    // Concave towards the stomach and the kidney.
                    const double hollow = length(p - (o.spleen.centre + Vec3(46.0, 12.0, -4.0))) - 32.0;
                    const double kidney = o.kidneyLeft.distance(p) - 3.0;
                    const double d = o.spleen.distance(p) + 1.5 * valueNoise(p / 20.0, a.seed ^ 0x35);
                    return smoothMax(smoothMax(d, -hollow, 8.0),
                                     smoothMax(-kidney, a.cageDistance(p) + 2.8, 3.0), 6.0);
                });
    paintPancreas(canvas, a);
}

void paintTrees(Canvas& canvas, const HepaticTrees& trees) {
    const IdSet liver = anyOf({Id::liver, Id::visceralFat});
    // Ducts first: portal branches do not overwrite them, so the ducts stay connected.
    paintStrokes(canvas, trees.ducts, liver, Id::ducts);
    paintStrokes(canvas, trees.extrahepatic_duct, liver, Id::ducts);
    paintStrokes(canvas, trees.portal, liver, Id::portal);
    paintStrokes(canvas, trees.extrahepatic_portal, liver, Id::portal);
    // Also painted over the vena cava, so that the trunks meet inside it and form one piece.
    paintStrokes(canvas, trees.hepatic_veins, liver | only(Id::cava), Id::hepaticVeins);
}

}  // namespace stylet::patient::synth
