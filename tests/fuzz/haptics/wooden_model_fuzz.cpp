#include <cmath>
#include <cstddef>

#include "haptics/devices/woodenhaptics/woodenhaptics_arm.h"
#include "haptics/devices/woodenhaptics/woodenhaptics_model.h"
#include "haptics/tools/device.h"
#include "tests/fuzz/parser_target.h"

// The result is a model with a valid arm pose, or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet::haptics;
    const WoodenModel model = parseWoodenModel(input, "fuzz.json");
    if (!(model.force_peak_n > 0.0) || !(model.workspace_radius_m > 0.0)) std::abort();
    ArmCounts parked{};
    for (std::size_t i = 0; i < parked.size(); ++i)
        parked[i] = model.calibration_counts[i];
    const stylet::Vec3 angles_rad = armAngles_rad(model, parked);
    if (!stylet::isFinite(armPosition_m(model, angles_rad))) std::abort();
    const stylet::Vec3 current_a = armCurrents(model, angles_rad, {0.0, 3.0, -4.0}).motor_a;
    for (int i = 0; i < 3; ++i)
        if (!(std::fabs(current_a[i]) <= kMaxCurrent_a * (1.0 + 1e-9))) std::abort();
}
