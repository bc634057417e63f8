#include "render/room/scene_meshes.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "patient/package/package.h"
#include "render/scene/projection.h"

namespace stylet::render {
namespace {

constexpr int kTubeSides = 12, kRingSides = 40;
constexpr float kRingThickness = 0.09f;  // of a ring with radius 1
constexpr double kPathRadius_m = 0.0006, kPathOutside_m = 0.045;
constexpr double kEntryRadius_m = 0.004, kEntryThickness_m = 0.0012;
constexpr glm::vec3 kReferenceColour{0.05f, 0.75f, 0.95f};
// Not a colour of skin, iodine, cloth, path or alerts.
constexpr glm::vec3 kHighlightColour{0.95f, 0.08f, 0.75f};
constexpr double kArrowRadius_m = 0.002, kArrowHead_m = 0.016, kArrowHeadRadius_m = 0.0065;
constexpr float kHighlightGlow = 0.9f;
constexpr glm::vec3 kGhostColour{0.25f, 0.75f, 1.0f};
constexpr float kGhostGlow = 0.25f;
// Colour of a lamp head that is off, relative to one that is on. It dims the shell as well as the glass.
constexpr glm::vec3 kUnlitHead{0.2f};
constexpr double kMark_m = 0.001;  // length of a mark on the needle
constexpr int kMaxMarks = 64;
constexpr double kStandHeight_m = 1.07;  // height of the isocentre above the floor in c_arm.glb
constexpr float kFarAway_m = 1e3f;       // sort distance of the shell, which is drawn last

// Room frame, m. The operator stands at +x.
const Vec3 kOperator(0.62, 1.55, 0.0);
const Vec3 kLampPost(-0.30, 3.0, -0.45), kSecondLamp(-0.85, 2.08, -0.95);
constexpr double kArmHeights_m[2] = {2.74, 2.62}, kArmLink_m = 0.92, kYokeTop_m = 0.42;

std::uint8_t toByte(float share) {
    return std::uint8_t(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
}

// Collects the meshes of the assets in one list, and the range of each model in it.
class ModelCollector {
  public:
    explicit ModelCollector(const std::filesystem::path& assets) : assets_(assets) {}

    void open(const char* name) {
        file_ = assets_ / name;
        mesh_ = loadMesh(file_);
    }
    void open(Mesh mesh) { mesh_ = std::move(mesh); }

    // Appends a node without its screens. If `material` is given, appends only the parts of that material.
    Model append(std::string_view node, std::string_view material = {}) {
        Model model;
        model.first_index = std::uint32_t(indices.size());
        glm::vec3 low(1e9f), high(-1e9f), bottom_left(0.0f), bottom_right(0.0f), top_left(0.0f);
        for (const MeshPart& part : mesh_.parts) {
            const bool screen = part.name.starts_with("screen:");
            if (part.node != node || (material.empty() ? screen : part.name != material)) continue;
            for (std::uint32_t i = 0; i < part.index_count; ++i) {
                const Vertex& v = mesh_.vertices[mesh_.indices[part.first_index + i]];
                low = glm::min(low, v.position_m), high = glm::max(high, v.position_m);
                if (v.uv.x < 0.5f && v.uv.y > 0.5f) bottom_left = v.position_m;
                if (v.uv.x > 0.5f && v.uv.y > 0.5f) bottom_right = v.position_m;
                if (v.uv.x < 0.5f && v.uv.y < 0.5f) top_left = v.position_m;
            }
            append(part);
        }
        model.index_count = std::uint32_t(indices.size()) - model.first_index;
        if (model.index_count == 0)
            throw DataError(file_, "node '" + std::string(node) + "'",
                            material.empty() ? "missing" : "without " + std::string(material));
        model.middle_m = 0.5f * (low + high);
        model.radius_m = 0.5f * glm::length(high - low);
        model.right_m = bottom_right - bottom_left, model.up_m = top_left - bottom_left;
        return model;
    }

    std::vector<RoomVertex> vertices;
    std::vector<std::uint32_t> indices;

  private:
    void append(const MeshPart& part) {
        constexpr auto kNone = ~std::uint32_t(0);
        remap_.assign(mesh_.vertices.size(), kNone);
        for (std::uint32_t i = 0; i < part.index_count; ++i) {
            const std::uint32_t old = mesh_.indices[part.first_index + i];
            if (remap_[old] == kNone) {
                remap_[old] = std::uint32_t(vertices.size());
                vertices.push_back(roomVertex(mesh_.vertices[old], part));
            }
            indices.push_back(remap_[old]);
        }
    }

    std::filesystem::path assets_, file_;
    Mesh mesh_;
    std::vector<std::uint32_t> remap_;
};

// Planes of a view's frustum in the stage, pointing inward: its four sides, and the plane through the eye.
std::array<glm::vec4, 5> frustumPlanes(const View& view) {
    const auto plane = [&](double x, double y, double z) {
        const Vec3 n = view.stage_from_eye.direction(glm::normalize(Vec3(x, y, z)));
        return glm::vec4(glm::vec3(n), float(-glm::dot(n, view.stage_from_eye.position_m)));
    };
    return {plane(1.0, 0.0, std::tan(double(view.angle_left))),
            plane(-1.0, 0.0, -std::tan(double(view.angle_right))),
            plane(0.0, 1.0, std::tan(double(view.angle_down))),
            plane(0.0, -1.0, -std::tan(double(view.angle_up))), plane(0.0, 0.0, -1.0)};
}

bool touches(const std::array<glm::vec4, 5>& planes, const glm::vec4& sphere) {
    return std::all_of(planes.begin(), planes.end(), [&](const glm::vec4& plane) {
        return glm::dot(glm::vec3(plane), glm::vec3(sphere)) + plane.w > -sphere.w;
    });
}

// True if a sphere reaches into a lamp's beam.
bool isLit(const Lamp& lamp, const glm::vec4& sphere) {
    // Outside a cone the beam is weaker than kBeamEdge. kSlope: radius over length of its axis. kLength:
    // length of its side over length of its axis.
    constexpr float kSlope = 0.5f, kLength = 1.12f;
    const glm::vec3 from = glm::vec3(sphere) - glm::vec3(lamp.stage_m);
    const auto way = glm::vec3(glm::normalize(lamp.field_m - lamp.stage_m));
    const float along = glm::dot(from, way), across = glm::length(from - along * way);
    return across < kSlope * std::max(along, 0.0f) + kLength * sphere.w && along > -sphere.w;
}

// Upright pose with +z toward the operator.
Pose facingOperator(const Vec3& at) {
    const Vec3 way = kOperator - at;
    return {glm::angleAxis(std::atan2(way.x, way.z), Vec3(0.0, 1.0, 0.0)), at};
}

}  // namespace

RoomVertex roomVertex(const Vertex& v, const MeshPart& part) {
    const glm::vec3 c = part.colour_linear, e = part.emission_linear;
    const float brightest = std::max({c.r, c.g, c.b, 1e-3f});
    return {
        v.position_m,
        v.normal,
        v.uv,
        {toByte(std::sqrt(c.r)), toByte(std::sqrt(c.g)), toByte(std::sqrt(c.b)), toByte(v.open)},
        {toByte(part.metallic), toByte(part.roughness), toByte(std::max({e.r, e.g, e.b}) / brightest), 0}};
}

std::span<const vk::VertexInputAttributeDescription> roomAttributes() {
    static constexpr std::array attributes{
        vk::VertexInputAttributeDescription{0, 0, vk::Format::eR32G32B32Sfloat,
                                            offsetof(RoomVertex, position_m)},
        vk::VertexInputAttributeDescription{1, 0, vk::Format::eR32G32B32Sfloat, offsetof(RoomVertex, normal)},
        vk::VertexInputAttributeDescription{2, 0, vk::Format::eR32G32Sfloat, offsetof(RoomVertex, uv)},
        vk::VertexInputAttributeDescription{3, 0, vk::Format::eR8G8B8A8Unorm,
                                            offsetof(RoomVertex, root_colour)},
        vk::VertexInputAttributeDescription{4, 0, vk::Format::eR8G8B8A8Unorm,
                                            offsetof(RoomVertex, material)}};
    return attributes;
}

glm::vec3 pathColour(double quality) {
    // Square roots of linear light, because linear interpolation between them looks even.
    constexpr glm::vec3 kBad{0.62f, 0.10f, 0.10f}, kFair{0.93f, 0.66f, 0.16f}, kGood{0.62f, 0.97f, 0.80f};
    const auto q = float(std::clamp(quality, 0.0, 1.0));
    const glm::vec3 root =
        q < 0.5f ? glm::mix(kBad, kFair, 2.0f * q) : glm::mix(kFair, kGood, 2.0f * q - 1.0f);
    return root * root;
}

SceneMeshes::SceneMeshes(const Gpu& gpu, const std::filesystem::path& assets) {
    // In the order of the buffers. An empty file name means the file of the row before.
    struct Source {
        Model Models::* model;
        const char *file, *node, *material;
    };
    constexpr Source kSources[] = {{&Models::table_top, "rooms/table_top.glb", "top", ""},
                                   {&Models::table_pedestal, "rooms/table_pedestal.glb", "pedestal", ""},
                                   {&Models::stand, "rooms/c_arm.glb", "stand", ""},
                                   {&Models::carriage, "", "carriage", ""},
                                   {&Models::arc, "", "arc", ""},
                                   {&Models::ultrasound, "rooms/ultrasound.glb", "ultrasound", ""},
                                   {&Models::ultrasound_screen, "", "ultrasound", "screen:ultrasound"},
                                   {&Models::xray, "rooms/xray_monitor.glb", "xray", ""},
                                   {&Models::xray_screen, "", "xray", "screen:xray"},
                                   {&Models::monitor, "rooms/patient_monitor.glb", "monitor", ""},
                                   {&Models::monitor_screen, "", "monitor", "screen:monitor"},
                                   {&Models::trolley, "rooms/trolley.glb", "trolley", ""},
                                   {&Models::lamp_head, "rooms/lamp.glb", "head", ""},
                                   {&Models::lamp_yoke, "", "yoke", ""},
                                   {&Models::lamp_arm, "", "arm", ""},
                                   {&Models::lamp_post, "", "post", ""},
                                   {&Models::shell, "rooms/room.glb", "shell", ""},
                                   {&Models::floor, "", "floor", ""},
                                   {&Models::lit_floor, "", "lit_floor", ""},
                                   {&Models::doors, "rooms/built_in.glb", "doors", ""},
                                   {&Models::built_in, "", "built_in", ""},
                                   {&Models::shaft, "instruments/needle.glb", "shaft", ""},
                                   {&Models::mark, "", "mark", ""},
                                   {&Models::tip_chiba, "", "tip_chiba", ""},
                                   {&Models::tip_trocar, "", "tip_trocar", ""},
                                   {&Models::tip_diamond, "", "tip_diamond", ""},
                                   {&Models::hub, "", "hub", ""},
                                   {&Models::probe, "instruments/probe.glb", "probe", ""},
                                   {&Models::linear_probe, "", "linear_probe", ""},
                                   {&Models::scalpel, "instruments/scalpel.glb", "scalpel", ""},
                                   {&Models::hand, "instruments/hand.glb", "hand", ""}};
    ModelCollector collector(assets);
    for (const Source& source : kSources) {
        if (*source.file) collector.open(source.file);
        models_.*source.model = collector.append(source.node, source.material);
    }
    collector.open(unitTube(kTubeSides));
    models_.tube = collector.append("tube");
    collector.open(unitCone(kTubeSides));
    models_.cone = collector.append("cone");
    collector.open(unitRing(kRingSides, kTubeSides, kRingThickness));
    models_.ring = collector.append("ring");
    vertex_buffer_ = makeFilledBuffer(gpu, collector.vertices, vk::BufferUsageFlagBits::eVertexBuffer);
    index_buffer_ = makeFilledBuffer(gpu, collector.indices, vk::BufferUsageFlagBits::eIndexBuffer);
}

void SceneMeshes::add(const Model& model, const glm::dmat4& stage_from_model, bool casts, int kind) {
    const glm::dvec4 middle = stage_from_model * glm::dvec4(glm::dvec3(model.middle_m), 1.0);
    const double stretch =
        std::max({glm::length(glm::dvec3(stage_from_model[0])), glm::length(glm::dvec3(stage_from_model[1])),
                  glm::length(glm::dvec3(stage_from_model[2]))});
    spheres_.emplace_back(glm::vec3(middle), float(stretch) * model.radius_m);
    draws_.push_back({model.first_index,
                      model.index_count,
                      {.stage_from_model = glm::mat4(stage_from_model),
                       .colour = glm::vec4(1.0f, 1.0f, 1.0f, 0.0f),
                       .material = glm::vec4(0.0f)},
                      kind,
                      gpu::kUnlit,
                      casts});
}

void SceneMeshes::addTable(const RenderScene& scene, const Placement& placed) {
    if (!scene.table) return;
    const glm::dmat4 stage_from_table = toMatrix(placed.stage_from_table);
    add(models_.table_top, stage_from_table, true, gpu::kTable);
    add(models_.table_pedestal, scaled(stage_from_table, Vec3(1.0, placed.table_height_m, 1.0)), true);
    contacts_.emplace_back(0.0f, -0.94f, 0.28f, 0.42f);
}

// Shaft, tip and mark have radius 1 and length 1 (assets/generate/instruments.py).
void SceneMeshes::addNeedle(const Pose& stage_from_needle, const NeedleShape& needle) {
    const auto part = [&](const Model& model, double at_m, const Vec3& size, bool casts = true) {
        const Pose needle_from_part{Quat(1.0, 0.0, 0.0, 0.0), Vec3(0.0, 0.0, at_m)};
        add(model, scaled(toMatrix(stage_from_needle * needle_from_part), size), casts);
        draws_.back().push.material.w = gpu::kThin;
    };
    const double radius_m = needle.radius_m(), tip_m = needle.tipLength_m();
    const Model& tip = needle.tip == NeedleTip::chiba    ? models_.tip_chiba
                       : needle.tip == NeedleTip::trocar ? models_.tip_trocar
                                                         : models_.tip_diamond;
    part(tip, 0.0, {radius_m, radius_m, tip_m});
    part(models_.shaft, tip_m, {radius_m, radius_m, needle.length_m - tip_m});
    part(models_.hub, needle.length_m, Vec3(1.0));
    if (needle.mark_step_m <= 0.0) return;
    // Every fifth mark, counted from the tip, is double. A mark's shadow is that of the shaft.
    const auto mark = [&](double at_m) { part(models_.mark, at_m, {radius_m, radius_m, kMark_m}, false); };
    for (int i = 0; i < kMaxMarks; ++i) {
        const double at_m = needle.first_mark_m + i * needle.mark_step_m;
        if (at_m > needle.length_m - kMark_m) break;
        if (std::lround(at_m / needle.mark_step_m) % 5 == 0)
            mark(at_m - kMark_m), mark(at_m + kMark_m);
        else
            mark(at_m);
    }
}

void SceneMeshes::addTubes(const RenderScene& scene, const std::vector<CurvedTube>& tubes) {
    const glm::dmat4 stage_from_patient = toMatrix(scene.stage_from_patient);
    for (const CurvedTube& tube : tubes)
        for (std::size_t i = 1; i < tube.points_m.size(); ++i) {
            const Vec3 &begin = tube.points_m[i - 1], &end = tube.points_m[i];
            if (!(glm::distance(begin, end) > 0.0)) continue;
            add(models_.tube, stage_from_patient * tubeBetween(begin, end, tube.radius_m), true);
            draws_.back().push.colour = glm::vec4(tube.colour, 0.0f);
            draws_.back().push.material.w = gpu::kThin;
        }
}

void SceneMeshes::addTools(const RenderScene& scene) {
    const auto tool = [&](const Model& model, const std::optional<Pose>& patient_from_tool) {
        if (patient_from_tool) add(model, toMatrix(scene.stage_from_patient * *patient_from_tool), true);
    };
    if (scene.patient_from_needle)
        addNeedle(scene.stage_from_patient * *scene.patient_from_needle, scene.needle);
    addTubes(scene, scene.tubes);
    tool(scene.flat_probe ? models_.linear_probe : models_.probe, scene.patient_from_probe);
    tool(models_.scalpel, scene.patient_from_scalpel);
    tool(models_.hand, scene.patient_from_finger);
}

void SceneMeshes::addGhost(const RenderScene& scene) {
    const std::size_t first = draws_.size();
    addTubes(scene, scene.ghost_tubes);
    if (scene.ghost) {
        const Pose stage_from_tool = scene.stage_from_patient * scene.ghost->patient_from_tool;
        switch (scene.ghost->kind) {
            case GhostKind::needle:
                addNeedle(stage_from_tool, scene.needle);
                break;
            case GhostKind::probe:
                add(scene.flat_probe ? models_.linear_probe : models_.probe, toMatrix(stage_from_tool),
                    false);
                break;
            case GhostKind::scalpel:
                add(models_.scalpel, toMatrix(stage_from_tool), false);
                break;
            case GhostKind::finger:
                add(models_.hand, toMatrix(stage_from_tool), false);
        }
    }
    for (std::size_t i = first; i < draws_.size(); ++i) {
        draws_[i].kind = gpu::kGhost, draws_[i].casts = false;
        draws_[i].push.colour = glm::vec4(kGhostColour, kGhostGlow);
    }
}

void SceneMeshes::addPaths(const RenderScene& scene) {
    const glm::dmat4 stage_from_patient = toMatrix(scene.stage_from_patient);
    const auto path = [&](const Vec3& entry, const Vec3& target, const glm::vec3& colour) {
        const double length = glm::length(target - entry);
        if (!(length > 0.0)) return;
        const Vec3 out = (entry - target) / length;
        const std::size_t first = draws_.size();
        add(models_.tube,
            stage_from_patient * tubeBetween(target, entry + out * kPathOutside_m, kPathRadius_m), false);
        draws_.back().push.material.w = gpu::kThin;
        add(models_.tube,
            stage_from_patient *
                tubeBetween(entry - out * kEntryThickness_m, entry + out * kEntryThickness_m, kEntryRadius_m),
            false);
        for (std::size_t i = first; i < draws_.size(); ++i)
            draws_[i].push.colour = glm::vec4(colour, 0.6f);
    };
    if (scene.reference_path_m)
        path((*scene.reference_path_m)[0], (*scene.reference_path_m)[1], kReferenceColour);
    for (const ShownPath& shown : scene.paths)
        path(shown.entry_m, shown.target_m, pathColour(shown.quality));
}

void SceneMeshes::addHighlights(const RenderScene& scene, const Placement& placed) {
    const std::size_t first = draws_.size();
    for (const Highlight& mark : scene.highlights) {
        const glm::dmat4 stage_from_mark =
            toMatrix(mark.in_room ? placed.stage_from_room : scene.stage_from_patient);
        const auto tube = [&](const Model& model, double from_m, double to_m, double radius_m) {
            add(model,
                stage_from_mark *
                    tubeBetween(mark.at_m - from_m * mark.along, mark.at_m - to_m * mark.along, radius_m),
                false);
        };
        if (mark.ring_m > 0.0) tube(models_.ring, 0.0, -mark.ring_m, mark.ring_m);
        if (!(mark.arrow_m > 0.0)) continue;
        const double head_m = std::min(kArrowHead_m, mark.arrow_m);
        tube(models_.cone, head_m, 0.0, kArrowHeadRadius_m);
        if (mark.arrow_m > head_m) tube(models_.tube, mark.arrow_m, head_m, kArrowRadius_m);
    }
    for (std::size_t i = first; i < draws_.size(); ++i)
        draws_[i].push.colour = glm::vec4(kHighlightColour, kHighlightGlow);
}

void SceneMeshes::addScreen(const Model& thing, const Model& picture, const glm::dmat4& stage_from_model,
                            int screen) {
    add(thing, stage_from_model, false);
    add(picture, stage_from_model, false, gpu::kScreen);
    draws_.back().push.material.x = float(screen + 1);
}

// Adds a lamp head with its yoke, hung from the post by two links of equal length.
void SceneMeshes::addLampHead(const Placement& placed, const Lamp& lamp, double arm_height_m, bool lit) {
    const Pose room_from_stage = placed.stage_from_room.inverse();
    const Pose room_from_head = room_from_stage * lamp.stage_from_head;
    const Vec3 head = room_from_head.position_m, axis = room_from_head.direction({1.0, 0.0, 0.0});
    const double turn = std::atan2(-axis.z, axis.x);
    const glm::dmat4 stage_from_room = toMatrix(placed.stage_from_room);
    add(models_.lamp_head, toMatrix(lamp.stage_from_head), false);
    if (!lit) draws_.back().push.colour = glm::vec4(kUnlitHead, 0.0f);
    const Pose yoke{glm::angleAxis(turn, Vec3(0.0, 1.0, 0.0)), head};
    add(models_.lamp_yoke, stage_from_room * toMatrix(yoke), false);
    const glm::dvec2 from(kLampPost.x, kLampPost.z), to(head.x, head.z);
    const glm::dvec2 elbow = findElbow(from, to, kArmLink_m, kArmLink_m);
    const auto bar = [&](const glm::dvec2& a, const glm::dvec2& b, double height) {
        const glm::dvec2 way = b - a;
        const Pose pose{glm::angleAxis(std::atan2(-way.y, way.x), Vec3(0.0, 1.0, 0.0)),
                        Vec3(a.x, height, a.y)};
        add(models_.lamp_arm, stage_from_room * scaled(toMatrix(pose), Vec3(glm::length(way), 1.0, 1.0)),
            false);
    };
    bar(from, elbow, arm_height_m);
    bar(elbow, to, arm_height_m);
    const double drop = arm_height_m - head.y - kYokeTop_m;
    if (drop > 0.0)
        add(models_.tube,
            stage_from_room * tubeBetween(Vec3(head.x, head.y + kYokeTop_m, head.z),
                                          Vec3(head.x, arm_height_m, head.z), 0.03),
            false);
}

VisibleScreens SceneMeshes::visibleScreens(const RenderScene& scene, const Placement& placed,
                                           const std::array<View, 2>& views) const {
    const auto seen = [&](bool shown, const Model& picture, const Vec3& at) {
        const Pose stage_from_screen = placed.stage_from_room * facingOperator(at);
        const Vec3 middle = stage_from_screen * Vec3(picture.middle_m);
        const glm::vec4 sphere(glm::vec3(middle), picture.radius_m);
        return shown && std::any_of(views.begin(), views.end(), [&](const View& view) {
                   const Vec3 to_eye = view.stage_from_eye.position_m - middle;
                   return glm::dot(to_eye, stage_from_screen.direction({0.0, 0.0, 1.0})) > 0.0 &&
                          touches(frustumPlanes(view), sphere);
               });
    };
    return {seen(scene.room.ultrasound, models_.ultrasound_screen, kUltrasound),
            seen(scene.room.xray_monitor, models_.xray_screen, kXrayMonitor),
            seen(scene.room.patient_monitor, models_.monitor_screen, kPatientMonitor)};
}

ScreenPlaces SceneMeshes::screenPlaces(const Placement& placed) const {
    const auto place = [&](const Model& picture, const Vec3& at) {
        const Vec3 right(picture.right_m), up(picture.up_m);
        const Vec3 x = glm::normalize(right), y = glm::normalize(up);
        const Pose model_from_screen{glm::quat_cast(glm::dmat3(x, y, glm::cross(x, y))),
                                     Vec3(picture.middle_m)};
        return ScreenPlace{placed.stage_from_room * facingOperator(at) * model_from_screen,
                           glm::length(right), glm::length(up)};
    };
    return {place(models_.ultrasound_screen, kUltrasound), place(models_.xray_screen, kXrayMonitor),
            place(models_.monitor_screen, kPatientMonitor)};
}

void SceneMeshes::addRoom(const RenderScene& scene, const Placement& placed) {
    const RoomContents& shown = scene.room;
    const glm::dmat4 stage_from_room = toMatrix(placed.stage_from_room);
    const auto at = [&](const Pose& pose) { return stage_from_room * toMatrix(pose); };
    if (shown.c_arm) {
        const CArmPoses arm = cArmPoses(scene, *shown.c_arm, placed);
        const double height = arm.stage_from_stand.position_m.y / kStandHeight_m;
        add(models_.stand, scaled(toMatrix(arm.stage_from_stand), Vec3(1.0, height, 1.0)), true);
        add(models_.carriage, toMatrix(arm.stage_from_carriage), true);
        add(models_.arc, toMatrix(arm.stage_from_arc), true);
        const Vec3 below = placed.stage_from_room.inverse() * arm.stage_from_stand.position_m;
        contacts_.emplace_back(float(below.x) - 1.45f, float(below.z), 0.30f, 0.28f);
        for (const float side : {-0.235f, 0.235f})
            contacts_.emplace_back(float(below.x) - 0.90f, float(below.z) + side, 0.34f, 0.03f);
    }
    if (shown.ultrasound) {
        addScreen(models_.ultrasound, models_.ultrasound_screen, at(facingOperator(kUltrasound)), 0);
        contacts_.emplace_back(float(kUltrasound.x), float(kUltrasound.z), 0.22f, 0.24f);
    }
    if (shown.xray_monitor) addScreen(models_.xray, models_.xray_screen, at(facingOperator(kXrayMonitor)), 1);
    if (shown.patient_monitor)
        addScreen(models_.monitor, models_.monitor_screen, at(facingOperator(kPatientMonitor)), 2);
    if (shown.trolley) {
        add(models_.trolley, at({{1.0, 0.0, 0.0, 0.0}, kTrolley}), true);
        contacts_.emplace_back(float(kTrolley.x), float(kTrolley.z), 0.34f, 0.19f);
    }
    if (shown.lamp) {
        add(models_.lamp_post,
            stage_from_room * scaled(toMatrix({{1.0, 0.0, 0.0, 0.0}, kLampPost}), Vec3(1.0, 0.42, 1.0)),
            false);
        addLampHead(placed, placed.lamp, kArmHeights_m[0], shown.lamp_lit);
        Lamp second = placed.lamp;
        const Vec3 stage = placed.stage_from_room * kSecondLamp;
        const Vec3 z = glm::normalize(stage - placed.stage_from_table.position_m);
        const Vec3 x = glm::normalize(glm::cross(Vec3(0.0, 1.0, 0.0), z));
        second.stage_from_head = {glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)), stage};
        addLampHead(placed, second, kArmHeights_m[1], shown.lamp_lit);
    }
    if (!shown.shell) return;
    const std::size_t first = draws_.size();
    add(models_.doors, stage_from_room, false);
    add(models_.built_in, stage_from_room, false);
    add(models_.lit_floor, stage_from_room, false, gpu::kFloor);
    add(models_.floor, stage_from_room, false, gpu::kFloor);
    add(models_.shell, stage_from_room, false);
    for (std::size_t i = first; i < draws_.size(); ++i)
        draws_[i].push.material.y = 1.0f;
}

