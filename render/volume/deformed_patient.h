// The patient of the moment, as every pass of a picture reads him: breath and tool undone by tables, on the
// host and, for passes that ask, as small images on the GPU (deform.glsl).
#pragma once

#include <optional>

#include "render/volume/deform.h"
#include "render/volume/table_image.h"

namespace stylet::render {

// Frame thread.
class DeformedPatient {
  public:
    // The patient must outlive it.
    DeformedPatient(const Gpu&, const patient::Patient&);

    // Both are free when nothing has changed; they allocate only for a first table of a size. `still`:
    // whoever reads on takes the patient as the CT saw him, and asks no table of the breath.
    void breathe(const patient::Surrogate&, bool still);
    // What a tool displaces in this frame; null: nothing presses. Read until the next call.
    void press(const patient::DisplacementTable*);

    const patient::Patient& patient() const { return *patient_; }
    // The breath of the package's own CT: `still` then changes no picture.
    bool atRest(const patient::Surrogate& breath) const {
        return breath == patient_->package().motion.reference;
    }
    bool still() const { return still_; }
    int breaths() const { return breaths_; }  // another one: the breath is not what it was
    const DeformTables& tables() const { return maker_.tables(); }  // of the last breath that was not still
    double reach_m() const { return maker_.reach_m(); }
    const patient::DisplacementTable* tool() const { return pressing_; }

    // What has changed goes up with the commands of whoever reads it, before he does.
    void recordUploads(const vk::raii::CommandBuffer&);
    const GpuImage& inside() const { return inside_.image(); }
    const GpuImage& outside() const { return outside_.image(); }
    const GpuImage& toolMoved() const { return tool_.image(); }
    // Another one: images were made anew, and descriptors name what is gone.
    int imagesMade() const { return images_made_; }

    // From the patient frame to the images' coordinates: p * scale + offset. Far away while nothing presses.
    struct ToImage {
        glm::vec4 scale, offset;  // scale.w: half a node, m
    };
    ToImage toDeformation() const;
    ToImage toTool() const;

  private:
    const Gpu* gpu_;
    const patient::Patient* patient_;
    Workers workers_;
    DeformMaker maker_;
    TableImage inside_, outside_, tool_;
    std::optional<patient::Surrogate> made_;  // what the tables show
    const patient::DisplacementTable* pressing_ = nullptr;
    bool still_ = true, packed_ = false, tool_packed_ = true;
    int images_made_ = 0, breaths_ = 0;
};

}  // namespace stylet::render
