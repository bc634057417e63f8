#include "haptics/tools/instrument.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "base/text.h"
#include "base/whole_file.h"
#include "haptics/loop/toolbox.h"
#include "tests/app/trainer/assets.h"
#include "tests/haptics/column.h"
#include "tests/support/refused.h"

namespace stylet::haptics {
namespace {

using patient::Tissue;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return text;
}

std::filesystem::path folder() {
    return test::assets() / "instruments";
}

Instrument shipped(const std::string& name) {
    return loadInstrument(folder() / (name + ".toml"));
}

const NeedleSettings& needleForce(const Instrument& one) {
    return std::get<NeedleSettings>(one.force);
}

std::string shippedText(const std::string& name) {
    return readWholeFile(folder() / (name + ".toml"), 1 << 16);
}

// Expects that the shipped file is refused once `from` has become `to`.
void refuses(const std::string& name, const std::string& from, const std::string& to,
             const std::string& field) {
    const std::string text = replaced(shippedText(name), from, to);
    test::expectRefused([&] { parseInstrument("a.toml", text); }, "a.toml", field);
}

// The defaults of all settings are those of the shipped instruments, bit for bit. Programs that load no
// instrument, such as the study, use the same numbers.
TEST(Instruments, TheShippedFilesAreTheDefaults) {
    const Instrument needle = shipped(std::string(kDefaultNeedle));
    EXPECT_EQ(digest(needle), digest(Instrument()));
    EXPECT_EQ(needle.shape, NeedleShape());
    EXPECT_EQ(needleForce(needle).friction_scale, 1.0);
    EXPECT_EQ(needleForce(needle).cut_reach_m, NeedleSettings().cut_reach_m);
    ToolSettings tools;
    std::vector<double> expected, found;
    visitToolNumbers(tools, [&](double v) { expected.push_back(v); });
    // Other values, which the instruments must replace. The guide is not read from a file.
    const GuideSettings guide = tools.guide;
    visitToolNumbers(tools, [&](double& v) { v = -1.0; });
    tools.guide = guide;
    tools.needle.a1_share = NeedleSettings().a1_share;
    for (const char* name : {"needle-17g", "scalpel", "probe-convex", "finger"})
        equip(tools, shipped(name));
    visitToolNumbers(tools, [&](double v) { found.push_back(v); });
    EXPECT_EQ(found, expected);
    EXPECT_EQ(tools.finger.points, FingerSettings().points);
    EXPECT_EQ(tools.probe.columns * 100 + tools.probe.rows, 903);
}

TEST(Instruments, ASetHasTheShippedInstrumentOfEveryKind) {
    InstrumentSet set;
    std::set<InstrumentKind> kinds;
    visitInstruments(set, [&](const Instrument& one) {
        EXPECT_EQ(digest(one), digest(shipped(one.name))) << one.name;
        EXPECT_TRUE(kinds.insert(one.kind).second) << one.name;
        EXPECT_EQ(findInstrument(set, one.kind), &one);
    });
    EXPECT_EQ(kinds.size(), kInstrumentKindNames.size());
}

// The tools of a set, and back.
TEST(Instruments, ASetEquipsAllTools) {
    InstrumentSet set;
    set.needle = shipped("chiba-22g"), set.probe = shipped("probe-linear");
    ToolSettings tools;
    equip(tools, set);
    EXPECT_EQ(tools.needle.lateral_force_n, 0.24);
    EXPECT_EQ(tools.probe.length_m, 0.040);
    EXPECT_EQ(tools.scalpel.cut_force_n, ScalpelSettings().cut_force_n);
    visitInstruments(set, [&](const Instrument& one) {
        Instrument bare = one;
        bare.force = std::monostate();
        EXPECT_EQ(digest(withToolForce(bare, tools)), digest(one)) << one.name;
        EXPECT_NE(digest(bare), digest(one)) << one.name;
    });
}

TEST(Instruments, AllShippedFilesAreReadAndDescribed) {
    const std::vector<Instrument> all = loadInstruments(folder());
    std::set<std::string> names;
    for (const Instrument& one : all) {
        names.insert(one.name);
        const std::string line = describe(one);
        EXPECT_EQ(line.find(one.name), 0u);
        EXPECT_NE(line.find(one.title), std::string::npos);
        if (one.kind == InstrumentKind::needle) {
            EXPECT_EQ(shapeError(one.shape), "") << one.name;
            EXPECT_NE(line.find(std::to_string(one.gauge) + " G"), std::string::npos);
        }
    }
    for (const char* name : {"chiba-21g", "chiba-22g", "dilator", "drain", "finger", "guide-wire",
                             "needle-17g", "probe-convex", "probe-linear", "scalpel", "trocar-18g"})
        EXPECT_TRUE(names.contains(name)) << name;
}

// The same for wire, dilator and drain. Each changes only its own settings.
TEST(Instruments, WireDilatorAndDrainAreTheDefaults) {
    const auto numbers = [](const AccessSettings& s) {
        std::vector<double> all;
        visitAccessNumbers(s, [&](double v) { all.push_back(v); });
        return all;
    };
    ToolSettings tools;
    const std::vector<double> expected = numbers(tools.access);
    visitAccessNumbers(tools.access, [](double& v) { v = -1.0; });
    equip(tools, shipped("dilator"));
    EXPECT_EQ(tools.access.drain.outer_m, -1.0);
    for (const char* name : {"guide-wire", "drain"})
        equip(tools, shipped(name));
    const std::vector<double> found = numbers(tools.access);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)  // millimetres are rounded
        EXPECT_DOUBLE_EQ(found[i], expected[i]) << i;
}