void SceneMeshes::collectDraws(const RenderScene& scene, const Placement& placed, bool has_patient,
                               const Model* drape, const std::array<View, 2>& views, bool cull) {
    draws_.clear();
    spheres_.clear();
    contacts_.clear();
    if (has_patient) addTable(scene, placed);
    if (drape) add(*drape, toMatrix(scene.stage_from_patient), false, gpu::kCloth);
    addTools(scene);
    addGhost(scene);
    addPaths(scene);
    addHighlights(scene, placed);
    addRoom(scene, placed);
    const std::array pyramids{frustumPlanes(views[0]), frustumPlanes(views[1])};
    for (std::size_t i = 0; i < draws_.size(); ++i) {
        const glm::vec4& sphere = spheres_[i];
        const bool visible = !cull || touches(pyramids[0], sphere) || touches(pyramids[1], sphere);
        float nearest = kFarAway_m;
        for (const View& view : views)
            nearest =
                std::min(nearest, glm::length(glm::vec3(view.stage_from_eye.position_m) - glm::vec3(sphere)));
        // Walls surround the eye, so they are drawn after everything that may stand in front of them.
        const bool shell = draws_[i].first_index == models_.shell.first_index ||
                           draws_[i].first_index == models_.floor.first_index;
        const bool lit = scene.room.lamp_lit && isLit(placed.lamp, sphere) && !shell;
        draws_[i].lamp = !scene.room.lamp ? gpu::kFromAfar : lit ? gpu::kBeam : gpu::kUnlit;
        draws_[i].distance_m = !visible ? 2.0f * kFarAway_m : shell ? kFarAway_m : nearest - sphere.w;
        // The cloth is drawn first. It hides most of the table, whose bounding sphere is just as near.
        if (visible && draws_[i].kind == gpu::kCloth) draws_[i].distance_m = -kFarAway_m;
    }
    std::sort(draws_.begin(), draws_.end(),
              [](const MeshDraw& a, const MeshDraw& b) { return a.distance_m < b.distance_m; });
    visible_count_ =
        std::size_t(std::partition_point(draws_.begin(), draws_.end(),
                                         [](const MeshDraw& d) { return d.distance_m <= kFarAway_m; }) -
                    draws_.begin());
}

}  // namespace stylet::render
