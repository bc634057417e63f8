// The patient as the march reads it, on the GPU or on the host: the classified volume of one look, and the
// bricks that rays may leap over.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "render/gpu/memory.h"
#include "render/volume/bricks.h"
#include "render/volume/deformed_patient.h"
#include "render/volume/look.h"
#include "render/volume/march.h"

namespace stylet::render {

class PatientVolume {
  public:
    // Where the march runs. Data for the other side is not created.
    enum class Reader : std::uint8_t { gpu, host };
    // `deformed` is the same patient, perhaps at another resolution. Both must outlive this object.
    PatientVolume(const Gpu&, const patient::Patient&, const DeformedPatient& deformed, Reader);

    // Classifies the volume if look or reader have changed, and uploads it for the GPU. Returns true if
    // classified() is now another image.
    bool show(const LookStyle&, Reader);
    void forgetLook() { shown_ = nullptr; }  // call when the look's contents have changed
    // Updates the bricks if breath, tool or look have changed. Call once per frame.
    void follow();

    const patient::Patient& patient() const { return *patient_; }
    const GpuImage& classified() const {
        return hasImage() ? classified_ : deformed_->inside();
    }  // with Reader::host: an image that is never read
    const MarchVolume& onHost() const { return on_host_; }
    std::span<const std::uint32_t> brickDistances() const { return leaps_; }
    const Buffer& bricks() const { return brick_buffer_; }
    const DeformedPatient& deformed() const { return *deformed_; }
    Index3 brickDims() const { return breathed_.dims(); }
    double backHeight() const { return back_m_; }  // y of the patient's back, where the table's pad begins, m

  private:
    bool hasImage() const { return classified_.extent.width > 0; }
    void classify(const LookStyle&);
    void classifyOnHost(const std::function<void(int, int, std::byte*)>& planes);
    void seeBreath();
    void seeTool();

    const Gpu* gpu_;
    const patient::Patient* patient_;
    const DeformedPatient* deformed_;
    double back_m_ = 0.0;
    Workers workers_;
    GpuImage classified_;
    Buffer brick_buffer_;
    BreathedBricks breathed_;
    BrickGrid displaced_;
    MarchVolume on_host_;
    std::vector<std::uint32_t> leaps_;
    Reader reader_ = Reader::gpu;
    const LookStyle* shown_ = nullptr;
    int breaths_seen_ = -1;
    bool bricks_stale_ = true, pressed_ = false;
};

}  // namespace stylet::render
