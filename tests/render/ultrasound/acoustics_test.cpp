#include "render/ultrasound/acoustics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/render/refusal.h"
#include "tests/support/temp_folder.h"

namespace stylet::render {
namespace {

std::string row(const std::string& name, const std::string& more = "") {
    return "[[tissue]]\nname = \"" + name +
           "\"\nimpedance_mrayl = 1.6\nattenuation_db_per_cm_mhz = 0.5\nspeed_m_per_s = 1540.0\n"
           "scatter_db = -45.0\nsource = \"none\"\n" +
           more;
}
const std::string kGoodAcoustics =
    "roughness = 0.1\n" + row("air") + row("gel") + row("steel") + row("liver") +
    "[[label]]\ntissue = \"liver\"\nacoustic = \"liver\"\n"
    "[[hu]]\nfrom_hu = -1000.0\nacoustic = \"air\"\n[[hu]]\nfrom_hu = -300.0\nacoustic = "
    "\"liver\"\n";

AcousticTable parseAcousticsText(const std::string& text) {
    return parseAcoustics("tissues.toml", text);
}

const Acoustic& named(const AcousticTable& table, const std::string& name) {
    for (const Acoustic& a : table.acoustics)
        if (a.name == name) return a;
    throw std::runtime_error(name);
}

double echo_db(const AcousticTable& table, const char* from, const char* to) {
    return 20.0 * std::log10(std::fabs(reflectivity(named(table, from), named(table, to))));
}

// Section 7 of the model.
TEST(Acoustics, ShippedTableMatchesTheModelAttenuation) {
    const AcousticTable table = loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml");
    EXPECT_NEAR(echo_db(table, "fat", "muscle"), -19.7, 0.05);
    EXPECT_NEAR(echo_db(table, "liver", "bile"), -25.3, 0.05);
    EXPECT_NEAR(echo_db(table, "liver", "bone"), -3.7, 0.05);
    EXPECT_GT(echo_db(table, "liver", "gas"), -0.01);
    EXPECT_NEAR(named(table, "liver").attenuation_db_per_m_mhz, 70.0, 1e-9);
}

TEST(Acoustics, OnlyBoneCartilageAndSteelResistInjectedFluid) {
    const AcousticTable table = loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml");
    for (const Acoustic& a : table.acoustics)
        EXPECT_EQ(a.solid, a.name == "bone" || a.name == "cartilage" || a.name == "steel") << a.name;
}

// HZ-TEACH-19
TEST(Acoustics, EveryPhantomLabelHasATissue) {
    const AcousticTable table = loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml");
    const patient::Package package = test::makeTrunk(0.008);
    const patient::Patient patient(package);
    const auto rows = acousticsByLabel(table, patient);
    const auto nameOf = [&](patient::Tissue t) {
        return table.acoustics[std::size_t(rows[std::size_t(t)])].name;
    };
    EXPECT_EQ(nameOf(patient::Tissue::liver), "liver");
    EXPECT_EQ(nameOf(patient::Tissue::duct), "bile");
    EXPECT_EQ(nameOf(patient::Tissue::vessel), "blood");
    EXPECT_EQ(nameOf(patient::Tissue::bone), "bone");
    EXPECT_EQ(rows[200], -1);
    EXPECT_EQ(table.acoustics[std::size_t(table.acousticForHu(-100.0))].name, "fat");
    EXPECT_EQ(table.acoustics[std::size_t(table.acousticForHu(-3000.0))].name, "air");
    EXPECT_EQ(table.acoustics[std::size_t(table.acousticForHu(50.0))].name, "muscle");
}

TEST(Acoustics, RejectsInvalidTables) {
    const auto with = [](const char* from, const char* to) {
        return test::replaced(kGoodAcoustics, from, to);
    };
    EXPECT_NO_THROW(parseAcousticsText(kGoodAcoustics));
    std::string many = "roughness = 0\n";
    for (int i = 0; i <= kMaxAcoustics; ++i)
        many += row("t" + std::to_string(i));
    test::expectRefusals(parseAcousticsText,
                         {{with("impedance_mrayl = 1.6", "impedance_mrayl = -1"),
                           "tissues.toml: tissue[0].impedance_mrayl: -1 is not in [1e-05, 200]"},
                          {with("speed_m_per_s = 1540.0", "speed_m_per_s = nan"), "speed_m_per_s"},
                          {with("speed_m_per_s = 1540.0\n", ""), "missing"},
                          {with("scatter_db = -45.0", "scatter_db = \"dark\""), "scatter_db"},
                          {with("source = \"none\"", "source = \"\""), "source"},
                          {with("source = \"none\"", "solid = 1\nsource = \"none\""), "solid"},
                          {with("\"gel\"", "\"jelly\""), "'gel', which is needed"},
                          {kGoodAcoustics + row("liver"), "twice"},
                          {with("acoustic = \"liver\"", "acoustic = \"stone\""), "label[0].acoustic"},
                          {with("tissue = \"liver\"", "tissue = \"stone\""), "label[0].tissue"},
                          {with("tissue = \"liver\"\n", ""), "needs a tissue, a blood or a structure"},
                          {with("tissue = \"liver\"\n", "structure = \"stone\"\n"), "label[0].structure"},
                          {with("tissue = \"liver\"\n", "blood = \"liver\"\n"), "label[0].blood"},
                          {with("tissue = \"liver\"\n", "name = \"liver\"\n"), "label[0].name: labels are"},
                          {with("from_hu = -300.0", "from_hu = -1000.0"), "not ascending"},
                          {with("roughness = 0.1", "roughness = 2"), "roughness"},
                          {"roughness = 0.1\nhu = 3\n" + row("air") + row("gel") + row("steel"), "hu"},
                          {"tissue = [1, 2]", "tissue[0]: not a table"},
                          {"", "tissue"},
                          {"a = = b", "line 1"},
                          {with("source = \"none\"\n", "source = \"none\"\nwall_db = -30.0\n"), "wall_mm"},
                          {many, "more than 32"}});
}

TEST(Acoustics, MissingFileIsNamed) {
    const test::TempFolder folder;
    EXPECT_THROW(loadAcoustics(folder / "none.toml"), DataError);
    std::ofstream(folder / "big.toml") << std::string(2 << 20, '#');
    EXPECT_THROW(loadAcoustics(folder / "big.toml"), DataError);
}

}  // namespace
}  // namespace stylet::render
