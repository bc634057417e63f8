#include <chrono>
#include <cstdio>
#include <memory>

#include "app/modeller/commands.h"
#include "app/modeller/motion_fit.h"
#include "patient/motion_io.h"
#include "patient/package.h"

namespace stylet::modeller {

namespace {

struct Options {
    FitSettings fit;
    std::filesystem::path out;
};

void printTable(const FittedMotion& fitted) {
    const double voxel_m = fitted.voxel_m.z;
    std::printf("%zu columns of the dome, voxels of %.2f mm; mean |residual| in voxels (mm)\n",
                fitted.columns, voxel_m * 1e3);
    std::printf("%-16s %6s %7s %8s | %-14s %-14s %-14s %-14s %8s\n", "phase", "v", "v' 1/s", "dome mm",
                "still", "fitted", "left out", "left out, slice", "p95 mm");
    const auto cell = [&](double m) {
        char text[32];
        std::snprintf(text, sizeof text, "%.2f (%.2f)", m / voxel_m, m * 1e3);
        return std::string(text);
    };
    for (std::size_t p = 0; p < fitted.phases.size(); ++p) {
        const PhaseReport& r = fitted.phases[p];
        std::printf("%-16s %6.3f %7.3f %8.2f | ", r.name.c_str(), r.surrogate.v, r.surrogate.rate_per_s,
                    r.dome_m * 1e3);
        if (p == fitted.reference)
            std::printf("the frame of the model\n");
        else
            std::printf("%-14s %-14s %-14s %-15s %8.2f\n", cell(r.still.mean_abs_m).c_str(),
                        cell(r.fitted.mean_abs_m).c_str(), cell(r.left_out.mean_abs_m).c_str(),
                        cell(r.left_out.slice_mean_abs_m).c_str(), r.left_out.p95_m * 1e3);
    }
}

void runMotion(Options& o) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    o.fit.progress = o.fit.phases.progress = [&](std::string_view stage) {
        std::fprintf(stderr, "%6.1f s  %.*s\n", std::chrono::duration<double>(Clock::now() - start).count(),
                     int(stage.size()), stage.data());
    };
    const FittedMotion fitted = fitMotion(o.fit);
    printTable(fitted);
    std::filesystem::create_directories(o.out);
    patient::writeMotion(o.out / "motion.nii.gz", fitted.model);
    o.fit.progress("done");
}

}  // namespace

void addMotion(CLI::App& app) {
    const auto options = std::make_shared<Options>();
    Options& o = *options;
    CLI::App* command = app.add_subcommand("motion", "fit the motion of a breath");
    command->add_option("--phases", o.fit.phases.folder, "4D CT: a file or folder a phase")->required();
    command->add_option("--signal", o.fit.signal,
                        "CSV phase,v,rate_per_s; without: from the lung away from the dome");
    command->add_option("--spacing-mm", o.fit.phases.spacing_mm, "voxel size, where the files name none");
    command->add_option("--period-s", o.fit.period_s, "of the breath that the phases divide")
        ->capture_default_str();
    command->add_option("--finest", o.fit.registration.finest, "voxels merged a side on the finest level")
        ->check(CLI::IsMember({1, 2, 4}))
        ->capture_default_str();
    command->add_option("--out", o.out, "folder for motion.nii.gz")->required();
    command->callback([options] { runMotion(*options); });
}

}  // namespace stylet::modeller
