// A bridge to Force Dimension's omega, sigma, delta and lambda through libdhd. Compiled only if that SDK is
// installed. Facts from its public header (SDK 3.7 and later) and its Python documentation: metres, newtons,
// rotation by rows, a firmware watchdog in multiples of 125 us that switches the forces off, -1 on errors.
// Force, stiffness and workspace per type as listed by CHAI3D.
// Unproven without hardware: that the centre of the workspace is the origin, and that an unrotated wrist
// holds the handle along the SDK's x.
#include <dhdc.h>

#include <atomic>
#include <thread>

#include "haptics/devices/bridge/forcedimension_frame.h"
#include "haptics/devices/bridge/serve_linux.h"

namespace stylet::haptics::bridge {
namespace {

constexpr unsigned char kWatchdog = 120;  // * 125 us = 15 ms

struct Known {
    int type;
    double force_peak_n, stiffness_n_per_m, workspace_radius_m;
};
constexpr Known kKnown[] = {
    {DHD_DEVICE_DELTA3, 20.0, 5000.0, 0.15},        {DHD_DEVICE_OMEGA3, 12.0, 5000.0, 0.075},
    {DHD_DEVICE_OMEGA33, 12.0, 5000.0, 0.075},      {DHD_DEVICE_OMEGA33_LEFT, 12.0, 5000.0, 0.075},
    {DHD_DEVICE_OMEGA331, 12.0, 5000.0, 0.075},     {DHD_DEVICE_OMEGA331_LEFT, 12.0, 5000.0, 0.075},
    {DHD_DEVICE_SIGMA331, 12.0, 4000.0, 0.09},      {DHD_DEVICE_SIGMA331_LEFT, 12.0, 4000.0, 0.09},
    {DHD_DEVICE_LAMBDA331, 12.0, 8000.0, kUnknown}, {DHD_DEVICE_LAMBDA331_LEFT, 12.0, 8000.0, kUnknown},
    {DHD_DEVICE_FALCON, 8.0, 3000.0, 0.04},
};

class ForceDimension final : public Sdk {
  public:
    bool open(Capabilities& capabilities, std::string& why) override {
        if (dhdOpen() < 0) return failed(why);
        open_ = true;
        const char* name = dhdGetSystemName();
        putText(capabilities.name, name ? name : "Force Dimension device");
        DeviceProfile& profile = capabilities.profile;
        profile.force_peak_n = kWeakestForce_n;
        profile.stiffness_n_per_m = kWeakestStiffness_n_per_m;
        putText(capabilities.source, "a type not listed: taken for the weakest");
        for (const Known& known : kKnown) {
            if (known.type != dhdGetSystemType()) continue;
            profile.force_peak_n = known.force_peak_n;
            profile.stiffness_n_per_m = known.stiffness_n_per_m;
            profile.workspace_radius_m = known.workspace_radius_m;
            putText(capabilities.source, "CHAI3D's table of Force Dimension devices");
        }
        profile.senses_rotation = dhdHasWrist();
        profile.torque_axes = dhdHasActiveWrist() ? 3 : 0;
        profile.force_axes = 3;
        peak_n_ = profile.force_peak_n;

        // The firmware switches the forces off when this process ends.
        dhdEnableExpertMode();
        const bool guarded = dhdSetWatchdog(kWatchdog) >= 0;
        dhdDisableExpertMode();
        return guarded || failed(why);
    }

    bool start(Servo& servo, std::string& why) override {
        servo_ = &servo;
        if (dhdEnableForce(DHD_ON) < 0) return failed(why);
        running_.store(true);
        thread_ = std::thread([this] {
            while (running_.load() && tick()) {
            }
        });
        return true;
    }

    void stop() noexcept override {
        running_.store(false);
        if (thread_.joinable()) thread_.join();
        if (!open_) return;
        dhdSetForceAndTorque(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        dhdEnableForce(DHD_OFF);
        dhdClose();
        open_ = false;
    }

  private:
    static bool failed(std::string& why) {
        why = dhdErrorGetLastStr();
        return false;
    }

    // The bus sets the pace, up to 4 kHz.
    bool tick() {
        Vec3 p(0.0);
        double rows[3][3] = {};
        int status[DHD_MAX_STATUS] = {};
        if (dhdGetPositionAndOrientationFrame(&p.x, &p.y, &p.z, rows) < 0 || dhdGetStatus(status) < 0)
            return lost();
        MotorStage motors = status[DHD_STATUS_FORCE] ? MotorStage::on : MotorStage::off;
        if (!status[DHD_STATUS_RESET]) motors = MotorStage::needsHoming;
        const Vec3 f = dhdFromBridge(servo_->tick(
            {monotonic_ns(), stylusFromDhd(p, rows), dhdGetButtonMask(), motors, true}, peak_n_));
        return dhdSetForceAndTorque(f.x, f.y, f.z, 0.0, 0.0, 0.0) >= 0 || lost();
    }

    bool lost() {
        servo_->fail(dhdErrorGetLastStr());
        return false;
    }

    Servo* servo_ = nullptr;
    double peak_n_ = 0.0;
    bool open_ = false;
    std::atomic<bool> running_{false};
    std::thread thread_;
};

}  // namespace
}  // namespace stylet::haptics::bridge

int main(int argc, char** argv) {
    stylet::haptics::bridge::ForceDimension sdk;
    return stylet::haptics::bridge::bridgeMain(sdk, argc, argv);
}