TEST(Instruments, ForceFollowsTheDiameterUnlessTheFileSaysOtherwise) {
    const NeedleSettings thin = needleForce(shipped("chiba-22g"));
    EXPECT_DOUBLE_EQ(thin.friction_scale, 0.72 / 1.5);
    EXPECT_DOUBLE_EQ(thin.cut_reach_m, 0.00072);
    EXPECT_EQ(thin.a1_share, NeedleSettings().a1_share);
    const Instrument own =
        parseInstrument("a.toml", replaced(shippedText("chiba-22g"), "[force]\n",
                                           "[force]\ncut_reach_mm = 1.1\nfriction_scale = 0.9\n"));
    EXPECT_DOUBLE_EQ(needleForce(own).cut_reach_m, 0.0011);
    EXPECT_DOUBLE_EQ(needleForce(own).friction_scale, 0.9);
    EXPECT_EQ(own.shape, shipped("chiba-22g").shape);
}

TEST(Instruments, TheTipsLengthFollowsFromDiameterAndBevel) {
    EXPECT_NEAR(shipped("needle-17g").shape.tipLength_m(), 0.0015 / std::tan(22.0 * M_PI / 180.0), 1e-12);
    EXPECT_NEAR(shipped("trocar-18g").shape.tipLength_m(), 0.000635 / std::tan(15.0 * M_PI / 180.0), 1e-12);
}

// The table of the guide has one line per needle.
TEST(Instruments, TheDocumentedTableIsTheFiles) {
    std::ifstream page(test::assets().parent_path() / "packaging" / "guide" / "model.md");
    ASSERT_TRUE(page);
    std::string rows, expected;
    bool table = false;
    for (std::string line; std::getline(page, line);) {
        table = line.starts_with("| needle |") || (table && line.starts_with("|"));
        if (table && !line.starts_with("| needle |") && !line.starts_with("|---")) rows += line + "\n";
    }
    for (const Instrument& one : loadInstruments(folder())) {
        if (one.kind != InstrumentKind::needle) continue;
        const NeedleShape& s = one.shape;
        std::ostringstream row;
        row << "| `" << one.name << "` | " << one.gauge << " G | " << 1e3 * s.outer_m << " | "
            << 1e3 * s.inner_m << " | " << 1e3 * s.length_m << " | " << enumName(kNeedleTipNames, s.tip)
            << " | " << needleForce(one).friction_scale << " | " << needleForce(one).lateral_stiffness_n_per_m
            << " |\n";
        expected += row.str();
    }
    EXPECT_EQ(rows, expected);
}

