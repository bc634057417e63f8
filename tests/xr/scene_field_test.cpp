// The disinfected field with the drape's opening, the patient's place in the room and the C-arm.
#include <gtest/gtest.h>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/view/scene.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

// An exam that becomes easier while it runs must not move the room: a registered device stands in it.
TEST(SceneField, EverythingIsArrangedAroundTheFieldThatItWasGiven) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const patient::PlannedPath path = test::ductPath();
    for (const OperativeField& field : {fieldOf(path), flankField(patient)}) {
        SceneMaker scenes(patient, path, field, render::Look::closed, {},
                          test::difficulties()[training::Difficulty::exam]);
        for (const auto difficulty : {training::Difficulty::exam, training::Difficulty::guided}) {
            scenes.help(test::difficulties()[difficulty]);
            FrameState seen;
            seen.equipment.xray.pulses = 1;
            const render::RenderScene scene = scenes.makeScene(seen);
            EXPECT_EQ(scene.marks.at(0).reference_m, field.entry_reference_m);
            EXPECT_EQ(scene.field_m.value(), field.entry_reference_m);
            EXPECT_EQ(scene.room.c_arm.value().isocentre_m, field.isocentre_m);
            EXPECT_EQ(scene.stage_from_patient.position_m, stageFromPatient(patient, field).position_m);
        }
    }
}

}  // namespace
}  // namespace stylet::trainer
