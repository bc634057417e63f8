#include "render/ultrasound/acoustics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
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

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string acousticsRefusal(const std::string& text) {
    try {
        parseAcoustics("tissues.toml", text);
    } catch (const DataError& e) {
        return e.what();
    }
    return "";
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
TEST(Acoustics, TheShippedTableHasTheModelsLosses) {
    const AcousticTable table = loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml");
    EXPECT_NEAR(echo_db(table, "fat", "muscle"), -19.7, 0.05);
    EXPECT_NEAR(echo_db(table, "liver", "bile"), -25.3, 0.05);
    EXPECT_NEAR(echo_db(table, "liver", "bone"), -3.7, 0.05);
    EXPECT_GT(echo_db(table, "liver", "gas"), -0.01);
    EXPECT_NEAR(named(table, "liver").attenuation_db_per_m_mhz, 70.0, 1e-9);
}

// HZ-TEACH-19
TEST(Acoustics, EveryLabelOfThePhantomFindsItsTissue) {
    const AcousticTable table = loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml");
    const patient::Package package = test::makeTrunk(0.008);
    const patient::Patient patient(package);
    const auto rows = acousticsOfLabels(table, patient);
    const auto nameOf = [&](patient::Tissue t) {
        return table.acoustics[std::size_t(rows[std::size_t(t)])].name;
    };
    EXPECT_EQ(nameOf(patient::Tissue::liver), "liver");
    EXPECT_EQ(nameOf(patient::Tissue::duct), "bile");
    EXPECT_EQ(nameOf(patient::Tissue::vessel), "blood");
    EXPECT_EQ(nameOf(patient::Tissue::bone), "bone");
    EXPECT_EQ(rows[200], -1);
    EXPECT_EQ(table.acoustics[std::size_t(table.classOf(-100.0))].name, "fat");
    EXPECT_EQ(table.acoustics[std::size_t(table.classOf(-3000.0))].name, "air");
    EXPECT_EQ(table.acoustics[std::size_t(table.classOf(50.0))].name, "muscle");
}

TEST(Acoustics, RefusesWhatItCannotMean) {
    EXPECT_EQ(acousticsRefusal(kGoodAcoustics), "");
    EXPECT_EQ(acousticsRefusal(replaced(kGoodAcoustics, "impedance_mrayl = 1.6", "impedance_mrayl = -1")),
              "tissues.toml: tissue[0].impedance_mrayl: -1 is not in [1e-05, 200]");
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "speed_m_per_s = 1540.0", "speed_m_per_s = nan"))
                  .find("speed_m_per_s"),
              std::string::npos);
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "speed_m_per_s = 1540.0\n", "")).find("missing"),
              std::string::npos);
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "scatter_db = -45.0", "scatter_db = \"dark\""))
                  .find("scatter_db"),
              std::string::npos);
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "source = \"none\"", "source = \"\"")).find("source"),
              std::string::npos);
    EXPECT_NE(
        acousticsRefusal(replaced(kGoodAcoustics, "\"gel\"", "\"jelly\"")).find("'gel', which is needed"),
        std::string::npos);
    EXPECT_NE(acousticsRefusal(kGoodAcoustics + row("liver")).find("twice"), std::string::npos);
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "acoustic = \"liver\"", "acoustic = \"stone\""))
                  .find("label[0].acoustic"),
              std::string::npos);
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "tissue = \"liver\"", "tissue = \"stone\""))
                  .find("label[0].tissue"),
              std::string::npos);
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "tissue = \"liver\"\n", ""))
                  .find("needs a tissue or a name"),
              std::string::npos);
    EXPECT_NE(acousticsRefusal(replaced(kGoodAcoustics, "from_hu = -300.0", "from_hu = -1000.0"))
                  .find("not ascending"),
              std::string::npos);
    EXPECT_NE(
        acousticsRefusal(replaced(kGoodAcoustics, "roughness = 0.1", "roughness = 2")).find("roughness"),
        std::string::npos);
    EXPECT_NE(
        acousticsRefusal("roughness = 0.1\nhu = 3\n" + row("air") + row("gel") + row("steel")).find("hu"),
        std::string::npos);
    EXPECT_NE(acousticsRefusal("tissue = [1, 2]").find("tissue[0]: not a table"), std::string::npos);
    EXPECT_NE(acousticsRefusal("").find("tissue"), std::string::npos);
    EXPECT_NE(acousticsRefusal("a = = b").find("line 1"), std::string::npos);
    EXPECT_NE(acousticsRefusal(
                  replaced(kGoodAcoustics, "source = \"none\"\n", "source = \"none\"\nwall_db = -30.0\n"))
                  .find("wall_mm"),
              std::string::npos);
    std::string many = "roughness = 0\n";
    for (int i = 0; i <= kMostAcoustics; ++i)
        many += row("t" + std::to_string(i));
    EXPECT_NE(acousticsRefusal(many).find("more than 32"), std::string::npos);
}

TEST(Acoustics, AFileThatIsNotThereIsNamed) {
    const test::TempFolder folder;
    EXPECT_THROW(loadAcoustics(folder / "none.toml"), DataError);
    std::ofstream(folder / "big.toml") << std::string(2 << 20, '#');
    EXPECT_THROW(loadAcoustics(folder / "big.toml"), DataError);
}

}  // namespace
}  // namespace stylet::render
