// A device without hardware that follows a trace and ignores the force. Used by headless runs, tests and
// replays of recorded motion.
#pragma once

#include <filesystem>
#include <string_view>

#include "haptics/loop/trace.h"
#include "haptics/tools/device.h"

namespace stylet::haptics {

class ReplayDevice final : public HapticDevice {
  public:
    // `start_ns` is the loop time at which the trace begins. The trace must outlive the device.
    ReplayDevice(const Trace&, std::int64_t start_ns, const DeviceProfile& = {});
    const DeviceProfile& profile() const noexcept override { return profile_; }
    // At a sample's time: the recorded pose, bit for bit. Between samples: linear interpolation.
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

// Loads the samples of a trace from CSV (format: packaging/guide/formats.md). Throws DataError: file, line,
// reason. Commands are not included; they belong to the scenario.
Trace loadTrace(const std::filesystem::path& csv);
// The same from text; `file` is used in error messages.
Trace parseTrace(const std::filesystem::path& file, std::string_view csv);
// Writes every number in the shortest form that reads back to the same bits.
void saveTrace(const Trace&, const std::filesystem::path& csv);

}  // namespace stylet::haptics
