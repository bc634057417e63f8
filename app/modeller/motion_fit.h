// A motion model fitted to the phases of a 4D CT.
// Based on Wilms et al. 2014: velocity fields of the registered phases, regressed at each node on a surrogate
// and its rate, in the log-Euclidean frame.
#pragma once

#include "app/modeller/dome.h"
#include "patient/patient.h"

namespace stylet::modeller {

struct FitSettings {
    PhaseSettings phases;
    RegisterSettings registration;
    std::filesystem::path signal;  // CSV of the surrogate a phase; empty: from the lung away from the dome
    double period_s = 4.0;         // of the breath the phases divide evenly; without a signal
    double grid_m = 0.005;         // between nodes
    std::function<void(std::string_view)> progress = [](std::string_view) {};
};

// Where the dome is predicted less where it is seen, over the judged columns, in metres.
struct Residual {
    double mean_m = 0.0, mean_abs_m = 0.0, p95_m = 0.0, slice_mean_abs_m = 0.0;
};

struct PhaseReport {
    std::string name;
    patient::Surrogate surrogate;
    double dome_m = 0.0;       // seen height of the slice against the reference's, mean
    Residual still;            // were there no motion
    Residual fitted;           // by the model of all phases
    Residual left_out;         // by a model that never saw this phase
    double log_error_m = 0.0;  // of the velocity fields against their displacements
};

struct FittedMotion {
    patient::MotionModel model;
    std::size_t reference = 0;  // the phase at end-exhale: the frame
    FloatVolume reference_hu;
    std::vector<PhaseReport> phases;
    patient::Vec3 voxel_m{0.0};
    std::size_t columns = 0;  // judged
};

// Throws ImportError, patient::DataError.
FittedMotion fitMotion(const FitSettings&);

// Surrogates by phase: header "phase,v,rate_per_s", a line a phase in their order. Throws patient::DataError.
std::vector<patient::Surrogate> readPhaseSignal(const std::filesystem::path& csv, std::size_t phases);
std::vector<patient::Surrogate> parsePhaseSignal(std::string_view csv, const std::filesystem::path& file,
                                                 std::size_t phases);

// The surrogate that falls from end-exhale's value, the largest, to end-inhale's; its rate around the cycle.
std::vector<patient::Surrogate> surrogateFrom(const std::vector<double>& densities, double period_s);

// What the fit is of one phase: the velocities of both fields at every node.
struct NodeVelocities {
    std::vector<patient::Vec3> wall_m, slide_m;
};
// a1 and a2 at every node by least squares over the phases but `without` (or none: its number). The reference
// phase moves by nothing.
void regress(const std::vector<NodeVelocities>&, const std::vector<patient::Surrogate>&,
             std::size_t reference, std::size_t without, patient::MotionModel&);

}  // namespace stylet::modeller
