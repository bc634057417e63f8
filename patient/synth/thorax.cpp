// The diaphragm and the organs above it.
#include "patient/synth/painters.h"
#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

constexpr double kDiaphragm_mm = 3.3;

// Mediastinum: fat around the heart, in front of the spine and behind the sternum.
double mediastinum(const Anatomy& a, const Vec3& p) {
    const double heart = a.organs.heart.distance(p) - 3.5;
    const Vec3 v = a.vertebra(p.z);
    const double column = ellipsoid({p.x + 2.0, p.y - v.y - 28.0, 0.0}, Vec3(0.0), {23.0, 30.0, 1e4});
    const double strip = std::max(std::fabs(p.x + 4.0) - 4.0, 20.0 - p.y);
    return smoothMin(smoothMin(heart, column, 8.0), strip, 6.0);
}

// 1 in blood, 0 in muscle: a thick left ventricle, the right ventricle wrapped around it, the atria behind.
double heartBlood(const OrientedEllipsoid& heart, const Vec3& p, double wall) {
    const Vec3 q = p - heart.centre;
    const Vec3 h{dot(q, heart.axes[0]), dot(q, heart.axes[1]),
                 dot(q, heart.axes[2])};  // toward the apex; the head; the right and front
    const double left = ellipsoid(h, {8.0, 0.0, -14.0}, {37.0, 23.0, 18.0});
    const double rest = std::max({wall + 4.0, 9.5 - left, 1.4 - std::fabs(h.x + 24.0 + 0.3 * h.z)});
    return ramp(std::min(left, rest), 0.8, -0.8);
}

// Noise of two scales stands for the vessels. The back is denser in a supine patient.
double lungDensity(const Anatomy& a, const Vec3& p) {
    const double vessels =
        valueNoise(p / 7.0, a.seed ^ 0x22) * 0.5 + valueNoise(p / 3.2, a.seed ^ 0x23) * 0.5;
    return 0.10 + 0.0012 * (60.0 - p.y) + 1.6 * std::max(vessels - 0.42, 0.0);
}

}  // namespace

void paintThorax(Canvas& canvas, const Anatomy& a) {
    const double wall_mm = std::max(3.0, 1.3 * canvas.voxel_mm());
    const auto brush = [&](const Vec3& p, Voxel voxel) {
        const double above = p.z - a.diaphragmHeight(p);
        if (above < 0.0) {
            // The dome, and the zone of apposition: the strip inside the ribs down to the costal margin.
            const bool dome = above >= -kDiaphragm_mm;
            if (dome || (a.cageDistance(p) > -wall_mm && p.z > a.costalMargin(a.front(p)) + 6.0))
                voxel.label = std::uint8_t(Id::diaphragm);
            return;
        }
        const double heart = a.organs.heart.distance(p) + 2.0 * valueNoise(p / 22.0, a.seed ^ 0x21);
        if (heart < 0.0 && above > 1.5) {
            voxel.set(Id::heart, detailFrom(heartBlood(a.organs.heart, p, heart)));
        } else if (above < 5.0 * ramp(a.cageDistance(p), -6.0, -1.5)) {
            // Fills the recess with diaphragm where lung would be only a voxel or two thick.
            voxel.label = std::uint8_t(Id::diaphragm);
        } else if (mediastinum(a, p) >= 0.0) {
            voxel.set(p.x > -4.0 ? Id::lungRight : Id::lungLeft, detailFrom(lungDensity(a, p)));
        }
    };
    canvas.paint(kWholeBody, only(Id::visceralFat), brush);
}

}  // namespace stylet::patient::synth
