#include "render/volume/deformed_patient.h"

#include <algorithm>

#include "base/parallel.h"

namespace stylet::render {
namespace {

const Grid kFarAwayGrid{Index3(2), Vec3(1.0), Vec3(1e6)};

}  // namespace

// A node lies in the middle of its texel.
ToImage toImage(const Grid& grid) {
    const Vec3 scale = 1.0 / (grid.spacing_m * Vec3(grid.dims));
    return {glm::vec4(glm::vec3(scale), float(0.5 * grid.spacing_m.x)),
            glm::vec4(glm::vec3(0.5 / Vec3(grid.dims) - grid.origin_m * scale), 0.0f)};
}

DeformedPatient::DeformedPatient(const Gpu& gpu, const patient::Patient& patient)
    : gpu_(&gpu),
      patient_(&patient),
      // Leaves cores for the other loops.
      workers_(std::max(2, processorCount() / 2)),
      maker_(patient.package().motion, {}, &patient),
      inside_(gpu, maker_.tables().grid.dims),
      outside_(gpu, maker_.tables().grid.dims),
      tool_(gpu, Index3(2)) {}

void DeformedPatient::breathe(const patient::Surrogate& breath, bool still) {
    const bool stays = still ? still_ : !still_ && table_breath_ == breath;
    if (stays) return;
    still_ = still;
    ++breath_revision_;
    if (still || table_breath_ == breath) return;
    maker_.compute(breath, workers_);
    table_breath_ = breath;
    packed_ = false;
}

void DeformedPatient::press(const patient::DisplacementTable* table) {
    if (table && table->grid.dims != tool_.dims()) {
        tool_ = TableImage(*gpu_, table->grid.dims);
        ++image_revision_;
    }
    tool_table_ = table;
    tool_packed_ = table == nullptr;
}

void DeformedPatient::recordUploads(const vk::raii::CommandBuffer& commands) {
    if (!packed_) {
        inside_.write(maker_.tables().inside, workers_);
        outside_.write(maker_.tables().outside, workers_);
        packed_ = true;
    }
    if (!tool_packed_) {
        tool_.write(tool_table_->moved_m, workers_);
        tool_packed_ = true;
    }
    inside_.recordUpload(commands);
    outside_.recordUpload(commands);
    tool_.recordUpload(commands);
}

ToImage DeformedPatient::toTool() const {
    return toImage(tool_table_ ? tool_table_->grid : kFarAwayGrid);
}

}  // namespace stylet::render