TEST(Instruments, WrongFilesAreRefused) {
    const std::string name = "needle-17g";
    refuses(name, "title = \"17 G PTCD needle\"", "title = \"\"", "title");
    refuses(name, "kind = \"needle\"", "kind = \"spoon\"", "kind");
    refuses(name, "gauge = 17", "gauge = 2200000000000", "gauge");
    refuses(name, "gauge = 17\n", "", "gauge");
    refuses(name, "outer_mm = 1.5", "outer_mm = nan", "shaft.outer_mm");
    refuses(name, "outer_mm = 1.5", "outer_mm = 0.0", "shaft.outer_mm");
    refuses(name, "outer_mm = 1.5", "outer_mm = \"1.5\"", "shaft.outer_mm");
    refuses(name, "outer_mm = 1.5", "outer_mm = 1.1", "shaft.inner_mm: not below");
    refuses(name, "inner_mm = 1.1", "inner_mm = -0.1", "shaft.inner_mm");
    refuses(name, "length_mm = 150.0", "length_mm = inf", "shaft.length_mm");
    refuses(name, "stylet = true", "stylet = 1", "shaft.stylet");
    refuses(name, "stylet = true", "stylet = true\nradius_mm = 1.0", "shaft.radius_mm");
    refuses(name, "bevel_deg = 22.0", "bevel_deg = 0.0", "tip.bevel_deg");
    refuses(name, "kind = \"chiba\"", "kind = \"blunt\"", "tip.kind");
    refuses(name, "every_mm = 10.0", "every_mm = 0.0", "marks.every_mm");
    refuses(name, "tip_echo = 0.15", "tip_echo = 1.5", "material.tip_echo");
    refuses(name, "attenuation_per_m = 652.0", "attenuation_per_m = -1.0", "material.attenuation_per_m");
    refuses(name, "lateral_force_n = 0.5", "lateral_force_n = 0.0", "force.lateral_force_n");
    refuses(name, "[force]\n", "[force]\nfriction_scale = nan\n", "force.friction_scale");
    refuses(name, "[force]\n", "[force]\nfriction_scale = 0.0\n", "force.friction_scale");
    refuses(name, "[force]\n", "[force]\nmax_force_n = 1.0\n", "force.max_force_n");
    refuses("chiba-22g", "[force]\n", "[force]\ncut_reach_mm = 8.0\n", "force.cut_reach_mm");
    refuses(name, "gauge = 17", "gauge = 17\ntransducer = \"convex\"", "transducer");
    refuses(name, "[shaft]", "[shaft", "line");
    refuses("drain", "[shaft]", "gauge = 8\n[shaft]", "gauge");
    refuses("drain", "pigtail_mm = 10.0", "pigtail_mm = 1.0", "force.pigtail_mm");
    refuses("dilator", "taper_mm = 20.0", "taper_mm = 20.0\npigtail_mm = 10.0", "force.pigtail_mm");
    refuses("dilator", "taper_mm = 20.0", "taper_mm = nan", "force.taper_mm");
    refuses("guide-wire", "tip_length_mm = 30.0", "tip_length_mm = 0.0", "force.tip_length_mm");
    refuses("guide-wire", "tip_stiffness_n_mm2 = 5.0", "tip_stiffness_n_mm2 = inf",
            "force.tip_stiffness_n_mm2");
    refuses("guide-wire", "blunt_n = 2.0\n", "", "force.blunt_n");
    refuses("finger", "points = 19", "points = 31", "face.points");
    refuses("finger", "curvature_mm = 20.0", "curvature_mm = 5.0", "face");
    refuses("probe-convex", "rows = 3", "rows = 4", "face.rows");
    refuses("probe-convex", "curvature_mm = 60.0", "curvature_mm = 29.0", "face");
    refuses("probe-convex", "transducer = \"convex\"\n", "", "transducer");
    refuses("probe-convex", "\"convex\"", "\"../instruments/finger\"", "transducer");
    refuses("scalpel", "cut_force_n = 0.4", "cut_force_n = nan", "force.cut_force_n");
    test::expectRefused([] { parseInstrument("a.toml", ""); }, "a.toml", "title");
    test::expectRefused([] { loadInstrument(folder() / "none.toml"); }, "none.toml", "");
}

// A tip longer than its needle is refused, although each number alone is within its limits.
TEST(Instruments, ATipLongerThanTheNeedleIsRefused) {
    const std::string blunt = replaced(shippedText("needle-17g"), "length_mm = 150.0", "length_mm = 10.0");
    EXPECT_NO_THROW(parseInstrument("a.toml", blunt));
    EXPECT_NE(test::errorText([&] {
                  parseInstrument("a.toml", replaced(blunt, "bevel_deg = 22.0", "bevel_deg = 5.0"));
              }).find("longer than the needle"),
              std::string::npos);
}

// Every value changes the digest, so that a record cannot be read with another needle.
TEST(Instruments, EveryValueChangesTheDigest) {
    const Instrument needle;
    const std::uint64_t before = digest(needle);
    int numbers = 0;
    const NeedleShape shape;
    visitShapeNumbers(shape, [&](double) { ++numbers; });
    for (int i = 0; i < numbers; ++i) {
        Instrument other;
        int k = 0;
        visitShapeNumbers(other.shape, [&](double& v) { v += k++ == i ? 1e-9 : 0.0; });
        EXPECT_NE(digest(other), before) << i;
    }
    const auto changes = [&](const auto& change) {
        Instrument other;
        change(other);
        EXPECT_NE(digest(other), before);
    };
    changes([](Instrument& o) { o.name += "x"; });
    changes([](Instrument& o) { o.title += "x"; });
    changes([](Instrument& o) { o.gauge = 18; });
    changes([](Instrument& o) { o.shape.tip = NeedleTip::diamond; });
    changes([](Instrument& o) { o.shape.has_stylet = false; });
    changes([](Instrument& o) { std::get<NeedleSettings>(o.force).friction_scale = 0.5; });
    changes([](Instrument& o) { std::get<NeedleSettings>(o.force).lateral_force_n = 0.4; });
}

