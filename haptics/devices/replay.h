// A device without hardware whose hand nothing can stop: it follows a trace, whatever the force. What
// headless runs, tests and replays of recorded hands use.
#pragma once

#include <filesystem>
#include <string_view>

#include "haptics/device.h"
#include "haptics/trace.h"

namespace stylet::haptics {

class ReplayDevice final : public HapticDevice {
  public:
    // `start_ns` is the loop time at which the trace begins. The trace must outlive the device.
    ReplayDevice(const Trace&, std::int64_t start_ns, const DeviceProfile& = {});
    const DeviceProfile& profile() const noexcept override { return profile_; }
    // At a sample's time the very pose that was recorded, bit for bit; linear between.
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override;
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { force_n_ = force_n; }
    const Vec3& force() const noexcept { return force_n_; }

  private:
    const Trace* trace_;
    std::int64_t start_ns_;
    DeviceProfile profile_;
    std::size_t cursor_ = 0;
    Vec3 force_n_{0.0};
};

// The samples of a trace as CSV (README.md has the format). Throws patient::DataError: file, line, reason.
// Commands are not in it: they belong to the scenario.
Trace loadTrace(const std::filesystem::path& csv);
// The same by its contents; `file` is named when they are refused.
Trace parseTrace(const std::filesystem::path& file, std::string_view csv);
// Every number in the shortest form that reads back as the same bits.
void saveTrace(const Trace&, const std::filesystem::path& csv);

}  // namespace stylet::haptics
