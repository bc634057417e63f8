// Dimensions and material of a needle. Every picture, the wound and the record use these numbers. They are
// read from assets/instruments (haptics/tools/instrument.h). Needle frame: tip at the origin, +z toward the
// hub.
#pragma once

#include <cmath>
#include <cstdint>

namespace stylet {

// `chiba`: one plane cut at the bevel's angle to the axis. `trocar`: three facets, `diamond`: four facets,
// each at the bevel's angle to the axis.
enum class NeedleTip : std::uint8_t { chiba, trocar, diamond };

// The default is the 17 G needle of the force model's paper, assets/instruments/needle-17g.toml.
struct NeedleShape {
    double outer_m = 0.0015, inner_m = 0.0011;  // diameters
    double length_m = 0.150;                    // from the tip to the hub
    NeedleTip tip = NeedleTip::chiba;
    double bevel_rad = 22.0 * 0.017453292519943295;
    double first_mark_m = 0.030, mark_step_m = 0.010;  // rings on the shaft; step 0: none
    bool has_stylet = true;                            // a solid stylet fills the bore
    // Share of the sound that the shaft, and the edge of the tip, scatter in all directions.
    double shaft_echo = 0.02, tip_echo = 0.15;
    double attenuation_per_m = 652.0;  // linear attenuation of the material at 70 keV
    friend bool operator==(const NeedleShape&, const NeedleShape&) = default;

    double radius_m() const noexcept { return 0.5 * outer_m; }
    // Length of the ground tip along the axis.
    double tipLength_m() const noexcept {
        return (tip == NeedleTip::chiba ? outer_m : radius_m()) / std::tan(bevel_rad);
    }
};

// Calls `visit` for every floating-point number, in a fixed order, for hash and record.
template <typename Shape, typename Visit>
void visitShapeNumbers(Shape& s, const Visit& visit) {
    visit(s.outer_m), visit(s.inner_m), visit(s.length_m), visit(s.bevel_rad);
    visit(s.first_mark_m), visit(s.mark_step_m);
    visit(s.shaft_echo), visit(s.tip_echo), visit(s.attenuation_per_m);
}

}  // namespace stylet
