// Restarts an earlier attempt at a bookmark. The recorded inputs up to the bookmark are recomputed and
// checked, then new input takes over.
#pragma once

#include <filesystem>
#include <string>

#include "app/records/record.h"
#include "app/trainer/attempt/attempt.h"
#include "haptics/tools/device.h"

namespace stylet::trainer {

struct Retry {
    std::filesystem::path folder;  // folder of the record
    records::Record record;        // up to the bookmark
    records::Bookmark bookmark;
    std::size_t number = 0;  // number of the bookmark, from 1
    // Last recorded tick before the bookmark; set by checkRetry().
    haptics::TickOutput left;
};

// `from`: ATTEMPT[@BOOKMARK]. ATTEMPT is an attempt's folder, a record's folder, or an attempt's id in
// `store`. BOOKMARK is a number from 1 or the bookmark's text; default: the last one. Throws
// DataError, which lists the available bookmarks.
Retry openRetry(const std::string& from, const std::filesystem::path& store);

// Recomputes the record up to the bookmark. Throws DataError if the patient is another one or the
// result differs from the record.
void checkRetry(Retry&, const patient::Patient&);

// Makes the attempt begin with the recorded settings and inputs. Scripted input is moved to the pose of the
// recorded device.
void beginAs(Attempt&, const Retry&, const MakeTouch& = makeTouch);

// Compares the numbers of two profiles on which the force depends. If they differ, the recorded force is
// not suited to the device.
bool sameNumbers(const haptics::DeviceProfile&, const haptics::DeviceProfile&);

// Moves a device without force output to the pose of the recorded device. Forces are not transformed.
class PlacedDevice final : public haptics::HapticDevice {
  public:
    // The device must outlive it.
    PlacedDevice(haptics::HapticDevice& device, const Pose& recorded_from_device)
        : device_(&device), recorded_from_device_(recorded_from_device) {}

    const haptics::DeviceProfile& profile() const noexcept override { return device_->profile(); }
    haptics::DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override {
        haptics::DeviceState state = device_->read(now_ns);
        state.device_from_stylus = recorded_from_device_ * state.device_from_stylus;
        return state;
    }
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { device_->send(force_n); }

  private:
    haptics::HapticDevice* device_;
    Pose recorded_from_device_;
};

}  // namespace stylet::trainer
