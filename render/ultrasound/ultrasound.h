// The ultrasound machine: scans the deformed patient and draws what a sonographer sees. Compute passes of its
// own; leaves its picture in memory that the host sees.
#pragma once

#include <memory>
#include <span>

#include "render/gpu.h"
#include "render/scene.h"
#include "render/ultrasound/acoustics.h"
#include "render/ultrasound/scan.h"
#include "render/ultrasound/transducer.h"

namespace stylet::render {

class DeformedPatient;

class Ultrasound {
  public:
    // Encodes the patient's acoustics (some tenths of a second). Patient and GPU must outlive it. Throws
    // GpuError.
    Ultrasound(const Gpu&, DeformedPatient&, const AcousticTable&);
    ~Ultrasound();
    Ultrasound(Ultrasound&&) noexcept;
    Ultrasound& operator=(Ultrasound&&) noexcept;

    // Frame thread. Scans and waits; allocates only for the first picture of a size or a feature. What cannot
    // be scanned gives a black picture and a reason.
    UltrasoundStats image(const UltrasoundInput&, const UltrasoundSettings&, const Transducer&);
    // The blood's velocity, for Doppler; null: none. Uploaded at once.
    void setFlow(const patient::VesselFlow*);

    // Of the last image(); valid until the next.
    ScreenPicture picture() const;
    // Before compression and gains, as amplitude of a perfect mirror's echo amplified by the compensation:
    // line after line, bin after bin. Empty where nothing was scanned.
    std::span<const float> envelope() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
