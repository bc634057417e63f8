// 3D sound output through OpenAL Soft. One thread at a time.
#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "app/trainer/sound/cues.h"

namespace stylet::trainer {

struct SoundError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class Speaker {
  public:
    // Opens the system's default device. Throws SoundError if there is none or it does not work.
    static Speaker device();
    // Opens a device without hardware (ALC_SOFT_loopback): two channels at kClipRate_hz. render() returns
    // its output.
    static Speaker loopback();
    ~Speaker();
    Speaker(Speaker&&) noexcept;
    Speaker& operator=(Speaker&&) noexcept;

    void play(const Heard&);
    void listen(const Pose& stage_from_head);
    // False once the device was unplugged or its sound server ended.
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
