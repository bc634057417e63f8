// What ray marching reads of the patient, on the GPU or on the host: the volume classified by one look
// (look.h), and the empty bricks that rays skip.
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
    void invalidateLook() { shown_ = nullptr; }  // call when the look's contents have changed
    // Updates the bricks if breath, tool or look have changed. Call once per frame.
    void updateBricks();

    const patient::Patient& patient() const { return *patient_; }
    const GpuImage& classified() const {
        // With Reader::host, a substitute that only has to exist: nothing reads it.
        return hasImage() ? classified_ : deformed_->inside();
    }
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
    void updateForBreath();
    void updateForTool();

    const Gpu* gpu_;
    const patient::Patient* patient_;
    const DeformedPatient* deformed_;
    double back_m_ = 0.0;
    Workers workers_;
    GpuImage classified_;
    Buffer brick_buffer_;
    BreathingBricks breathed_;
    BrickGrid displaced_;
    MarchVolume on_host_;
    std::vector<std::uint32_t> leaps_;
    Reader reader_ = Reader::gpu;
    const LookStyle* shown_ = nullptr;
    int breath_revision_ = -1;
    bool bricks_stale_ = true, pressed_ = false;
};

}  // namespace stylet::render
