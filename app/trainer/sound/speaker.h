// What is heard, played in three dimensions through OpenAL Soft. One thread at a time.
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
    // The system's default device. Throws SoundError: there is none, or it does not answer as it should.
    static Speaker device();
    // A device without hardware (ALC_SOFT_loopback), two channels at kClipRate_hz: render() makes what would
    // be heard.
    static Speaker loopback();
    ~Speaker();
    Speaker(Speaker&&) noexcept;
    Speaker& operator=(Speaker&&) noexcept;

    void play(const Heard&);
    void listen(const patient::Pose& stage_from_head);
    // False once the device was unplugged or its server went.
    bool connected() const;
    // Between what is mixed and the ear, as the device says; 0 where it does not.
    double latency_s() const;
    const std::string& name() const;
    // Of a loopback: left and right in turns.
    void render(std::span<float> stereo);

  private:
    struct Impl;
    explicit Speaker(std::unique_ptr<Impl>);
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::trainer
