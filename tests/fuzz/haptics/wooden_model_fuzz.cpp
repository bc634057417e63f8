#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "haptics/devices/woodenhaptics/woodenhaptics_arm.h"
#include "haptics/devices/woodenhaptics/woodenhaptics_model.h"
#include "haptics/tools/device.h"
#include "patient/patient.h"

// The result is a model with a valid arm pose, or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::haptics;
    try {
        const WoodenModel model = parseWoodenModel({reinterpret_cast<const char*>(data), size}, "fuzz.json");
        if (!(model.force_peak_n > 0.0) || !(model.workspace_radius_m > 0.0)) std::abort();
        ArmCounts parked{};
        for (std::size_t i = 0; i < parked.size(); ++i)
            parked[i] = model.calibration_counts[i];
        const stylet::Vec3 angles_rad = armAngles_rad(model, parked);
        if (!isFinite(armPosition_m(model, angles_rad))) std::abort();
        const stylet::Vec3 current_a = armCurrents(model, angles_rad, {0.0, 3.0, -4.0}).motor_a;
        for (int i = 0; i < 3; ++i)
            if (!(std::fabs(current_a[i]) <= kMostCurrent_a * (1.0 + 1e-9))) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
