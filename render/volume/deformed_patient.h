// The current deformed patient, shared by every pass of a picture. Tables undo breath and tool on the host;
// passes on the GPU read them as small images (deform.glsl).
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

    // breathe() and press() cost nothing if nothing has changed. They allocate only for the first table of
    // a size. `still`: readers use the patient as scanned and read no table of the breath.
    void breathe(const patient::Surrogate&, bool still);
    // Sets a tool's displacement for this frame; null: no tool presses. The table is read until the next
    // call.
    void press(const patient::DisplacementTable*);

    const patient::Patient& patient() const { return *patient_; }
    // True for the breath of the package's own CT. `still` then changes no picture.
    bool atRest(const patient::Surrogate& breath) const {
        return breath == patient_->package().motion.reference;
    }
    bool still() const { return still_; }
    int breaths() const { return breaths_; }                        // changes whenever the breath changes
    const DeformTables& tables() const { return maker_.tables(); }  // of the last breath that was not still
    double reach_m() const { return maker_.reach_m(); }
    const patient::DisplacementTable* tool() const { return pressing_; }

    // Records the upload of changed tables. Must precede the commands that read them.
    void recordUploads(const vk::raii::CommandBuffer&);
    const GpuImage& inside() const { return inside_.image(); }
    const GpuImage& outside() const { return outside_.image(); }
    const GpuImage& toolMoved() const { return tool_.image(); }
    // Changes whenever images are recreated. Descriptors that name the old ones are then invalid.
    int imagesMade() const { return images_made_; }

    // From the patient frame to the images' coordinates: p * scale + offset. While no tool presses,
    // toTool() maps to far outside its image.
    struct ToImage {
        glm::vec4 scale, offset;  // scale.w: half a node spacing, m
    };
    ToImage toDeformation() const;
    ToImage toTool() const;

  private:
    const Gpu* gpu_;
    const patient::Patient* patient_;
    Workers workers_;
    DeformMaker maker_;
    TableImage inside_, outside_, tool_;
    std::optional<patient::Surrogate> made_;  // breath of the tables
    const patient::DisplacementTable* pressing_ = nullptr;
    bool still_ = true, packed_ = false, tool_packed_ = true;
    int images_made_ = 0, breaths_ = 0;
};

}  // namespace stylet::render
