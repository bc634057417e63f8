// The opaque things of a scene on the GPU, and which of their parts one frame draws where.
#pragma once

#include <filesystem>
#include <vector>

#include "render/frame_shared.h"
#include "render/memory.h"
#include "render/mesh.h"
#include "render/patient_volume.h"
#include "render/scene.h"

namespace stylet::render {

struct MeshDraw {
    std::uint32_t first_index = 0, index_count = 0;
    gpu::MeshPush push{};
};

class SceneMeshes {
  public:
    SceneMeshes(const Gpu&, const std::filesystem::path& assets);

    // What this frame shows. `volume` may be null: then there is no table, which is placed under a patient.
    std::vector<MeshDraw> drawsOf(const RenderScene&, const PatientVolume* volume) const;

    const Buffer& vertices() const { return vertex_buffer_; }
    const Buffer& indices() const { return index_buffer_; }

  private:
    std::vector<MeshPart> append(const Mesh&, Mesh& all) const;
    Buffer vertex_buffer_, index_buffer_;
    std::vector<MeshPart> table_top_, table_pedestal_, needle_, tube_;
};

// Where the table's top stands: under the trunk, touching the back.
Pose patientFromTable(const PatientVolume&);

}  // namespace stylet::render
