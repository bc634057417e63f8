// The patient as the march reads him, on the GPU or beside it: the classified volume of one look, and the
// bricks one may leap over.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "render/memory.h"
#include "render/volume/bricks.h"
#include "render/volume/deformed_patient.h"
#include "render/volume/look.h"
#include "render/volume/march.h"

namespace stylet::render {

class PatientVolume {
  public:
    // Who will march: what he does not read is not made.
    enum class Reader : std::uint8_t { gpu, host };
    // `deformed` is the same patient, of other voxels perhaps; both must outlive it.
    PatientVolume(const Gpu&, const patient::Patient&, const DeformedPatient& deformed, Reader);

    // Classifies when look or reader are others than last time, and uploads for the GPU.
    // True when classified() is another image than before.
    bool show(const LookStyle&, Reader);
    void forgetLook() { shown_ = nullptr; }  // its contents have changed
    // The bricks seen through breath and tool, when either or the look has changed. Once a frame.
    void follow();

    const patient::Patient& patient() const { return *patient_; }
    const GpuImage& classified() const {
        return hasImage() ? classified_ : deformed_->inside();
    }  // host: anything
    const MarchVolume& onHost() const { return on_host_; }
    std::span<const std::uint32_t> brickDistances() const { return leaps_; }
    const Buffer& bricks() const { return brick_buffer_; }
    const DeformedPatient& deformed() const { return *deformed_; }
    patient::Index3 brickDims() const { return breathed_.dims(); }
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
