// Reports to the user when the picture stands still: the frame thread hangs in the driver or in the OpenXR
// runtime. The attempt continues meanwhile, but without force, because the user no longer sees what is felt.
#pragma once

#include <cstdint>
#include <string>

namespace stylet::trainer {

// Longer than any frame, even with software Vulkan.
inline constexpr std::int64_t kPictureStalled_ns = 3'000'000'000;

// Session thread only. Times are of one steady clock.
class PictureWatch {
  public:
    // `drawn_ns`: when the frame thread was last active. Returns a message for the user when a stall begins
    // and when it ends, else an empty text.
    std::string update(std::int64_t now_ns, std::int64_t drawn_ns, bool attempt_paused);
    bool stalled() const { return stalled_; }
    // Length of the current stall, or of the last one for as long as its notice is shown: kShown_ns after its
    // end, and longer while `force_off`. 0: nothing to show.
    double shown_s(std::int64_t now_ns, bool force_off);

    static constexpr std::int64_t kShown_ns = 5'000'000'000;

  private:
    bool stalled_ = false;
    std::int64_t began_ns_ = 0, length_ns_ = 0, ended_ns_ = 0;
};

}  // namespace stylet::trainer
