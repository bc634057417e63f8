// The anatomy of one patient, drawn from a seed, in "anatomical" millimetres: x to the patient's right, y
// to the front, z to the head, z = 0 at the middle of the first lumbar vertebra. The patient's own size is
// applied last, as a scale per axis.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "patient/synth/shapes.h"

namespace stylet::patient::synth {

// Elliptical cross-section of the fascia at one height.
struct CageSection {
    double a, b;    // half-axes, right-left and back-front
    double xc, yc;  // centre
};

// Organ positions and sizes that several painters share.
struct OrganPlan {
    OrientedEllipsoid gallbladder, spleen, kidneyRight, kidneyLeft, heart;
    Vec3 hilum{0.0};   // where the portal vein divides
    Vec3 tumour{0.0};  // in the pancreatic head, around the end of the common duct
    double tumour_radius = 11.0;
    double liver_low_mm = 0.0;   // shift of the liver's lower surface
    double liver_left_mm = 0.0;  // shift of the left lobe's tip
};

struct Anatomy {
    std::uint64_t seed = 0;
    Vec3 scale{1.0};                        // patient mm per anatomical mm
    double width_mm = 0.0, depth_mm = 0.0;  // added to the cage's half-axes
    double fat_side_mm = 0.0, fat_front_mm = 0.0, fat_back_mm = 0.0;
    double dome_right_mm = 132.0, dome_left_mm = 117.0;
    double rib_shift_mm = 0.0;   // shift of all ribs along z
    double rib_drop = 1.0;       // how steeply they slope
    double rib_spread_mm = 0.0;  // extra vertical pitch laterally
    double spine_x_mm = 0.0;     // lateral curvature
    double fissure_mm = 2.4;     // half width of the round ligament's fissure in front
    double nodules_mm = 0.0;     // height of the nodules on the surface of a cirrhotic liver
    OrganPlan organs;

    CageSection cage(double z) const noexcept;
    // Distance to the cage's surface, negative inside.
    double cageDistance(const Vec3& p) const noexcept;
    // Angular position of p around the cage: -1 at the back, +1 at the front.
    double front(const Vec3& p) const noexcept;
    // Distance to the cavity lined by the fascia: the cage without the vertebral bodies and psoas.
    // Negative inside.
    double cavityDistance(const Vec3& p) const noexcept;
    // Outer surface of the wall's muscles and outer surface of the skin, as distances from the cage.
    double muscleDepth(const Vec3& p) const noexcept;
    double skinDepth(const Vec3& p) const noexcept;
    // Lower edge of the ribs [z]; the wall below it has no ribs.
    double costalMargin(double front) const noexcept;

    // Height of the diaphragm's upper surface at (x, y), including where it meets the wall.
    double diaphragmHeight(const Vec3& p) const noexcept;
    double liverDistance(const Vec3& p) const noexcept;

    Vec3 vertebra(double z) const noexcept;  // centre of the vertebral body's cross-section
    Vec3 aorta(double z) const noexcept;
    Vec3 cava(double z) const noexcept;
    double psoas(const Vec3& p) const noexcept;
};

// A box in anatomical mm.
struct Box {
    Vec3 low, high;
};
inline Box boxAround(const Vec3& a, const Vec3& b, double margin) {
    return {glm::min(a, b) - margin, glm::max(a, b) + margin};
}
inline constexpr Box kWholeBody{Vec3(-1000.0), Vec3(1000.0)};
inline constexpr Box kLiverBox{Vec3(-112.0, -85.0, -85.0), Vec3(135.0, 95.0, 150.0)};

Anatomy drawAnatomy(std::uint64_t seed);

}  // namespace stylet::patient::synth
