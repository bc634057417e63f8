#include "app/report/palpation.h"

#include <gtest/gtest.h>

#include "patient/synth/synth.h"
#include "tests/support/phantom.h"
#include "tests/support/temp_folder.h"

namespace stylet::report {
namespace {

// The reference patient at 2 mm, to save time.
struct Flank {
    static patient::Package made() {
        patient::synth::SynthSettings s;
        s.spacing_m = 0.002;
        s.defaults = test::tissueDefaults();
        return patient::synth::makeReferencePatient(s);
    }
    PalpationMap palpated(double pitch_m, bool breathing) const {
        PalpationSettings settings;
        settings.pitch_m = pitch_m;
        settings.breathing = breathing;
        return palpate(patient, skin, touch, settings);
    }
    const patient::Package package = made();
    const patient::Patient patient{package};
    const patient::Skin skin = makeSkin(patient, 2);
    const haptics::TouchMap touch = haptics::makeTouchMap(patient, skin, 2);
};

const Flank& flank() {
    static const Flank shared;
    return shared;
}

TEST(Palpation, RibsAreStifferThanGaps) {
    for (const bool breathing : {false, true}) {
        const PalpationMap map = flank().palpated(0.004, breathing);
        EXPECT_GT(map.columns, 20);
        EXPECT_GT(map.rows, 40);
        EXPECT_GE(map.pearson, 0.7) << breathing;
        EXPECT_GE(map.ribOverGap(), 3.0) << breathing;
        EXPECT_GE(map.rib_over_gap_everywhere, 2.0) << breathing;
        // The range of stiffness in which a hand distinguishes rib and gap without discomfort.
        EXPECT_GT(map.gap_n_per_m, 20.0);
        EXPECT_LT(map.rib_n_per_m, 1000.0);
    }
}

TEST(Palpation, IsWrittenAndDrawn) {
    const test::TempFolder temp;
    const PalpationMap map = flank().palpated(0.012, false);
    drawPalpation(map, "a patient", temp / "a.png");
    writePalpationCsv(map, temp / "a.csv");
    EXPECT_GT(std::filesystem::file_size(temp / "a.png"), 5000u);
    EXPECT_GT(std::filesystem::file_size(temp / "a.csv"), 40 * map.spots.size());
    EXPECT_THROW(writePalpationCsv(map, temp / "no" / "a.csv"), DataError);
}

}  // namespace
}  // namespace stylet::report
