// A sterile drape over the patient, made from what he looks like from above: it follows the trunk, covers
// legs and table, hangs over the edges in folds, rises at the head over an anaesthesia bar, and is open
// around the access field.
#pragma once

#include <span>

#include "render/memory.h"
#include "render/room/mesh.h"
#include "render/room/scene_meshes.h"

namespace stylet::render {

// Half the opening along the body's round and along its length.
inline constexpr double kOpeningAround_m = 0.075, kOpeningAlong_m = 0.085;

// Patient frame, as the CT saw him.
struct DrapeShape {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
    std::vector<Vec3> anchors_m;  // of each vertex: the skin below it
    std::vector<float> follows;   // 0 to 1: share of the anchor's motion that the vertex takes part in
};

// `back_m`: height of the table's pad, y. A patient whose trunk is no trunk gets a cloth all the
// same.
DrapeShape makeDrape(const patient::Patient&, double back_m, const Vec3& field_m);

// Where a breath takes the cloth. Allocates nothing.
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
