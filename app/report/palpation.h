// Simulated palpation of a patient's right flank: the stiffness of every spot, and where the ribs are.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "haptics/tools/finger.h"

namespace stylet::report {

// The finger presses every spot along its normal up to a limit of force or depth, as in a search for a gap.
struct PalpationSettings {
    haptics::FingerSettings finger;
    double pitch_m = 0.004;  // between spots
    double force_n = 3.0, depth_m = 0.012;
    double speed_m_s = 0.05;
    bool breathing = false;  // the patient's own rhythm; false: held at end-exhale
    double dt_s = 0.001;
};

struct PalpatedSpot {
    bool on_skin = false;            // false: the image or the body ends here
    Vec3 reference_m{0.0};           // on the skin
    double stiffness_n_per_m = 0.0;  // force along the normal, divided by the depth of the finger's tip
    bool over_bone = false;          // within 40 mm along the normal
    double bone_share = 0.0;         // share of the spots within a pad's radius that are over bone
    double breath_v = 0.0;           // the breathing signal when it was pressed
};

// Rows from head to feet, columns from front to back: as seen from the right.
struct PalpationMap {
    int columns = 0, rows = 0;
    double pitch_m = 0.0;
    double front_m = 0.0, top_m = 0.0;  // y and z of the first spot
    std::vector<PalpatedSpot> spots;

    double pearson = 0.0;  // correlation of stiffness with over_bone (0 or 1), over all spots
    // Mean stiffness at the centres of ribs (most of the pad is over bone) and of gaps (none of it is).
    double rib_n_per_m = 0.0, gap_n_per_m = 0.0;
    double rib_over_gap_everywhere = 0.0;  // the same over all spots: mean over bone / mean beside it
    double ribOverGap() const { return gap_n_per_m > 0.0 ? rib_n_per_m / gap_n_per_m : 0.0; }
};

// The right flank at the height of the liver, between the axillary lines, seen from the right.
PalpationMap palpate(const patient::Patient&, const patient::Skin&, const haptics::TouchMap&,
                     const PalpationSettings&);

// Columns: y_m, z_m, x_m, stiffness_n_per_m, over_bone, bone_share, breath_v. Throws DataError, like
// drawPalpation().
void writePalpationCsv(const PalpationMap&, const std::filesystem::path&);
// Draws the stiffness next to the bones below it.
void drawPalpation(const PalpationMap&, const std::string& title, const std::filesystem::path& png);

}  // namespace stylet::report
