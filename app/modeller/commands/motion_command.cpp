#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <memory>

#include "app/modeller/check/check_package.h"
#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "app/modeller/import/import.h"
#include "app/modeller/motion/motion_fit.h"
#include "app/options.h"
#include "app/print.h"

namespace stylet::modeller {

namespace {

struct MotionOptions {
    FitSettings fit;
    bool from_template = false;
    std::filesystem::path package, out;
    std::string reference_phase;
    double dome_mm = 15.0, anterior_mm = 5.0, lateral_mm = 2.5, rib_mm = 2.0, belly_mm = 5.0;
};

// Prints the error of the fitted diaphragm height for each breathing phase: the mean over the columns
// selected by selectDomeColumns(), in voxels and in millimetres.
void printTable(const FittedMotion& fitted) {
    const double voxel_m = fitted.voxel_m.z;
    printResult("{} columns of the dome, voxels of {:.2f} mm; mean |residual| in voxels (mm):\n",
                fitted.columns, voxel_m * 1e3);
    printResult("{:<14} {:>6} {:>7} {:>8}   {:<13} {:<13} {:<13} {:<15} {:>6}\n", "phase", "v", "v' [/s]",
                "dome mm", "no motion", "fitted", "left out", "left out, slice", "p95 mm");
    const auto cell = [&](double m) { return fmt::format("{:.2f} ({:.2f})", m / voxel_m, m * 1e3); };
    for (std::size_t p = 0; p < fitted.phases.size(); ++p) {
        const PhaseReport& r = fitted.phases[p];
        printResult("{:<14} {:6.3f} {:7.3f} {:8.2f}   ", r.name, r.surrogate.v, r.surrogate.rate_per_s,
                    r.dome_m * 1e3);
        if (p == fitted.reference)
            printResult("the frame of the model\n");
        else
            printResult("{:<13} {:<13} {:<13} {:<15} {:6.2f}\n", cell(r.no_motion.mean_abs_m),
                        cell(r.fitted.mean_abs_m), cell(r.left_out.mean_abs_m),
                        cell(r.left_out.slice_mean_abs_m), r.left_out.p95_m * 1e3);
    }
}

void printInterface(const patient::MotionModel& model) {
    const patient::InterfaceError e = worstInterface(model);
    printResult(
        "over v = {:.2f} to {:.2f}: the sides slip by {:.1f} mm (most {:.1f}); gaps up to {:.2f}, overlaps "
        "up "
        "to {:.2f} mm; least Jacobian {:.2f}, at three times life {:.2f}\n",
        model.v.low, model.v.high, e.mean_slip_m * 1e3, e.max_slip_m * 1e3, e.worst_gap_m * 1e3,
        e.worst_overlap_m * 1e3, minJacobian(model, 1.0), minJacobian(model, 3.0));
}

// Makes a package from the CT of the reference phase, with no voxel labelled. It is used to draw pictures of
// the motion.
patient::Package makePackage(const FittedMotion& fitted) {
    patient::Package p;
    p.name = "4D CT, " + fitted.phases[fitted.reference].name;
    p.licence = "that of the 4D CT";
    p.provenance = "stylet-model motion --phases";
    p.ct = CtVolume(fitted.reference_hu.grid);
    for (std::size_t i = 0; i < p.ct.voxels.size(); ++i)
        p.ct.voxels[i] =
            std::int16_t(std::lround(std::clamp(fitted.reference_hu.voxels[i], -1024.0f, 3071.0f)));
    p.labels = LabelVolume(p.ct.grid);
    const patient::TissueDefaults defaults = tissueDefaults();
    p.tissues = defaults.tissues;
    p.elasticity = defaults.elasticity;
    p.thresholds = defaults.thresholds;
    return p;
}

// Refuses a package whose CT overlaps the 4D CT's reference phase by less than 50 mm along any axis. Such a
// package lies elsewhere than the images to which the motion was fitted.
void checkOverlap(const MotionOptions& o, const patient::Package& p, const FloatVolume& phase) {
    for (int d = 0; d < 3; ++d) {
        const double low_m = std::max(p.ct.grid.origin_m[d], phase.grid.origin_m[d]);
        const double high_m =
            std::min(p.ct.grid.centre(p.ct.grid.dims - 1)[d], phase.grid.centre(phase.grid.dims - 1)[d]);
        if (high_m - low_m < 0.05)
            throw DataError(o.package, "grid",
                            "lies elsewhere than the phases of " + o.fit.phases.folder.string());
    }
}

void requireAccepted(const patient::Package& p, const std::filesystem::path& out) {
    if (printVerdict(p, out, checkPackage(p))) return;
    printResult("The patient cannot be simulated yet. Correct the segmentation, and add the motion again.\n");
    throw CLI::RuntimeError(1);
}

void runFit(MotionOptions& o) {
    const auto reportProgress = timedProgress();
    o.fit.progress = o.fit.phases.progress = reportProgress;
    patient::Package p = o.package.empty() ? patient::Package{} : patient::loadPackage(o.package);
    const FittedMotion fitted = fitMotion(o.fit);
    if (o.package.empty())
        p = makePackage(fitted);
    else
        checkOverlap(o, p, fitted.reference_hu);
    p.motion = fitted.model;
    const double v = fitted.model.reference.v;
    p.reference_phase = v == 0.0 ? "exhale" : fmt::format("v={:.17g}", v);
    patient::savePackage(p, o.out);
    printTable(fitted);
    printInterface(p.motion);
    reportProgress("done");
    if (!o.package.empty()) requireAccepted(p, o.out);  // no patient otherwise
}

void runTemplate(const MotionOptions& o) {
    if (o.package.empty()) throw CLI::RequiredError("--package");
    patient::Package p = patient::loadPackage(o.package);
    if (!o.reference_phase.empty()) p.reference_phase = o.reference_phase;
    patient::MotionAmplitudes a;
    a.dome_m = 1e-3 * o.dome_mm, a.anterior_m = 1e-3 * o.anterior_mm, a.lateral_m = 1e-3 * o.lateral_mm;
    a.rib_m = 1e-3 * o.rib_mm, a.belly_m = 1e-3 * o.belly_mm;
    p.motion =
        patient::motionTemplate(p.labels, p.label_table, a, {parseReferencePhase(p.reference_phase), 0.0});
    if (p.motion.empty()) throw DataError(o.package, "label", "none is liver: no template fits");
    patient::savePackage(p, o.out);
    const Index3 d = p.motion.grid.dims;
    printResult("{}: {} x {} x {} nodes, reference {}, dome {:.1f} mm\n", o.out.string(), d.x, d.y, d.z,
                p.reference_phase, o.dome_mm);
    printInterface(p.motion);
    requireAccepted(p, o.out);
}

void addAmplitudes(CLI::App& command, MotionOptions& o) {
    const auto add = [&](const char* name, double& mm, double max_mm, const char* what) {
        command.add_option(name, mm, what)->check(inRange(0.0, max_mm))->capture_default_str();
    };
    add("--dome-mm", o.dome_mm, 25.0,
        "Template: motion of dome and liver toward the feet, end-exhale to end-inhale [mm].");
    add("--anterior-mm", o.anterior_mm, 15.0, "Template: motion of dome and liver to the front [mm].");
    add("--lateral-mm", o.lateral_mm, 10.0, "Template: motion of dome and liver to the left [mm].");
    add("--rib-mm", o.rib_mm, 6.0, "Template: outward motion of the ribs [mm].");
    add("--belly-mm", o.belly_mm, 15.0, "Template: motion of the abdominal wall to the front [mm].");
}

}  // namespace

void addMotion(CLI::App& app) {
    const auto options = std::make_shared<MotionOptions>();
    MotionOptions& o = *options;
    CLI::App* command = app.add_subcommand(
        "motion", "Add breathing motion to a patient: fitted to a 4D CT, or from a template.");
    auto* phases = command->add_option("--phases", o.fit.phases.folder,
                                       "Fit: 4D CT, one file or folder for each phase.");
    command->add_flag("--template", o.from_template, "Scale a template to the labels of --package.")
        ->excludes(phases);
    command->add_option("--package", o.package,
                        "Patient package (default: the end-exhale phase of the 4D CT).");
    command->add_option("--out", o.out, "Folder for the new package.")->required();
    command->add_option("--signal", o.fit.signal,
                        "Fit: CSV file phase,v,rate_per_s (default: estimated from the lung's density).");
    command
        ->add_option("--spacing-mm", o.fit.phases.spacing_mm, "Fit: voxel size [mm], if the files name none.")
        ->check(inRange(0.1, 10.0));
    command
        ->add_option("--period-s", o.fit.period_s, "Fit: duration of the breath that the phases divide [s].")
        ->check(inRange(1.0, 20.0))
        ->capture_default_str();
    command
        ->add_option("--finest", o.fit.registration.finest,
                     "Fit: voxels merged per side on the finest level.")
        ->check(CLI::IsMember({1, 2, 4}))
        ->capture_default_str();
    command->add_option("--reference-phase", o.reference_phase,
                        "Template: breathing phase to use instead of the package's own.");
    addAmplitudes(*command, o);
    command->callback([options] {
        if (!options->from_template && options->fit.phases.folder.empty())
            throw CLI::RequiredError("--phases or --template");
        checkOut(options->out, {options->package, options->fit.phases.folder, options->fit.signal});
        options->from_template ? runTemplate(*options) : runFit(*options);
    });
}

}  // namespace stylet::modeller
