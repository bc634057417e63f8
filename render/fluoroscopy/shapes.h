// Other objects in the beam: instruments and hands, as capsules and cylinders whose chords have a closed
// form.
//
// Attenuation at 70 keV, interpolated on log scales between the 60 and 80 keV of Hubbell and Seltzer (NIST,
// NISTIR 5632, 1995): iron 0.826 cm2/g at 7.9 g/cm3, PMMA 0.183 at 1.19, soft tissue as water. A tool's
// attenuation is added to that of the tissue that it displaces, which is 3 % of steel's.
#pragma once

#include <span>
#include <vector>

#include "render/fluoroscopy/fluoroscopy_shared.h"
#include "render/scene/scene.h"

namespace stylet::render {

inline constexpr double kSteelPerM = 652.0, kPlasticPerM = 21.8, kFleshPerM = 20.5;

// A capsule or cylinder, in the frame of the deformed patient. Where two successive shapes of a chain overlap
// on a ray, the overlap counts once.
struct XrayShape {
    Vec3 begin_m{0.0}, end_m{0.0};
    double radius_m = 0.001;
    double bore_m = 0.0;  // radius of a bore along the whole length
    double per_m = kSteelPerM;
    bool round = true;     // hemispheres at both ends, else flat
    bool chained = false;  // continues the chain of the shape before it
};
inline constexpr int kMaxXrayShapes = gpu::kMaxShapes;  // only the first ones are used

// Append a tool to `shapes`. The tools are those of assets/instruments: contact end at the origin, handle
// toward +z. Without its stylet a needle has an open bore.
void addNeedle(const Pose& patient_from_needle, const NeedleShape&, bool stylet_in,
               std::vector<XrayShape>& shapes);
// A chain of capsules. Its bore is not drawn: `attenuation_per_m` is scaled by the share of the wall.
void addTube(const CurvedTube&, std::vector<XrayShape>& shapes);
// `face_m`: length of the probe's face.
void addProbe(const Pose& patient_from_probe, double face_m, std::vector<XrayShape>& shapes);
void addScalpel(const Pose& patient_from_scalpel, std::vector<XrayShape>& shapes);
void addFinger(const Pose& patient_from_finger, std::vector<XrayShape>& shapes);

}  // namespace stylet::render
