// The disinfected field with the drape's opening. In an exam it must not show where the planned path enters.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/view/scene.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

// HZ-TEACH-24
TEST(SceneField, IsAtTheEntryExceptInAnExam) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    patient::PlannedPath here = test::ductPath(), there = here;
    there.entry_m.z += 0.010, there.entry_reference_m.z += 0.010;
    const auto fieldOf = [&](const patient::PlannedPath& path, training::Difficulty difficulty) {
        SceneMaker scenes(patient, path, render::Look::closed, {}, test::difficulties()[difficulty]);
        const render::RenderScene scene = scenes.makeScene({});
        EXPECT_EQ(scene.marks.at(0).reference_m, scene.field_m.value());
        return *scene.field_m;
    };
    for (const auto difficulty : {training::Difficulty::guided, training::Difficulty::practice}) {
        EXPECT_EQ(fieldOf(here, difficulty), here.entry_reference_m);
        EXPECT_EQ(fieldOf(there, difficulty), there.entry_reference_m);
    }
    EXPECT_EQ(fieldOf(here, training::Difficulty::exam), fieldOf(there, training::Difficulty::exam));
    EXPECT_EQ(fieldOf(here, training::Difficulty::exam), flankMiddle(patient));
}

}  // namespace
}  // namespace stylet::trainer
