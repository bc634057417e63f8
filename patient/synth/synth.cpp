#include "patient/synth/synth.h"

#include "patient/motion/motion_template.h"
#include "patient/synth/ct.h"
#include "patient/synth/painters.h"
#include "patient/synth/variants/variant.h"

namespace stylet::patient::synth {

namespace {

// The section extends from above the dome of the diaphragm to below the kidneys.
constexpr double kSize_m[] = {0.344, 0.250, 0.290};
constexpr double kLow_m[] = {-0.172, -0.128, -0.118};

Grid sectionGrid(double spacing_m, const Vec3& scale) {
    Grid grid;
    grid.spacing_m = Vec3(spacing_m);
    for (int k = 0; k < 3; ++k) {
        grid.dims[k] = int(std::floor(kSize_m[k] * scale[k] / spacing_m + 0.5));
        grid.origin_m[k] = kLow_m[k] * scale[k] + 0.5 * spacing_m;
    }
    return grid;
}

// Paints the healthy organs.
HepaticTrees paintBody(Canvas& canvas, const Anatomy& a,
                       const std::function<void(std::string_view, double)>& report) {
    report("trees", 0.02);
    HepaticTrees trees = growHepaticTrees(a);
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
    return trees;
}

std::string variantNames(const std::vector<const Variant*>& variants) {
    std::string names;
    for (const Variant* v : variants)
        names += (names.empty() ? "" : ",") + std::string(v->name);
    return names;
}

}  // namespace

Package makeReferencePatient(const SynthSettings& settings) {
    const auto report = [&](std::string_view stage, double fraction) {
        if (settings.progress) settings.progress(stage, fraction);
    };
    report("plan", 0.0);
    const std::vector<const Variant*> variants = findVariants(settings.variants);
    PatientPlan plan{drawAnatomy(settings.seed), Vec3(1.0), {}};
    for (const Variant* v : variants)
        if (v->plan) v->plan(plan);
    const Anatomy& a = plan.anatomy;
    Canvas canvas(sectionGrid(settings.spacing_m, plan.section), a.scale, std::max(1, settings.threads));
    const HepaticTrees trees = paintBody(canvas, a, report);
    CtSettings ct_settings = ctSettings(plan.scanner);
    Painting painting{canvas, a, trees, ct_settings.inclusions};
    for (const Variant* v : variants)
        if (v->paint) v->paint(painting);
    report("CT", 0.78);

    Package package;
    package.name = "reference patient, seed " + std::to_string(settings.seed);
    package.licence = "CC0-1.0";
    package.provenance = "synthetic: made by stylet-model synth --seed " + std::to_string(settings.seed);
    if (!variants.empty()) {
        package.name += ", " + variantNames(variants);
        package.provenance += " --variant " + variantNames(variants);
    }
    package.ct = makeCt(canvas, a.seed, ct_settings);
    if (plan.scanner.slice_m > settings.spacing_m) thickenSlices(package.ct, plan.scanner.slice_m);
    package.labels = std::move(canvas.labels);
    package.label_table = labelTable();
    package.tissues = settings.defaults.tissues;
    package.elasticity = settings.defaults.elasticity;
    package.thresholds = settings.defaults.thresholds;
    package.reference_phase = "exhale";
    report("breath", 0.9);
    if (settings.motion)
        package.motion = motionTemplate(package.labels, package.label_table, {}, {0.0, 0.0}, canvas.threads);
    for (const Variant* v : variants)
        if (v->finish) v->finish(package);
    report("done", 1.0);
    return package;
}

}  // namespace stylet::patient::synth
