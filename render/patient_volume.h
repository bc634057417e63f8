// The patient on the GPU: the classified volume of one look, the bricks one may leap over, the deformation.
#pragma once

#include <optional>

#include "render/bricks.h"
#include "render/look.h"
#include "render/memory.h"

namespace stylet::render {

class PatientVolume {
  public:
    PatientVolume(const Gpu&, const patient::Patient&);

    // Classifies and uploads when the look is another one than last time (about a second for 24 million
    // voxels).
    void show(const LookStyle&);
    // Recomputes the deformation and the bricks seen through it when the surrogate or the look changed.
    // `still`: the patient is as the CT saw him, and nothing is deformed.
    void breathe(const patient::Surrogate&, bool still);

    const patient::Patient& patient() const { return *patient_; }
    const GpuImage& classified() const { return classified_; }
    const Buffer& bricks() const { return brick_buffer_; }
    const GpuImage& inside() const { return inside_; }
    const GpuImage& outside() const { return outside_; }
    const patient::Grid& deformation() const { return tables_.grid; }
    patient::Index3 brickDims() const { return reference_.dims; }
    double backHeight() const { return back_m_; }  // y of the patient's back, where the table's pad begins, m

  private:
    void uploadTables();

    const Gpu* gpu_;
    const patient::Patient* patient_;
    double back_m_ = 0.0;
    DeformTables tables_;
    GpuImage classified_, inside_, outside_;
    Buffer brick_buffer_;
    BrickGrid reference_;
    const LookStyle* shown_ = nullptr;
    std::optional<patient::Surrogate> breath_;
    bool still_ = false, stale_ = true;
};

}  // namespace stylet::render
