// Variants of the reference patient change what their row says, and nothing without a variant.
#include "patient/synth/variants/variant.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <stdexcept>

#include "patient/motion/motion_template.h"
#include "patient/synth/synth.h"
#include "patient/synth/variants/frame.h"

namespace stylet::patient::synth {
namespace {

struct MadePatient {
    Package package;
    std::uint64_t digest = 0;
};

SynthSettings settings(const std::vector<std::string>& variants, double spacing_m) {
    SynthSettings s;
    s.seed = 3;
    s.spacing_m = spacing_m;
    s.variants = variants;
    const char* assets = std::getenv("STYLET_ASSETS");
    if (assets) s.defaults = loadTissueDefaults(std::filesystem::path(assets) / "tissue" / "ptcd.toml");
    return s;
}

// Each patient is made once, without motion. Most of the time goes into structures that do not depend on the
// spacing.
const MadePatient& made(const std::vector<std::string>& variants, double spacing_m = 0.004) {
    static std::map<std::pair<std::vector<std::string>, double>, MadePatient> kept;
    const auto key = std::pair(variants, spacing_m);
    if (const auto found = kept.find(key); found != kept.end()) return found->second;
    SynthSettings s = settings(variants, spacing_m);
    s.motion = false;
    MadePatient one{makeReferencePatient(s)};
    one.digest = digest(one.package);
    return kept.emplace(key, std::move(one)).first->second;
}
const Package& make(const std::vector<std::string>& variants, double spacing_m = 0.004) {
    return made(variants, spacing_m).package;
}

const Package& reference() {
    return make({});
}

struct Statistics {
    double mean = 0.0, deviation = 0.0, count = 0.0;
    int largest = -2000;
};
Statistics valuesOf(const Package& p, Id id) {
    Statistics s;
    double squares = 0.0;
    for (std::size_t i = 0; i < p.labels.voxels.size(); ++i) {
        if (p.labels.voxels[i] != std::uint8_t(id)) continue;
        const int hu = p.ct.voxels[i];
        ++s.count, s.mean += hu, squares += double(hu) * hu;
        s.largest = std::max(s.largest, hu);
    }
    s.mean /= s.count;
    s.deviation = std::sqrt(squares / s.count - s.mean * s.mean);
    return s;
}
double mean(const Package& p, Id id) {
    return valuesOf(p, id).mean;
}

TEST(Variants, TableHasUniqueNamesAndSources) {
    std::set<std::string> names;
    for (const VariantInfo& v : listVariants()) {
        EXPECT_TRUE(names.insert(v.name).second) << v.name;
        EXPECT_FALSE(v.changes.empty() || v.source.empty()) << v.name;
        EXPECT_EQ(v.name.find(','), std::string::npos) << v.name;
    }
    EXPECT_FALSE(names.contains("list"));
}

TEST(Variants, UnknownNameIsRefused) {
    EXPECT_THROW(make({"native", "no such"}), std::invalid_argument);
    EXPECT_THROW(make({""}), std::invalid_argument);
}

TEST(Variants, EveryVariantChangesThePatientAndSaysSo) {
    ASSERT_TRUE(isReferencePatient(reference()));
    const std::set<std::string_view> lesions{"calcified-tumour", "necrosis", "fissure-fat"};
    for (const Variant& v : variantTable()) {
#ifdef STYLET_SANITIZED  // the same code with other numbers
        if (v.name.starts_with("noise-") || v.name.ends_with("-kv")) continue;
#endif
        // Slices have no effect on coarser voxels. The other spacings are those of the tests below.
        const double spacing_m = v.name.starts_with("slices-") ? 0.0025
                                 : lesions.contains(v.name)    ? 0.003
                                                               : 0.004;
        const auto& [p, its_digest] = made({std::string(v.name)}, spacing_m);
        EXPECT_NE(its_digest, made({}, spacing_m).digest) << v.name;
        EXPECT_NE(p.name.find(v.name), std::string::npos);
        EXPECT_FALSE(isReferencePatient(p)) << v.name;
        EXPECT_EQ(p.ct.voxels.size(), p.ct.grid.voxelCount()) << v.name;
        EXPECT_TRUE(p.ct.grid == p.labels.grid) << v.name;
        // makeReferencePatient() computes the motion from the labels, before a variant changes the frame.
        if (v.finish || p.labels.voxels == make({}, spacing_m).labels.voxels) continue;
        EXPECT_FALSE(motionTemplate(p.labels, p.label_table, {}, {0.0, 0.0}).empty()) << v.name;
    }
}

TEST(Variants, CombineInTheOrderOfTheTable) {
    const auto& [both, its_digest] = made({"noise-x2", "native"});
    EXPECT_EQ(its_digest, made({"native", "noise-x2"}).digest);
    EXPECT_NE(both.name.find("native,noise-x2"), std::string::npos) << both.name;
    EXPECT_LT(mean(both, Id::portal), mean(both, Id::liver));
}

// Without this, findVariants() would not notice two variants that set the same field.
TEST(Variants, EveryPlanChangesAListedField) {
    for (const Variant& v : variantTable()) {
        if (!v.plan) continue;
        const PatientPlan before;
        PatientPlan after;
        v.plan(after);
        EXPECT_TRUE(std::any_of(planFields().begin(), planFields().end(), [&](const PlanField& f) {
            return f.value(before) != f.value(after);
        })) << v.name;
    }
}

TEST(Variants, ThatSetTheSameFieldAreRefused) {
    const auto refusal = [](const std::vector<std::string>& names) -> std::string {
        try {
            findVariants(names);
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return "";
    };
    const auto text = [](const char* a, const char* b, const char* field) {
        return "\"" + std::string(a) + "\" and \"" + b + "\" set the same field differently: " + field;
    };
    for (const auto& [a, b, field] : {std::array{"native", "arterial", "contrast phase"},
                                      {"80-kv", "140-kv", "tube voltage"},
                                      {"noise-x0.5", "noise-x3", "noise"},
                                      {"soft-kernel", "sharp-kernel", "kernel"},
                                      {"slices-3", "slices-5", "slice thickness"},
                                      {"thin", "obese", "fat under the skin"},
                                      {"obese", "child", "image size"},
                                      {"child", "arms-down", "image size"}}) {
        EXPECT_EQ(refusal({a, b}).find(text(a, b, field)), 0u) << refusal({a, b});
        EXPECT_EQ(refusal({b, "stent", a}).find(text(a, b, field)), 0u) << refusal({b, "stent", a});
    }
    EXPECT_EQ(refusal({"native", "native"}), "");
    EXPECT_THROW(make({"noise-x3", "noise-x0.5"}), std::invalid_argument);
}

// Factors, shifts and reversals of two variants both count, in any order of the names.
TEST(Variants, CombineTruly) {
    PatientPlan plan;
    for (const Variant* v : findVariants({"sharp-kernel", "noise-x2", "cirrhosis", "steatosis"}))
        v->plan(plan);
    EXPECT_DOUBLE_EQ(ctSettings(plan.scanner).noise, 3.2);
    EXPECT_EQ(plan.scanner.blur_passes, 0);
    EXPECT_EQ(plan.scanner.liver_fat_hu, -57.0);
    Package turned = reference();
    reverse(turned, false, true, true);
    EXPECT_EQ(make({"prone", "feet-first"}).labels.voxels, turned.labels.voxels);
}

TEST(Variants, PhasesOrderTheVesselsAndOrgans) {
    const Package &native = make({"native"}), &arterial = make({"arterial"}), &late = make({"late"});
    EXPECT_NEAR(mean(native, Id::aorta), 42.0, 3.0);
    EXPECT_NEAR(mean(native, Id::liver), 58.0, 3.0);
    EXPECT_NEAR(mean(arterial, Id::aorta), 300.0, 6.0);
    EXPECT_LT(mean(arterial, Id::hepaticVeins), mean(arterial, Id::liver));
    EXPECT_GT(mean(late, Id::portal), mean(late, Id::liver));
    EXPECT_LT(mean(late, Id::portal), mean(reference(), Id::portal));
    EXPECT_LT(valuesOf(native, Id::kidneyLeft).deviation, valuesOf(reference(), Id::kidneyLeft).deviation);
}

TEST(Variants, VoltageScalesIodineAndBone) {
    const Package &low = make({"80-kv"}), &high = make({"140-kv"});
    EXPECT_NEAR(mean(low, Id::aorta), 42.0 + 1.7 * (170.0 - 42.0), 6.0);
    EXPECT_GT(mean(low, Id::spine), 1.25 * mean(reference(), Id::spine));
    EXPECT_LT(mean(high, Id::aorta), mean(reference(), Id::aorta) - 10.0);
    EXPECT_NEAR(mean(low, Id::muscle), mean(reference(), Id::muscle), 2.0);
}

// The noise is white before the blur within the plane, so the deviation of an organ's values grows with it.
TEST(Variants, NoiseHasTheStatedFactor) {
    const double texture = valuesOf(make({"noise-x0.5"}), Id::aorta).deviation;
    const auto squared = [&](const char* name) {
        return std::pow(valuesOf(make({name}), Id::aorta).deviation, 2.0) - texture * texture;
    };
    // (3^2 - 0.5^2) / (2^2 - 0.5^2)
    EXPECT_NEAR(squared("noise-x3") / squared("noise-x2"), 8.75 / 3.75, 0.15);
}

TEST(Variants, SteatosisMakesTheLiverDarkerThanTheSpleen) {
    const Package& fat = make({"steatosis"});
    EXPECT_LT(mean(fat, Id::liver), mean(fat, Id::spleen) - 40.0);
    EXPECT_NEAR(mean(fat, Id::spleen), mean(reference(), Id::spleen), 2.0);
}

TEST(Variants, LesionsHaveTheirValues) {
    const Package &stone = make({"calcified-tumour"}, 0.003), &dead = make({"necrosis"}, 0.003);
    EXPECT_GT(valuesOf(stone, Id::tumour).largest, 400);
    EXPECT_GT(valuesOf(dead, Id::tumour).count, 3.0 * valuesOf(make({}, 0.003), Id::tumour).count);
    EXPECT_LT(mean(dead, Id::tumour), 65.0);
    EXPECT_GT(valuesOf(make({"plaque"}), Id::aorta).largest, 400);
    EXPECT_LT(valuesOf(reference(), Id::aorta).largest, 300);
    EXPECT_GT(mean(make({"calcified-cartilage"}), Id::cartilage), mean(reference(), Id::cartilage) + 20.0);
    EXPECT_GT(mean(make({"ascites"}), Id::visceralFat), mean(reference(), Id::visceralFat) + 10.0);
    EXPECT_GT(mean(make({"effusion"}), Id::lungRight), mean(reference(), Id::lungRight) + 30.0);
    EXPECT_GT(valuesOf(make({"fissure-fat"}, 0.003), Id::visceralFat).count,
              valuesOf(make({}, 0.003), Id::visceralFat).count);
}

TEST(Variants, BodiesHaveTheirSize) {
    const auto millilitres = [](const Package& p, Id id) { return valuesOf(p, id).count * 0.064; };
    const Package &child = make({"child"}), &obese = make({"obese"}), &thin = make({"thin"});
    EXPECT_NEAR(millilitres(child, Id::liver) / millilitres(reference(), Id::liver), std::pow(0.65, 3), 0.06);
    EXPECT_GT(millilitres(obese, Id::fat), 2.0 * millilitres(reference(), Id::fat));
    EXPECT_LT(millilitres(thin, Id::fat), 0.6 * millilitres(reference(), Id::fat));
    // The larger image contains the whole body.
    const Grid& g = obese.labels.grid;
    int at_the_sides = 0;
    forEachVoxel(g, [&](const Index3& i) {
        const bool side = i.x == 0 || i.y == 0 || i.x + 1 == g.dims.x || i.y + 1 == g.dims.y;
        at_the_sides += side && obese.labels[i] != 0;
    });
    EXPECT_EQ(at_the_sides, 0);
}

TEST(ThickSlices, KeepConstantsAndRampsAndSmearSteps) {
    CtVolume ct(Grid{{2, 2, 40}, Vec3(0.001), Vec3(0.0)});
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        ct.voxels[i] = std::int16_t(10 * (i / 4));
    CtVolume thick = ct;
    thickenSlices(thick, 0.001);
    EXPECT_EQ(thick.voxels, ct.voxels);
    thickenSlices(thick, 0.005);
    for (int z = 5; z < 35; ++z)
        EXPECT_NEAR((thick[{1, 1, z}]), 10.0 * z, 1.0) << z;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        ct.voxels[i] = i / 4 < 20 ? 0 : 100;
    thickenSlices(ct, 0.005);
    EXPECT_EQ((ct[{0, 0, 15}]), 0);
    // The slice centred at 20 covers 17.5 to 22.5: half of the voxel 20 and below is dark.
    EXPECT_EQ((ct[{0, 0, 20}]), 60);
    EXPECT_EQ((ct[{0, 0, 25}]), 100);
    EXPECT_GT((ct[{0, 0, 18}]), 0);
}

TEST(Frame, CutsReachTheBodyAndTheLiver) {
    const Package &flank = make({"cut-flank"}), &top = make({"cut-top"}), &bottom = make({"cut-bottom"});
    const auto touches = [](const Package& p, int axis, bool high, Id id) {
        bool found = false;
        const Grid& g = p.labels.grid;
        forEachVoxel(g, [&](const Index3& i) {
            if (i[axis] == (high ? g.dims[axis] - 1 : 0)) found = found || p.labels[i] == std::uint8_t(id);
        });
        return found;
    };
    EXPECT_TRUE(touches(flank, 0, true, Id::muscle));
    EXPECT_TRUE(touches(top, 2, true, Id::liver));
    EXPECT_TRUE(touches(bottom, 2, false, Id::liver));
    EXPECT_FALSE(touches(reference(), 0, true, Id::muscle));
    EXPECT_FALSE(touches(reference(), 2, true, Id::liver));
    // The voxels that are left stay where they were.
    const Index3 there = reference().ct.grid.nearest(bottom.ct.grid.centre({40, 30, 5}));
    EXPECT_EQ(bottom.ct[(Index3{40, 30, 5})], reference().ct[there]);
}

TEST(Frame, ReversingTwiceRestoresTheImage) {
    Package p = makeReferencePatient(settings({}, 0.004));
    ASSERT_FALSE(p.motion.empty());
    reverse(p, true, false, true);
    EXPECT_NE(p.labels.voxels, reference().labels.voxels);
    EXPECT_TRUE(p.motion.empty());
    EXPECT_EQ(p.labels[(Index3{0, 3, 0})],
              reference().labels[(Index3{p.labels.grid.dims.x - 1, 3, p.labels.grid.dims.z - 1})]);
    reverse(p, true, false, true);
    EXPECT_EQ(p.labels.voxels, reference().labels.voxels);
    EXPECT_EQ(p.ct.voxels, reference().ct.voxels);
}

}  // namespace
}  // namespace stylet::patient::synth