// The exact force through skin, soft tissue, fascia and liver.
ExactForce forceOf(const patient::Package& package, const NeedleSettings& settings) {
    const patient::Patient patient(package);
    const patient::TissueMap map(patient);
    ExactSolver solver(map, settings);
    return solver.solve({-0.003, 0.0003, 0.0002}, {0.060, 0.0003, 0.0002});
}

// Friction is proportional to the diameter in each tissue. The puncture thresholds are those of the tissue.
TEST(Instruments, TheForceDiffersByGaugeAsTheClosedFormSays) {
    const patient::Package package = test::makeColumn(
        {{Tissue::skin, 0.002}, {Tissue::soft, 0.015}, {Tissue::fascia, 0.002}, {Tissue::liver, 0.060}});
    const double scale = 0.72 / 1.5;
    const ExactForce thick = forceOf(package, needleForce(shipped("needle-17g"))),
                     thin = forceOf(package, needleForce(shipped("chiba-22g")));
    for (const double depth_m :
         {0.018 - 0.003, 0.055}) {  // after a long way in soft tissue, and in the liver
        EXPECT_GT(thick.at(depth_m), 0.0);
        EXPECT_NEAR(thin.at(depth_m), scale * thick.at(depth_m), 1e-12) << depth_m;
    }
    double thick_peak = 0.0, thin_peak = 0.0;
    for (const ExactEvent& e : thick.events)
        if (e.kind == NeedleEventKind::puncture) thick_peak = std::max(thick_peak, e.force_before_n);
    for (const ExactEvent& e : thin.events)
        if (e.kind == NeedleEventKind::puncture) thin_peak = std::max(thin_peak, e.force_before_n);
    EXPECT_EQ(thick_peak, thin_peak);
    EXPECT_EQ(thick_peak, package.tissues[std::size_t(Tissue::fascia)].cut_force_n);
}

// A second border of the same kind 1 mm behind a punctured one tents for a needle of 0.72 mm, but not for one
// of 1.5 mm.
TEST(Instruments, AThinNeedleTentsWhereAThickOneHasCut) {
    const patient::Package package = test::makeColumn({{Tissue::skin, 0.002},
                                                       {Tissue::soft, 0.015},
                                                       {Tissue::fascia, 0.0005},
                                                       {Tissue::liver, 0.0005},
                                                       {Tissue::fascia, 0.0005},
                                                       {Tissue::liver, 0.060}});
    const auto fasciaPunctures = [&](const char* name) {
        int count = 0;
        for (const ExactEvent& e : forceOf(package, needleForce(shipped(name))).events)
            count += e.kind == NeedleEventKind::puncture && e.tissue == Tissue::fascia;
        return count;
    };
    EXPECT_EQ(fasciaPunctures("needle-17g"), 1);
    EXPECT_EQ(fasciaPunctures("chiba-22g"), 2);
}

// The needle of the attempt is felt by both solvers alike, for the shipped table.
TEST(Instruments, SampledEqualsExactFor22G) {
    const patient::Package package = test::makeColumn({{Tissue::skin, 0.002},
                                                       {Tissue::soft, 0.015},
                                                       {Tissue::fascia, 0.001},
                                                       {Tissue::liver, 0.010},
                                                       {Tissue::vessel, 0.003},
                                                       {Tissue::liver, 0.010},
                                                       {Tissue::duct, 0.004},
                                                       {Tissue::liver, 0.030}});
    const patient::Patient patient(package);
    test::Hand hand(patient);
    hand.settings = needleForce(shipped("chiba-22g"));
    const ExactForce exact = forceOf(package, hand.settings);
    double worst_n = 0.0;
    std::mt19937 random(3);
    hand.to({-0.003, 0.0003, 0.0002});
    for (double x_m = -0.003; x_m < 0.056; x_m += 1e-7 * double(random() % 2000)) {
        hand.to({x_m, 0.0003, 0.0002});
        bool near = false;
        for (const ExactEvent& e : exact.events)
            near = near || std::fabs(e.depth_m - 0.003 - x_m) < 1e-9;
        if (!near) worst_n = std::max(worst_n, std::fabs(hand.force() - exact.at(x_m + 0.003)));
    }
    EXPECT_LT(worst_n, 1e-8);
    EXPECT_FALSE(hand.eventsOf(NeedleEventKind::puncture).empty());
}

}  // namespace
}  // namespace stylet::haptics
