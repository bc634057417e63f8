// Going through an attempt again from a bookmark: the recorded inputs up to there are computed again and
// checked, then the hand takes over.
#pragma once

#include <filesystem>
#include <string>

#include "app/records/record.h"
#include "app/trainer/attempt.h"
#include "haptics/device.h"

namespace stylet::trainer {

struct Retry {
    std::filesystem::path folder;  // of the record
    records::Record record;        // up to the bookmark
    records::Bookmark bookmark;
    std::size_t number = 0;  // of the bookmark, from 1
    // Where the tool was left, once checkRetry() has computed it.
    haptics::TickOutput left;
};

// `from`: ATTEMPT[@BOOKMARK]. The attempt: its folder, its record's, or its id in `store`. The bookmark: its
// number from 1 or its text; the last where it is left out. Throws patient::DataError, which lists the
// bookmarks there are.
Retry openRetry(const std::string& from, const std::filesystem::path& store);

// Computes it again up to the bookmark. Throws patient::DataError: another patient, or not what was recorded.
void checkRetry(Retry&, const patient::Patient&);

// The attempt begins as the record does, with all that is computed from; its scripted hand is moved to where
// the recorded device stood.
void beginAs(Attempt&, const Retry&, const MakeTouch& = makeTouch);

// Where the profile's numbers are others, a device would not get the force that it can bear.
bool sameNumbers(const haptics::DeviceProfile&, const haptics::DeviceProfile&);

// A device that pushes nothing, in the place of the recorded one.
class PlacedDevice final : public haptics::HapticDevice {
  public:
    // The device must outlive it.
    PlacedDevice(haptics::HapticDevice& device, const patient::Pose& recorded_from_device)
        : device_(&device), recorded_from_device_(recorded_from_device) {}

    const haptics::DeviceProfile& profile() const noexcept override { return device_->profile(); }
    haptics::DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override {
        haptics::DeviceState state = device_->read(now_ns);
        state.device_from_stylus = recorded_from_device_ * state.device_from_stylus;
        return state;
    }
    void send(const haptics::Vec3& force_n) noexcept STYLET_NONBLOCKING override { device_->send(force_n); }

  private:
    haptics::HapticDevice* device_;
    patient::Pose recorded_from_device_;
};

}  // namespace stylet::trainer
