#include "patient/synth/synth.h"

#include "patient/synth/ct.h"
#include "patient/synth/painters.h"

namespace stylet::patient::synth {

namespace {

// The section: from above the dome of the diaphragm to below the kidneys.
constexpr double kSize_m[] = {0.344, 0.250, 0.290};
constexpr double kLow_m[] = {-0.172, -0.128, -0.118};

Grid sectionGrid(double spacing_m) {
    Grid grid;
    grid.spacing_m = Vec3(spacing_m);
    for (int k = 0; k < 3; ++k) {
        grid.dims[k] = int(std::floor(kSize_m[k] / spacing_m + 0.5));
        grid.origin_m[k] = kLow_m[k] + 0.5 * spacing_m;
    }
    return grid;
}

// Liver, diaphragm and what lies next to them slide along the inside of the ribs; the wall stays.
BreathingModel breathingModel(const Anatomy& a) {
    BreathingModel b;
    b.a1_m = -0.015;
    b.a2_m_s = -0.001;
    b.z_low_m = kLow_m[2];
    b.z_full_low_m = -0.050 * a.scale.z;
    b.z_full_high_m = (a.dome_right_mm - 4.0) * 0.001 * a.scale.z;
    b.z_high_m = kLow_m[2] + kSize_m[2];
    for (double z_m = b.z_low_m; z_m < b.z_high_m + 0.005; z_m += 0.010) {
        const CageSection c = a.cage(z_m * 1000.0 / a.scale.z);
        const double inset_mm = 1.0;
        b.cavity.push_back({z_m, c.xc * 0.001 * a.scale.x, c.yc * 0.001 * a.scale.y,
                            (c.a - inset_mm) * 0.001 * a.scale.x, (c.b - inset_mm) * 0.001 * a.scale.y});
    }
    return b;
}

}  // namespace

Package makeReferencePatient(const SynthSettings& settings) {
    const auto report = [&](std::string_view stage, double fraction) {
        if (settings.progress) settings.progress(stage, fraction);
    };
    report("plan", 0.0);
    const Anatomy a = drawAnatomy(settings.seed);
    Canvas canvas(sectionGrid(settings.spacing_m), a.scale, std::max(1, settings.threads));
    report("trees", 0.02);
    const HepaticTrees trees = growHepaticTrees(a);
    report("body wall", 0.15);
    paintWall(canvas, a);
    paintFascia(canvas);
    report("skeleton", 0.35);
    paintSpine(canvas, a);
    paintRibs(canvas, a);
    report("thorax", 0.42);
    paintThorax(canvas, a);
    paintGreatVessels(canvas, a);
    report("liver", 0.52);
    paintLiver(canvas, a);
    paintTrees(canvas, trees);
    report("organs", 0.6);
    paintSolidOrgans(canvas, a);
    paintBowel(canvas, a);
    report("islands", 0.7);
    removeIslands(canvas);
    report("CT", 0.78);

    Package package;
    package.name = "reference patient, seed " + std::to_string(settings.seed);
    package.licence = "CC0-1.0";
    package.provenance = "synthetic: made by stylet-model synth --seed " + std::to_string(settings.seed);
    package.ct = makeCt(canvas, a.seed);
    package.labels = std::move(canvas.labels);
    package.label_table = labelTable();
    package.tissues = settings.defaults.tissues;
    package.thresholds = settings.defaults.thresholds;
    package.reference_phase = "exhale";
    package.breathing = breathingModel(a);
    report("done", 1.0);
    return package;
}

}  // namespace stylet::patient::synth
