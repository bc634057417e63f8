// Reference paths: straight lines from the skin to a bile duct's centre line, rated by four criteria. C1: the
// path crosses no risk structure. C2: it is short enough. C3: its clearance to risk structures. C4: the chord
// of the duct along it. Source: Mastmeyer et al. 2017, Eq. 9, after Baegert et al. 2007.
//
// In a built patient the border of a risk structure is uncertain. C1 therefore keeps a margin: the path
// passes at least Label::border_uncertainty_m from the label, and from what may contain a risk structure
// (Role::suspect). A vessel runs beside every duct, so on the last PlanSettings::near_target_m before the
// duct's wall the margin is 2 mm at most. The margin changes neither the scores nor Q. Distances are measured
// between voxels, so they may be short by half a voxel's diagonal.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "base/needle_shape.h"
#include "patient/package/package.h"

namespace stylet::patient {

struct PlanSettings {
    Surrogate breath;  // breathing state (held) in which the path is straight, and for which it is rated
    double skin_spacing_m = 0.008;    // spacing of the skin voxels to try; 0: all
    double target_spacing_m = 0.004;  // minimum distance between targets on the centre line; 0: all
    double max_length_m = 0.090;      // for C2
    // Length of the needle, which lies in free air before the tip touches the skin. Stored paths are planned
    // for the default needle.
    double needle_length_m = NeedleShape().length_m;
    double min_quality = 0.4;
    // C3 ignores risk structures on the last stretch of this length before the duct's wall. C1 does not.
    double near_target_m = 0.010;
    // Skips pairs that cannot become the best path of their skin voxel; the resulting paths are the same.
    // Has no effect if `breath` is not the CT's: the bounds need paths that are straight in the CT too.
    bool skip = true;
    int threads = 2;
};

// The study's settings: all skin voxels of the access area and all voxels of the duct's centre line, in the
// breathing state of the CT.
PlanSettings studyPlanSettings(const Patient&);

struct PlannedPath {
    Vec3 entry_m{0.0}, target_m{0.0};                      // end points in the deformed patient at `breath`
    Vec3 entry_reference_m{0.0}, target_reference_m{0.0};  // the same points in the reference
    Surrogate breath;
    double length_m = 0.0;
    double clearance_score = 0.0;  // C3 in [0, 1]
    double target_score = 0.0;     // C4 in [0, 1]
    double quality = 0.0;          // (C3 + C4) / 2
    friend bool operator==(const PlannedPath&, const PlannedPath&) = default;
};

// Increase it whenever planPaths() finds other paths of the same patient or rates them differently. Stored
// paths of another version are stale.
inline constexpr int kPlannerVersion = 4;

struct PlanResult {
    std::vector<PlannedPath> paths;  // best path of each skin voxel, sorted best first
    std::size_t candidates = 0, skipped = 0, rejected_blocked = 0, rejected_long = 0, rejected_quality = 0;
};

// Tries all pairs of a skin voxel in the access area (right flank, between the axillary lines, at liver
// height) and a voxel of the duct's centre line. A path must pass between two ribs and leave room for the
// hand above the table. See patient/README.md.
PlanResult planPaths(const Patient&, const PlanSettings&,
                     const std::function<void(double fraction)>& progress = {});

// Computes length, scores and quality of a path whose ends and breath are set. Returns false if the planner
// would reject the path; values not computed by then are 0.
bool ratePath(const Patient&, const PlanSettings&, PlannedPath&);

// Worst quality of each path over several breathing states. The ends move with the tissue. The quality is 0
// if the planner would reject the path in one of the states.
std::vector<double> worstQualities(const Patient&, const PlanSettings&, const std::vector<PlannedPath>&,
                                   const std::vector<Surrogate>& breaths);

inline constexpr std::size_t kMaxStoredPaths = 100'000;
// Contents of paths.json: the paths, and the patient and planner version they belong to.
struct StoredPaths {
    std::uint64_t patient_digest = 0;  // digest(Package)
    int planner_version = 0;
    std::vector<PlannedPath> paths;
};

void savePaths(const StoredPaths&, const std::filesystem::path& json);
StoredPaths loadPaths(const std::filesystem::path& json);  // throws DataError

}  // namespace stylet::patient
