// A bridge to 3D Systems' Touch, Touch X and Premium through OpenHaptics' HD API. Compiled only if that SDK
// is installed. Facts from public use of the API: the transform is column-major in millimetres, force is in
// newtons, HD_NOMINAL_MAX_STIFFNESS is in N/mm, and warm motors and exceeded limits are reported as errors of
// a frame.
// Unproven without hardware: that the stylus lies along +z of its transform, whose origin is the gimbal's
// centre; and what the device does with its last force when this process is killed (keep the device's own
// limits on).
#include <HD/hd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "haptics/devices/bridge/serve_linux.h"

namespace stylet::haptics::bridge {
namespace {

constexpr double kMetres = 1e-3;

// True for errors that the SDK reports while it limits the forces itself. Every other error means a lost
// device.
bool limitsForce(HDerror error) {
    return error == HD_WARM_MOTORS || error == HD_EXCEEDED_MAX_FORCE ||
           error == HD_EXCEEDED_MAX_FORCE_IMPULSE || error == HD_EXCEEDED_MAX_VELOCITY ||
           error == HD_FORCE_ERROR;
}

Pose toPose(const std::array<HDdouble, 16>& t) {
    const glm::dmat3 rotation(t[0], t[1], t[2], t[4], t[5], t[6], t[8], t[9], t[10]);
    return {glm::normalize(glm::quat_cast(rotation)), Vec3(t[12], t[13], t[14]) * kMetres};
}

class OpenHaptics final : public Sdk {
  public:
    bool open(Capabilities& capabilities, std::string& why) override {
        handle_ = hdInitDevice(HD_DEFAULT_DEVICE);
        if (failed("no device", why)) {
            handle_ = HD_INVALID_HANDLE;
            return false;
        }
        describeDevice(capabilities);
        peak_n_ = capabilities.profile.force_peak_n;
        return true;
    }

    bool start(Servo& servo, std::string& why) override {
        servo_ = &servo;
        hdEnable(HD_FORCE_OUTPUT);
        hdEnable(HD_FORCE_RAMPING);
        hdEnable(HD_MAX_FORCE_CLAMPING);
        hdEnable(HD_SOFTWARE_FORCE_LIMIT);
        tick_ = hdScheduleAsynchronous(&OpenHaptics::tick, this, HD_MAX_SCHEDULER_PRIORITY);
        hdStartScheduler();
        running_ = !failed("the servo loop does not start", why);
        return running_;
    }

    void stop() noexcept override {
        if (running_) {
            // Make the servo's last frame a zero force. The synchronous call returns after that frame has
            // run.
            hdUnschedule(tick_);
            hdScheduleSynchronous(&OpenHaptics::zero, this, HD_MAX_SCHEDULER_PRIORITY);
            hdStopScheduler();
            hdDisable(HD_FORCE_OUTPUT);
            running_ = false;
        }
        if (handle_ != HD_INVALID_HANDLE) hdDisableDevice(handle_);
        handle_ = HD_INVALID_HANDLE;
    }

  private:
    static bool failed(const char* what, std::string& why) {
        const HDErrorInfo error = hdGetError();
        if (!HD_DEVICE_ERROR(error)) return false;
        why = std::string(what) + ": " + hdGetErrorString(error.errorCode);
        return true;
    }

    static void describeDevice(Capabilities& capabilities) {
        const char* model = hdGetString(HD_DEVICE_MODEL_TYPE);
        putText(capabilities.name, model ? model : "OpenHaptics device");
        putText(capabilities.source, "asked of the device through OpenHaptics (nominal figures)");
        DeviceProfile& profile = capabilities.profile;
        HDdouble stiffness_n_per_mm = 0.0;
        HDint inputs = 0, outputs = 0;
        std::array<HDdouble, 6> box_mm{};
        hdGetDoublev(HD_NOMINAL_MAX_FORCE, &profile.force_peak_n);
        hdGetDoublev(HD_NOMINAL_MAX_CONTINUOUS_FORCE, &profile.force_continuous_n);
        hdGetDoublev(HD_NOMINAL_MAX_STIFFNESS, &stiffness_n_per_mm);
        hdGetDoublev(HD_USABLE_WORKSPACE_DIMENSIONS, box_mm.data());
        hdGetIntegerv(HD_INPUT_DOF, &inputs);
        hdGetIntegerv(HD_OUTPUT_DOF, &outputs);
        profile.stiffness_n_per_m = stiffness_n_per_mm / kMetres;
        profile.senses_rotation = inputs >= 6;
        profile.force_axes = std::min(outputs, 3);
        profile.torque_axes = std::clamp(outputs - 3, 0, 3);
        const Vec3 low(box_mm[0], box_mm[1], box_mm[2]), high(box_mm[3], box_mm[4], box_mm[5]);
        const Vec3 size_m = (high - low) * kMetres;
        profile.workspace_centre_m = 0.5 * (low + high) * kMetres;
        profile.workspace_radius_m = 0.5 * std::min({size_m.x, size_m.y, size_m.z});
    }

    static HDCallbackCode HDCALLBACK tick(void* self) { return static_cast<OpenHaptics*>(self)->tickOnce(); }

    static HDCallbackCode HDCALLBACK zero(void* self) {
        const HHD handle = static_cast<OpenHaptics*>(self)->handle_;
        const std::array<HDdouble, 3> none{};
        hdBeginFrame(handle);
        hdSetDoublev(HD_CURRENT_FORCE, none.data());
        hdEndFrame(handle);
        return HD_CALLBACK_DONE;
    }

    HDCallbackCode tickOnce() {
        hdBeginFrame(handle_);
        std::array<HDdouble, 16> transform{};
        HDint buttons = 0;
        hdGetDoublev(HD_CURRENT_TRANSFORM, transform.data());
        hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
        MotorStage motors = force_limited_ ? MotorStage::off : MotorStage::on;
        if (hdCheckCalibration() != HD_CALIBRATION_OK) motors = MotorStage::needsHoming;
        Vec3 force_n =
            servo_->tick({monotonic_ns(), toPose(transform), std::uint32_t(buttons), motors, true}, peak_n_);
        if (motors == MotorStage::needsHoming) force_n = Vec3(0.0);
        const std::array<HDdouble, 3> force{force_n.x, force_n.y, force_n.z};
        hdSetDoublev(HD_CURRENT_FORCE, force.data());
        hdEndFrame(handle_);

        const HDErrorInfo error = hdGetError();
        force_limited_ = HD_DEVICE_ERROR(error) && limitsForce(error.errorCode);
        if (!HD_DEVICE_ERROR(error) || force_limited_) return HD_CALLBACK_CONTINUE;
        servo_->fail(hdGetErrorString(error.errorCode));
        return HD_CALLBACK_DONE;
    }

    HHD handle_ = HD_INVALID_HANDLE;
    HDSchedulerHandle tick_ = 0;
    Servo* servo_ = nullptr;
    double peak_n_ = 0.0;
    bool running_ = false, force_limited_ = false;
};

}  // namespace
}  // namespace stylet::haptics::bridge

int main(int argc, char** argv) {
    stylet::haptics::bridge::OpenHaptics sdk;
    return stylet::haptics::bridge::bridgeMain(sdk, argc, argv);
}
