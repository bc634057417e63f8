// Fits a motion model to the phases of a 4D CT.
// Based on Wilms et al. 2014: velocity fields of the registered phases, regressed at each node on a
// surrogate and its rate, in the log-Euclidean framework.
#pragma once

#include "app/modeller/motion/dome.h"
#include "patient/patient.h"

namespace stylet::modeller {

struct FitSettings {
    PhaseSettings phases;
    RegisterSettings registration;
    std::filesystem::path signal;  // CSV, one surrogate per phase; empty: from the lung's density
    double period_s = 4.0;         // breathing period, divided evenly by the phases; used without a signal
    double grid_m = 0.005;         // between nodes
    std::function<void(std::string_view)> progress = [](std::string_view) {};
};

// Predicted minus observed height of the dome, over the DomeColumns, in metres.
struct Residual {
    double mean_m = 0.0, mean_abs_m = 0.0, p95_m = 0.0, slice_mean_abs_m = 0.0;
};

struct PhaseReport {
    std::string name;
    patient::Surrogate surrogate;
    double dome_m = 0.0;       // mean height over the DomeColumns relative to the reference phase
    Residual no_motion;        // without any motion
    Residual fitted;           // for the model fitted to all phases
    Residual left_out;         // for a model fitted without this phase
    double log_error_m = 0.0;  // largest difference of exp(velocity field) from the displacement
};

struct FittedMotion {
    patient::MotionModel model;
    std::size_t reference = 0;  // the phase at end-exhale; its frame is the model's
    FloatVolume reference_hu;
    std::vector<PhaseReport> phases;
    Vec3 voxel_m{0.0};
    std::size_t columns = 0;  // number of DomeColumns
};

// Throws ImportError, DataError.
FittedMotion fitMotion(const FitSettings&);

// Reads one surrogate per phase: header "phase,v,rate_per_s", one line per phase in order. Throws
// DataError.
std::vector<patient::Surrogate> readPhaseSignal(const std::filesystem::path& csv, std::size_t phases);
std::vector<patient::Surrogate> parsePhaseSignal(std::string_view csv, const std::filesystem::path& file,
                                                 std::size_t phases);

// Converts lung densities to surrogates. v is 0 at the largest density (end-exhale) and 1 at the smallest
// (end-inhale). The rate is the slope of v; the last phase is followed by the first.
std::vector<patient::Surrogate> makeSurrogates(const std::vector<double>& densities, double period_s);

// Input of the fit from one phase: the velocities of both fields at every node.
struct NodeVelocities {
    std::vector<Vec3> wall_m, slide_m;
};
// Least-squares fit of a1 and a2 at every node over all phases except `left_out_phase` (pass the number of
// phases to use all). The reference phase has zero motion.
void regress(const std::vector<NodeVelocities>&, const std::vector<patient::Surrogate>&,
             std::size_t reference, std::size_t left_out_phase, patient::MotionModel&);

}  // namespace stylet::modeller
