// Arguments of stylet-model that are refused before the work begins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/app/modeller/run_model.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void expectRefused(const std::string& arguments, const std::string& words) {
    const test::ModelRun run = test::runModel(arguments);
    EXPECT_GT(run.status, 0) << arguments;
    EXPECT_THAT(run.err, HasSubstr(words)) << arguments;
}

TEST(CommandLine, NanIsNoNumber) {
    const std::string spacing = "--spacing-mm: nan is not in 0.5 to ";
    const test::TempFolder temp;
    const std::string out = " --out " + (temp / "out").string();
    expectRefused("synth --seed 7 --spacing-mm nan" + out, spacing);
    expectRefused("slices --seed 7 --spacing-mm nan" + out, spacing);
    expectRefused("check --seeds 7 --spacing-mm nan", spacing);
    expectRefused("import --ct none --labels none --map none --spacing-mm nan" + out, spacing);
    expectRefused("build --ct none --spacing-mm nan" + out, spacing);
    expectRefused("motion --template --package none --dome-mm nan" + out, "--dome-mm: nan is not in 0 to 25");
    expectRefused("motion --phases none --spacing-mm nan" + out, "--spacing-mm: nan is not in 0.1 to 10");
    expectRefused("motion --phases none --period-s nan" + out, "--period-s: nan is not in 1 to 20");
    EXPECT_FALSE(fs::exists(temp / "out"));
}

TEST(CommandLine, AFolderOfOtherFilesIsRefusedAtOnce) {
    const test::TempFolder temp;
    fs::create_directory(temp / "mine");
    std::ofstream(temp / "mine" / "thesis.txt") << "mine";
    for (const fs::path& out : {temp / "mine", temp / "mine" / "thesis.txt"}) {
        const std::string words = out.string() + ": folder: exists and is not a patient package",
                          to = " --out " + out.string();
        expectRefused("build --ct none" + to, words);
        expectRefused("import --ct none --labels none --map none" + to, words);
        expectRefused("motion --template --package none" + to, words);
        expectRefused("synth --seed 7" + to, words);
    }
}

// A package replaces its folder, with all files in it.
TEST(CommandLine, InputsInsideTheOutputAreRefused) {
    const test::TempFolder temp;
    const fs::path truth = temp / "truth", other = temp / "truth-stages";
    for (const fs::path& folder : {truth, other})
        fs::create_directory(folder);
    std::ofstream(truth / "patient.toml") << "";
    const auto refused = [&](const std::string& arguments, const fs::path& input) {
        for (const std::string& out :
             {truth.string(), truth.string() + "/", (other / ".." / "truth").string()})
            expectRefused(arguments + " --out " + out,
                          out + ": --out: would replace " + input.string() + ", which is read");
    };
    const fs::path ct = truth / "ct.nii.gz";
    refused("build --ct " + ct.string(), ct);
    refused("build --ct none --atlas none " + truth.string(), truth);
    refused("build --ct none --stages " + (truth / "stages").string(), truth / "stages");
    refused("import --ct none --map none --labels " + ct.string(), ct);
    refused("motion --template --package " + truth.string(), truth);
    refused("motion --phases " + (truth / "phases").string(), truth / "phases");
    // The stages lie beside the package, even if its name ends in a slash.
    const test::ModelRun run = test::runModel("build --ct none --out " + truth.string() + "/");
    EXPECT_GT(run.status, 0);
    EXPECT_THAT(run.err, testing::Not(HasSubstr("--out")));
}

TEST(CommandLine, AFolderThatCannotBeMadeIsNamed) {
    const test::TempFolder temp;
    std::ofstream(temp / "file") << "";
    const std::string out = (temp / "file" / "pictures").string();
    expectRefused("slices none --out " + out, out + ": --out: cannot be made: Not a directory");
    expectRefused("synth --seed 7 --spacing-mm 5 --out " + out + "/patient",
                  out + ": folder: cannot be made: Not a directory");
}

}  // namespace
}  // namespace stylet::modeller
