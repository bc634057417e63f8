// A sterile drape over the patient, built from the trunk's surface in the CT. It follows the trunk, covers
// legs and table, hangs over the edges in folds, rises over an anaesthesia bar at the head, and has an
// opening around the access field.
#pragma once

#include <span>

#include "render/gpu/memory.h"
#include "render/room/mesh.h"
#include "render/room/scene_meshes.h"

namespace stylet::render {

// Half the size of the opening: around the body and along it.
inline constexpr double kOpeningAround_m = 0.075, kOpeningAlong_m = 0.085;

// Patient frame, reference patient.
struct DrapeShape {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
    std::vector<Vec3> anchors_m;  // skin below each vertex
    std::vector<float> follows;   // 0 to 1: share of the anchor's motion that the vertex follows
};

// `back_m`: y of the table's pad. Always returns a drape, even if the CT shows no proper trunk.
DrapeShape makeDrape(const patient::Patient&, double back_m, const Vec3& field_m);

// Computes the positions of the vertices for a breath. Allocates nothing.
void moveDrape(const DrapeShape&, const patient::MotionModel&, const patient::Surrogate&,
               std::span<glm::vec3> moved_m);

class Drape {
  public:
    Drape(const Gpu&, const patient::Patient&, double back_m, const Vec3& field_m);

    // Moves the cloth when the breath has changed.
    void breathe(const patient::Surrogate&);

    const Vec3& field() const { return field_m_; }
    const Model& model() const { return model_; }
    const Buffer& vertices() const { return vertex_buffer_; }
    const Buffer& indices() const { return index_buffer_; }

  private:
    const patient::Patient* patient_;
    Vec3 field_m_;
    DrapeShape shape_;
    std::vector<glm::vec3> moved_m_;
    Model model_;
    Buffer vertex_buffer_, index_buffer_;
    patient::Surrogate breath_;
};

}  // namespace stylet::render
