#include "render/volume/look.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "render/volume/classified.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/render/refusal.h"
#include "tests/support/temp_folder.h"

namespace stylet::render {
namespace {

constexpr char kSurface[] =
    "[surface]\nwrap = 0\nspecular = 0\nspecular_power = 1\nrim = 0\ngradient_voxels = 1\nsmoothing_voxels = "
    "1\nedge_low = 0\nedge_high = 1\ngrazing_tint = "
    "\"#ffffff\"\n";
constexpr char kCurve[] =
    "[[hu]]\nhu = 0\nextinction_per_mm = 0\ncolour = \"#ffffff\"\n[[hu]]\nhu = 100\nextinction_per_mm = "
    "2\ncolour = "
    "\"#ff0000\"\n";

class LookFile : public testing::Test {
  protected:
    LookStyle load(const std::string& text) {
        const auto file = folder_ / "look.toml";
        std::ofstream(file) << text;
        return loadLook(file);
    }
    test::TempFolder folder_;
};

TEST_F(LookFile, TheShippedLooksLoad) {
    std::set<std::string> names;
    for (const auto& file : std::filesystem::directory_iterator(test::assetsFolder() / "looks")) {
        EXPECT_EQ(loadLook(file).name, file.path().stem());
        names.insert(file.path().stem());
    }
    EXPECT_TRUE(names.contains("closed") && names.contains("reveal"));
}

TEST_F(LookFile, StoresRootsSoThatTheRampIsLinear) {
    const patient::Package package = test::makeBall(patient::Tissue::liver, 0.01, 0.005, 0.002);
    const patient::Patient patient(package);
    const Palette palette = makePalette(load(std::string(kSurface) + kCurve), patient);
    EXPECT_FLOAT_EQ(palette.at(-500, 0).a, 0.0f);
    EXPECT_FLOAT_EQ(palette.at(50, 0).a, 0.5f);
    EXPECT_FLOAT_EQ(palette.at(100, 0).a, 1.0f);
    EXPECT_FLOAT_EQ(palette.at(3000, 0).r, 1.0f);
    EXPECT_FLOAT_EQ(palette.at(3000, 0).g, 0.0f);
}

TEST_F(LookFile, FirstMatchingRuleWins) {
    const patient::Package package = test::makeBall(patient::Tissue::liver, 0.01, 0.005, 0.002);
    const patient::Patient patient(package);
    const Palette palette =
        makePalette(load(std::string(kSurface) + kCurve +
                         "[[rule]]\ntissue = \"bone\"\nextinction_per_mm = 8\ncolour = \"#00ff00\"\n"
                         "[[rule]]\ntissue = \"soft\"\nextinction_per_mm = 2\ncolour = \"#0000ff\"\n"
                         "[[rule]]\ntissue = \"liver\"\ncolour = \"#00ff00\"\n"),
                    patient);
    const auto id = [](patient::Tissue t) { return std::uint8_t(t); };  // labels of the phantoms
    EXPECT_EQ(palette.at(0, id(patient::Tissue::bone)), glm::vec4(0, 1, 0, 1));
    EXPECT_EQ(palette.at(0, id(patient::Tissue::soft)), glm::vec4(0, 0, 0.5, 0.5));
    EXPECT_EQ(palette.at(0, id(patient::Tissue::liver)), glm::vec4(0, 0, 0, 0));  // transparent at 0 HU
    EXPECT_EQ(palette.at(100, id(patient::Tissue::liver)),
              glm::vec4(0, 0.5, 0, 0.5));  // opacity from the curve
}

TEST_F(LookFile, RejectsInvalidLooks) {
    const std::string good = std::string(kSurface) + kCurve;
    EXPECT_NO_THROW(load(good));
    test::expectRefusals(
        [&](const std::string& text) { load(text); },
        {{"", "hu"},
         {good + "[[hu]]\nhu = 50\nextinction_per_mm = 1\ncolour = \"#ffffff\"\n", "not ascending"},
         {good + "[[rule]]\ntissue = \"stone\"\n", "rule[0].tissue"},
         {good + "[[rule]]\nblood = \"blue\"\n", "rule[0].blood"},
         {good + "[[rule]]\nstructure = \"Lung\"\n", "rule[0].structure"},
         {good + "[[rule]]\nname = \"lung\"\n", "rule[0].name: labels are not selected by name"},
         {good + "[[rule]]\ncolour = \"red\"\n", "rule[0].colour"},
         {good + "[[rule]]\nextinction_per_mm = -1\n", "extinction_per_mm"},
         {good + "[[rule]]\nextinction_per_mm = nan\n", "extinction_per_mm"},
         {kCurve, "surface.wrap"},
         {"rule = 3 =", "line 1"}});
}

// The smoothing filter preserves the sum of opacities, and two threads give the same bytes as one.
TEST_F(LookFile, SmoothingPreservesTheSumAndIsIndependentOfThreads) {
    const patient::Package package = test::makeBall(patient::Tissue::liver, 0.010, 0.006, 0.001);
    const patient::Patient patient(package);
    const Palette palette = makePalette(
        load(std::string(kSurface) + kCurve + "[[rule]]\ntissue = \"liver\"\nextinction_per_mm = 2\n"),
        patient);
    const Index3 dims = package.ct.grid.dims;
    std::vector<std::byte> one(package.ct.grid.voxelCount() * 4), two = one;
    classifyPlanes(patient, palette, 0, dims.z, one.data(), 1);
    classifyPlanes(patient, palette, 0, 7, two.data(), 2);
    classifyPlanes(patient, palette, 7, dims.z, two.data() + std::size_t(7 * dims.x * dims.y) * 4, 2);
    EXPECT_EQ(one, two);
    double sum = 0.0, voxels = 0.0;
    for (std::size_t i = 0; i < package.labels.voxels.size(); ++i) {
        sum += double(std::uint8_t(one[i * 4 + 3])) / 255.0;
        voxels += double(palette.at(package.ct.voxels[i], package.labels.voxels[i]).a);
    }
    EXPECT_NEAR(sum / voxels, 1.0, 0.01);
}

}  // namespace
}  // namespace stylet::render
