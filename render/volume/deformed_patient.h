// The current deformed patient, shared by every pass of a picture. Tables undo breath and tool on the host;
// passes on the GPU read them as small images (deform.glsl).
#pragma once

#include <optional>

#include "render/volume/deform.h"
#include "render/volume/table_image.h"

namespace stylet::render {

// Map from the patient frame to the coordinates of a grid's image: p * scale + offset.
struct ToImage {
    glm::vec4 scale, offset;  // scale.w: half a node spacing, m
};
ToImage toImage(const Grid&);

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
    int breathRevision() const { return breath_revision_; }         // changes whenever the breath changes
    const DeformTables& tables() const { return maker_.tables(); }  // of the last breath that was not still
    double reach_m() const { return maker_.reach_m(); }
    const patient::DisplacementTable* tool() const { return tool_table_; }

    // Records the upload of changed tables. Must precede the commands that read them.
    void recordUploads(const vk::raii::CommandBuffer&);
    const GpuImage& inside() const { return inside_.image(); }
    const GpuImage& outside() const { return outside_.image(); }
    const GpuImage& toolMoved() const { return tool_.image(); }
    // Changes whenever images are recreated. Descriptors that name the old ones are then invalid.
    int imageRevision() const { return image_revision_; }

    ToImage toDeformation() const { return toImage(maker_.tables().grid); }
    // While no tool presses, it maps every point to far outside the image.
    ToImage toTool() const;

  private:
    const Gpu* gpu_;
    const patient::Patient* patient_;
    Workers workers_;
    DeformTableBuilder maker_;
    TableImage inside_, outside_, tool_;
    std::optional<patient::Surrogate> table_breath_;  // breath of the tables
    const patient::DisplacementTable* tool_table_ = nullptr;
    bool still_ = true, packed_ = false, tool_packed_ = true;
    int image_revision_ = 0, breath_revision_ = 0;
};

// Sets the uniforms by which shaders look up breath and tool (deform.glsl).
template <typename Uniforms>
void setMotion(Uniforms& uniforms, const DeformedPatient& patient) {
    const ToImage breath = patient.toDeformation(), tool = patient.toTool();
    uniforms.deform_scale = breath.scale, uniforms.deform_offset = breath.offset;
    uniforms.tool_scale = tool.scale, uniforms.tool_offset = tool.offset;
}

}  // namespace stylet::render
