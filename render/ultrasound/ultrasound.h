// The ultrasound machine: scans the deformed patient and draws the picture that a sonographer sees. Runs
// its own compute passes and leaves the picture in host-visible memory.
#pragma once

#include <memory>
#include <span>

#include "render/gpu/gpu.h"
#include "render/scene/scene.h"
#include "render/ultrasound/acoustics.h"
#include "render/ultrasound/scan.h"
#include "render/ultrasound/transducer.h"

namespace stylet::render {

class DeformedPatient;

class Ultrasound {
  public:
    // Encodes the patient's acoustics (some tenths of a second). Patient and GPU must outlive this object.
    // Throws GpuError.
    Ultrasound(const Gpu&, DeformedPatient&, const AcousticTable&);
    ~Ultrasound();
    Ultrasound(Ultrasound&&) noexcept;
    Ultrasound& operator=(Ultrasound&&) noexcept;

    // Frame thread. Scans, draws the picture and waits until the GPU has finished. Allocates only when a
    // picture size or a combination of scan features is used for the first time. If nothing can be scanned,
    // the picture is black and UltrasoundStats::reason says why.
    UltrasoundStats image(const UltrasoundInput&, const UltrasoundSettings&, const Transducer&);
    // Sets the blood's velocity for Doppler; null: none. Uploaded before the call returns.
    void setFlow(const patient::VesselFlow*);

    // Picture of the last image(); valid until the next.
    ScreenPicture picture() const;
    // Echo amplitudes before log compression and before the user's gains. All depth bins of the first scan
    // line come first, then those of the next line. 1 is the echo of a perfect mirror. The machine's
    // compensation for attenuation is already applied. Empty if nothing was scanned.
    std::span<const float> envelope() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace stylet::render
