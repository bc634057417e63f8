// The opaque meshes of a scene on the GPU, and the draws of one frame.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "render/gpu/memory.h"
#include "render/room/mesh.h"
#include "render/room/placement.h"
#include "render/scene/frame_shared.h"
#include "render/scene/scene.h"

namespace stylet::render {

// Vertex format of mesh.vert. Materials are baked into the vertices, so that a rigid object is one draw.
struct RoomVertex {
    glm::vec3 position_m{0.0f}, normal{0.0f};
    glm::vec2 uv{0.0f};
    std::array<std::uint8_t, 4> root_colour{}, material{};
};
RoomVertex roomVertex(const Vertex&, const MeshPart&);
std::span<const vk::VertexInputAttributeDescription> roomAttributes();

// A rigid object, or the glass of its screen.
struct Model {
    std::uint32_t first_index = 0, index_count = 0;
    glm::vec3 middle_m{0.0f};
    float radius_m = 0.0f;
    glm::vec3 right_m{0.0f}, up_m{0.0f};  // full edges of a screen's glass
};

struct MeshDraw {
    std::uint32_t first_index = 0, index_count = 0;
    gpu::MeshPush push{};
    int kind = gpu::kPlain, lamp = gpu::kUnlit;
    bool casts = false;       // casts a shadow in the lamp's light
    float distance_m = 0.0f;  // from the nearer eye to its nearest point, to draw front to back
};

// Colour of a quality from 0 to 1: dark red, amber, pale green. Lightness rises with quality, so that it
// can be read without telling red from green.
glm::vec3 pathColour(double quality);

class SceneMeshes {
  public:
    SceneMeshes(const Gpu&, const std::filesystem::path& assets);

    // Collects the draws of a scene. With `cull`, visible() omits what lies outside both eyes' view.
    // Allocates nothing after a first scene of this size.
    void collectDraws(const RenderScene&, const Placement&, bool has_patient, const Model* drape,
                      const std::array<View, 2>&, bool cull);

    // Returns the screens that are in the room, face an eye and lie in its view.
    VisibleScreens visibleScreens(const RenderScene&, const Placement&, const std::array<View, 2>&) const;

    ScreenPlaces screenPlaces(const Placement&) const;

    std::span<const MeshDraw> visible() const { return {draws_.data(), visible_count_}; }  // nearest first
    std::span<const MeshDraw> all() const { return draws_; }
    std::size_t culled() const { return draws_.size() - visible_count_; }
    // Footprints on the floor: centre x, z and half-extents x, z, room frame. At most gpu::kMaxContacts.
    const std::vector<glm::vec4>& contacts() const { return contacts_; }
    const Buffer& vertices() const { return vertex_buffer_; }
    const Buffer& indices() const { return index_buffer_; }

  private:
    struct Models {
        Model table_top, table_pedestal, stand, carriage, arc;
        Model ultrasound, ultrasound_screen, xray, xray_screen, monitor, monitor_screen, trolley;
        Model lamp_head, lamp_yoke, lamp_arm, lamp_post, shell, floor, lit_floor, doors, built_in;
        Model shaft, mark, tip_chiba, tip_trocar, tip_diamond, hub, probe, linear_probe, scalpel, hand;
        Model tube, cone, ring;
    };
    void add(const Model&, const glm::dmat4& stage_from_model, bool casts, int kind = gpu::kPlain);
    void addTable(const RenderScene&, const Placement&);
    void addNeedle(const Pose& stage_from_needle, const NeedleShape&);
    void addGhost(const RenderScene&);
    void addTubes(const RenderScene&, const std::vector<CurvedTube>&);
    void addTools(const RenderScene&);
    void addPaths(const RenderScene&);
    void addHighlights(const RenderScene&, const Placement&);
    void addRoom(const RenderScene&, const Placement&);
    void addLampHead(const Placement&, const Lamp&, double arm_height_m, bool lit);
    void addScreen(const Model& thing, const Model& picture, const glm::dmat4& stage_from_model, int screen);

    Models models_;
    Buffer vertex_buffer_, index_buffer_;
    std::vector<MeshDraw> draws_;
    std::vector<glm::vec4> spheres_;  // bounding sphere of each draw, stage
    std::vector<glm::vec4> contacts_;
    std::size_t visible_count_ = 0;
};

}  // namespace stylet::render
