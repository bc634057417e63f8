// 3D sound output through OpenAL Soft. Use from one thread at a time.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "app/trainer/sound/cues.h"
#include "base/errors.h"

namespace stylet::trainer {

struct SoundError : EnvironmentError {
    using EnvironmentError::EnvironmentError;
};

class Speaker {
  public:
    // Opens the system's default device. Throws SoundError if there is none or it does not work.
    static Speaker device();
    // Opens a device without hardware (ALC_SOFT_loopback) with two channels at kClipRate_hz. render() returns
    // its output.
    static Speaker loopback();
    ~Speaker();
    Speaker(Speaker&&) noexcept;
    Speaker& operator=(Speaker&&) noexcept;

    void play(const SoundFrame&);
    void listen(const Pose& stage_from_head);
    // Returns false once the device is unplugged or its sound server has ended.
    bool connected() const;
    // Latency from mixing to the listener, as reported by the device; 0 if unknown.
    double latency_s() const;
    const std::string& name() const;
    // Loopback only. Samples alternate left and right.
    void render(std::span<float> stereo);

  private:
    struct Impl;
    explicit Speaker(std::unique_ptr<Impl>);
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
