#include "patient/synth/variants/variant.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "patient/synth/synth.h"
#include "patient/synth/variants/frame.h"
#include "patient/synth/variants/lesions.h"

namespace stylet::patient::synth {

namespace {

constexpr std::string_view kBae = "Bae 2010, Radiology 256:32; Foley 1989, Radiology 170:617";
constexpr std::string_view kVoltage = "Bae 2010, Radiology 256:32; Cropp et al. 2013, JACMP 14:4417";
constexpr std::string_view kAtlas = "Prokop and Galanski 2003, Spiral and Multislice CT of the Body";
constexpr std::string_view kChosen = "chosen; no measured distribution";

void setVoltage(PatientPlan& p, double iodine, double bone, double fat_hu) {
    p.scanner.iodine = iodine, p.scanner.bone = bone, p.scanner.fat_hu = fat_hu;
}

void setFat(PatientPlan& p, double side_mm, double front_mm, double back_mm) {
    p.anatomy.fat_side_mm = side_mm, p.anatomy.fat_front_mm = front_mm, p.anatomy.fat_back_mm = back_mm;
}

constexpr Variant kVariants[] = {
    {"native", "no contrast medium: vessels 42 HU, liver 58", kBae,
     [](PatientPlan& p) { p.scanner.phase = Phase::native; }},
    {"arterial", "late arterial phase: aorta 300 HU, portal vein 75, liver 66", kBae,
     [](PatientPlan& p) { p.scanner.phase = Phase::arterial; }},
    {"late", "late phase: vessels 110 HU, liver 90", kBae,
     [](PatientPlan& p) { p.scanner.phase = Phase::late; }},
    {"80-kv", "enhancement x1.7, bone x1.33, fat -14 HU", kVoltage,
     [](PatientPlan& p) { setVoltage(p, 1.7, 1.33, -14.0); }},
    {"100-kv", "enhancement x1.25, bone x1.13, fat -6 HU", kVoltage,
     [](PatientPlan& p) { setVoltage(p, 1.25, 1.13, -6.0); }},
    {"140-kv", "enhancement x0.85, bone x0.92, fat +4 HU", kVoltage,
     [](PatientPlan& p) { setVoltage(p, 0.85, 0.92, 4.0); }},
    {"noise-x0.5", "noise of 5.5 HU", kChosen, [](PatientPlan& p) { p.scanner.noise = 0.5; }},
    {"noise-x2", "noise of 22 HU", kChosen, [](PatientPlan& p) { p.scanner.noise = 2.0; }},
    {"noise-x3", "noise of 33 HU", kChosen, [](PatientPlan& p) { p.scanner.noise = 3.0; }},
    {"soft-kernel", "three passes of the blur", kChosen, [](PatientPlan& p) { p.scanner.blur_passes = 3; }},
    {"sharp-kernel", "no blur, noise x1.6", kChosen,
     [](PatientPlan& p) { p.scanner.blur_passes = 0, p.scanner.kernel_noise = 1.6; }},
    {"slices-3", "slices of 3 mm", kAtlas, [](PatientPlan& p) { p.scanner.slice_m = 0.003; }},
    {"slices-5", "slices of 5 mm", kAtlas, [](PatientPlan& p) { p.scanner.slice_m = 0.005; }},
    {"cut-flank", "the image ends 25 mm inside the right flank", kChosen, nullptr, nullptr,
     [](Package& p) { cutRight(p, 0.025); }},
    {"cut-top", "the image ends 30 mm below the liver's dome", kChosen, nullptr, nullptr,
     [](Package& p) { cutTop(p, 0.030); }},
    {"cut-bottom", "the image begins 40 mm above the liver's lower edge", kChosen, nullptr, nullptr,
     [](Package& p) { cutBottom(p, 0.040); }},
    {"thin", "3 mm of fat under the skin", kChosen, [](PatientPlan& p) { setFat(p, 3.0, 3.0, 3.0); }},
    {"obese", "32 to 38 mm of fat under the skin", kChosen,
     [](PatientPlan& p) { setFat(p, 32.0, 38.0, 26.0), p.section = Vec3(1.25, 1.25, 1.0); }},
    {"child", "all lengths x0.65", "liver of 600 ml at 7 years: Noda et al. 1997, Pediatr Radiol",
     [](PatientPlan& p) { p.anatomy.scale *= 0.65, p.section = Vec3(0.7, 0.7, 0.68); }},
    {"calcified-tumour", "tumour of 34 mm under the ribs with calcifications of 500 to 900 HU", kAtlas,
     nullptr, paintCalcifiedTumour},
    {"necrosis", "tumour of 54 mm beside the gallbladder, its core 20 HU", kAtlas, nullptr,
     paintNecroticTumour},
    {"cysts", "six cysts of 14 to 36 mm in the liver, 5 HU", kAtlas, nullptr, paintCysts},
    {"fissure-fat", "wide fissure of the round ligament, sheet of fat of 2.6 mm behind the left lobe", kAtlas,
     [](PatientPlan& p) { p.anatomy.fissure_mm = 4.5; }, paintFissureFat},
    {"plaque", "calcified plaque of 700 HU in the aorta's wall", kAtlas, nullptr, paintAorticPlaque},
    {"steatosis", "liver 45 HU darker: 67, spleen 118", "Boyce et al. 2010, AJR 194:623",
     [](PatientPlan& p) { p.scanner.liver_fat_hu += -45.0; }},
    {"cirrhosis", "nodules of 6 mm on a shrunken liver", kAtlas,
     [](PatientPlan& p) {
         p.anatomy.nodules_mm = 3.0, p.anatomy.organs.liver_low_mm += 14.0;
         p.scanner.liver_fat_hu += -12.0;
     }},
    {"ascites", "fluid of 9 HU around the liver and in the gutters", kAtlas, nullptr, paintAscites},
    {"effusion", "fluid of 12 HU behind both lungs", kAtlas, nullptr, paintEffusion},
    {"calcified-cartilage", "costal cartilage calcified in part, 380 HU", kAtlas, nullptr,
     paintCalcifiedCartilage},
    {"stent", "metal stent in the common duct, 1800 HU", kAtlas, nullptr, paintStent},
    {"metal", "two screws in a vertebra, with streaks", kChosen, nullptr, paintScrews,
     [](Package& p) { addStreaks(p.ct); }},
    {"arms-down", "arms beside the body", kChosen, [](PatientPlan& p) { p.section = Vec3(1.45, 1.0, 1.0); },
     paintArms},
    {"mirrored", "left and right exchanged (or a situs inversus)", kChosen, nullptr, nullptr,
     [](Package& p) { reverse(p, true, false, false); }},
    {"feet-first", "scanned feet first, the header says head first", kChosen, nullptr, nullptr,
     [](Package& p) { reverse(p, true, false, true); }},
    {"prone", "scanned prone, the header says supine", kChosen, nullptr, nullptr,
     [](Package& p) { reverse(p, true, true, false); }},
    {"false-spacing", "the header states half of the slices' distance", kChosen, nullptr, nullptr,
     [](Package& p) { misstateSpacing(p, 0.5); }},
    {"false-intercept", "all values 1024 HU too high: the rescale intercept was ignored", kChosen, nullptr,
     nullptr, [](Package& p) { shiftHu(p, 1024); }},
};

constexpr PlanField kFields[] = {
    {"contrast phase", [](const PatientPlan& p) { return Vec3(double(p.scanner.phase)); }},
    {"tube voltage",
     [](const PatientPlan& p) { return Vec3(p.scanner.iodine, p.scanner.bone, p.scanner.fat_hu); }},
    {"liver's CT value", [](const PatientPlan& p) { return Vec3(p.scanner.liver_fat_hu); }},
    {"noise", [](const PatientPlan& p) { return Vec3(p.scanner.noise); }},
    {"kernel", [](const PatientPlan& p) { return Vec3(p.scanner.blur_passes, p.scanner.kernel_noise, 0.0); }},
    {"slice thickness", [](const PatientPlan& p) { return Vec3(p.scanner.slice_m); }},
    {"fat under the skin",
     [](const PatientPlan& p) {
         return Vec3(p.anatomy.fat_side_mm, p.anatomy.fat_front_mm, p.anatomy.fat_back_mm);
     }},
    {"image size", [](const PatientPlan& p) { return p.section; }},
    {"body size", [](const PatientPlan& p) { return p.anatomy.scale; }},
    {"fissure", [](const PatientPlan& p) { return Vec3(p.anatomy.fissure_mm); }},
    {"liver's surface",
     [](const PatientPlan& p) { return Vec3(p.anatomy.nodules_mm, p.anatomy.organs.liver_low_mm, 0.0); }},
};

// The field that only the later one of the two variants would decide; nullptr if there is none.
const PlanField* conflict(const Variant& a, const Variant& b) {
    if (!a.plan || !b.plan) return nullptr;
    PatientPlan a_first, b_first;
    a.plan(a_first), b.plan(a_first);
    b.plan(b_first), a.plan(b_first);
    const auto* const field = std::find_if(std::begin(kFields), std::end(kFields), [&](const PlanField& f) {
        return f.value(a_first) != f.value(b_first);
    });
    return field == std::end(kFields) ? nullptr : field;
}

void requireCombinable(const std::vector<const Variant*>& variants) {
    for (std::size_t b = 0; b < variants.size(); ++b)
        for (std::size_t a = 0; a < b; ++a)
            if (const PlanField* const field = conflict(*variants[a], *variants[b]))
                throw std::invalid_argument(
                    fmt::format("\"{}\" and \"{}\" set the same field differently: {}. Choose one of them",
                                variants[a]->name, variants[b]->name, field->name));
}

}  // namespace

std::span<const Variant> variantTable() {
    return kVariants;
}

std::span<const PlanField> planFields() {
    return kFields;
}

std::vector<const Variant*> findVariants(const std::vector<std::string>& names) {
    const auto isWanted = [&](const Variant& v) {
        return std::find(names.begin(), names.end(), v.name) != names.end();
    };
    std::vector<const Variant*> found;
    for (const Variant& v : kVariants)
        if (isWanted(v)) found.push_back(&v);
    for (const std::string& name : names)
        if (std::none_of(found.begin(), found.end(), [&](const Variant* v) { return v->name == name; }))
            throw std::invalid_argument("no variant is named \"" + name +
                                        "\"; list them with --variant list");
    requireCombinable(found);
    return found;
}

std::vector<VariantInfo> listVariants() {
    std::vector<VariantInfo> list;
    for (const Variant& v : kVariants)
        list.push_back({std::string(v.name), std::string(v.changes), std::string(v.source)});
    return list;
}

}  // namespace stylet::patient::synth
