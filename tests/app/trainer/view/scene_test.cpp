// What a difficulty shows in the room, and that neither the look nor a change of difficulty brings back what
// it hides.
#include "app/trainer/view/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <glm/geometric.hpp>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/attempt/tool_pose.h"
#include "render/room/mesh.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/training/wall.h"

namespace stylet::trainer {
namespace {

using training::Difficulty;

class SceneTest : public testing::Test {
  protected:
    SceneMaker maker(Difficulty difficulty, render::Look look) const {
        const patient::PlannedPath path = test::wallPath();
        return {patient_, path, fieldOf(path), look, {}, test::difficulties()[difficulty]};
    }
    // A finger before the entry: the prompt is to press there.
    static FrameState palpating() {
        FrameState seen;
        seen.tick.tool = haptics::Tool::finger;
        seen.tick.tool_awaits_exit = false;
        seen.tick.patient_from_tool = needlePose({-0.03, 0.0, 0.0}, {1.0, 0.0, 0.0});
        return seen;
    }
    const patient::Package package_ = test::wallWithVessel();
    const patient::Patient patient_{package_};
};

// HZ-TEACH-12
TEST_F(SceneTest, OnlyAGuidedAttemptMarksThePlaceOfThePrompt) {
    for (const render::Look look : {render::Look::closed, render::Look::reveal}) {
        EXPECT_FALSE(maker(Difficulty::guided, look).makeScene(palpating()).highlights.empty());
        EXPECT_TRUE(maker(Difficulty::practice, look).makeScene(palpating()).highlights.empty());
        EXPECT_TRUE(maker(Difficulty::exam, look).makeScene(palpating()).highlights.empty());
        SceneMaker changed = maker(Difficulty::guided, look);
        changed.help(test::difficulties()[Difficulty::exam]);
        EXPECT_TRUE(changed.makeScene(palpating()).highlights.empty());
        EXPECT_EQ(changed.makeScene(palpating()).look, render::Look::closed);
    }
}

TEST_F(SceneTest, LightsOutSwitchesTheLampsOffAndDimsTheRoom) {
    SceneMaker scenes = maker(Difficulty::exam, render::Look::closed);
    FrameState seen = palpating();
    const render::RenderScene lit = scenes.makeScene(seen);
    seen.lights_out = true;
    const render::RenderScene dark = scenes.makeScene(seen);
    EXPECT_TRUE(lit.room.lamp && lit.room.lamp_lit && dark.room.lamp);
    EXPECT_FALSE(dark.room.lamp_lit);
    EXPECT_LT(dark.room.shell_light.x, 0.5 * lit.room.shell_light.x);
}

TEST_F(SceneTest, TheExpertsToolIsAGhostOfItsKind) {
    SceneMaker scenes = maker(Difficulty::guided, render::Look::closed);
    EXPECT_FALSE(scenes.makeScene(palpating()).ghost);
    for (const auto& [tool, kind] : {std::pair{haptics::Tool::finger, render::GhostKind::finger},
                                     {haptics::Tool::probe, render::GhostKind::probe},
                                     {haptics::Tool::scalpel, render::GhostKind::scalpel},
                                     {haptics::Tool::needle, render::GhostKind::needle}}) {
        FrameState seen = palpating();
        seen.ghost_tool = {tool, needlePose({-0.02, 0.01, 0.0}, {1.0, 0.0, 0.0}), 0.15};
        const render::RenderScene scene = scenes.makeScene(seen);
        ASSERT_TRUE(scene.ghost);
        EXPECT_EQ(scene.ghost->kind, kind);
        EXPECT_EQ(scene.ghost->patient_from_tool.position_m, Vec3(-0.02, 0.01, 0.0));
        EXPECT_EQ(scene.paths.size(), kind == render::GhostKind::needle ? 1u : 0u);
        EXPECT_TRUE(scene.patient_from_finger) << "the trainee's own tool stays";
    }
}

// The drawn channel of either probe lies around the line on which the guide holds the needle.
TEST_F(SceneTest, TheNeedleRunsThroughTheProbesGuide) {
    const render::Mesh mesh =
        render::loadMesh(std::filesystem::path(std::getenv("STYLET_ASSETS")) / "instruments" / "probe.glb");
    const Pose rail = haptics::kStylusFromProbe * haptics::GuideSettings{}.probe_from_guide;
    for (const char* node : {"probe", "linear_probe"}) {
        double top_m = 0.0;
        Vec3 sum(0.0);
        int count = 0;
        for (const render::MeshPart& part : mesh.parts)
            for (std::uint32_t i = 0; part.node == node && part.name == "guide" && i < part.index_count;
                 ++i) {
                const Vec3 p =
                    rail.inverse() * Vec3(mesh.vertices[mesh.indices[part.first_index + i]].position_m);
                if (p.z > top_m + 1e-4) top_m = p.z, sum = Vec3(0.0), count = 0;
                if (p.z > top_m - 1e-4) sum += p, ++count;
            }
        ASSERT_GT(count, 0) << node;
        EXPECT_LT(std::hypot(sum.x, sum.y) / count, 0.0005) << node;
        EXPECT_LT(top_m, haptics::GuideSettings{}.length_m) << node;
    }
}

TEST_F(SceneTest, TheLinearProbeIsDrawnFlat) {
    SceneMaker scenes = maker(Difficulty::guided, render::Look::closed);
    FrameState seen = palpating();
    EXPECT_FALSE(scenes.makeScene(seen).flat_probe);
    seen.probe = {.transducer = "linear", .length_m = 0.040, .curvature_m = 10.0};
    EXPECT_TRUE(scenes.makeScene(seen).flat_probe);
}

// In an exam the C-arm stands over the liver's middle, from where a target can lie outside its picture.
TEST_F(SceneTest, TheCArmIsMovedOverTheNeedle) {
    const OperativeField field = flankField(patient_);
    render::RenderScene scene;
    training::XrayState xray{.pedal = true, .pulses = 1};
    addRoom(scene, field, xray);
    EXPECT_EQ(scene.room.c_arm->isocentre_m, field.isocentre_m);
    for (const double x_m : {0.02, 0.09}) {
        xray.aimed_m = Vec3(x_m, 0.01, 0.05);
        addRoom(scene, field, xray);
        EXPECT_EQ(scene.room.c_arm->isocentre_m, isocentreFor(*xray.aimed_m));
    }
    EXPECT_LT(glm::distance(isocentreFor(Vec3(0.0)), Vec3(0.0)), 0.05) << "half a picture is 0.1 m";
}

// The expert's wire lies in the patient as a ghost, and in no X-ray picture.
TEST_F(SceneTest, TheExpertsWireIsAGhostOnItsTrack) {
    SceneMaker scenes = maker(Difficulty::guided, render::Look::closed);
    FrameState seen = palpating();
    seen.ghost_tool = {haptics::Tool::wire, {}, 0.15, haptics::AccessOutput{}};
    haptics::AccessOutput& access = *seen.ghost_tool->access;
    access.open = access.wire_in = true;
    access.base_m = {0.05, 0.0, 0.0};
    access.wire_m = 0.01, access.node_count = 1;
    access.nodes_m[0] = {0.06f, 0.0f, 0.0f};
    const render::RenderScene scene = scenes.makeScene(seen);
    EXPECT_FALSE(scene.ghost);
    EXPECT_TRUE(scene.tubes.empty());
    ASSERT_EQ(scene.ghost_tubes.size(), 1u);
    EXPECT_NEAR(scene.ghost_tubes[0].points_m.back().x, 0.06, 1e-6);
    seen.ghost_tool.reset();
    EXPECT_TRUE(scenes.makeScene(seen).ghost_tubes.empty());
}

}  // namespace
}  // namespace stylet::trainer
