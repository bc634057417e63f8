// Stored results of the build stages, and a user's changes to them.
#include "app/modeller/segmentation/stage_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>

#include "app/modeller/image/import_error.h"
#include "app/modeller/import/import_map.h"
#include "base/errors.h"
#include "patient/package/nifti.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;

const Grid kStageGrid{{12, 10, 8}, Vec3(0.002), Vec3(-0.01, 0.0, 0.03)};

struct StageStoreTest : testing::Test {
    void SetUp() override {
        result.labels[{3, 4, 5}] = 18;
        result.text = "r 12\n";
        result.record = {0xfedcba9876543210u, 1.5, false, {"a note", "another"}};
        result.record.atlases = {"reference patient, seed 11", "A\n\", \"B"};
        result.record.virtual_ducts = true;
        store.save(7, "liver", result, CtVolume(kStageGrid), targetTable(), "points.txt");
    }
    fs::path folder() const { return store.stageFolder(7, "liver"); }
    std::optional<StageResult> load() const { return store.load(7, "liver", kStageGrid, "points.txt"); }

    test::TempFolder temp;
    StageStore store{temp.path() / "stages"};
    StageResult result{.labels = LabelVolume(kStageGrid), .text = {}, .record = {}};
};

TEST_F(StageStoreTest, StageSurvivesARoundTrip) {
    const auto again = load();
    ASSERT_TRUE(again);
    EXPECT_EQ(again->labels.voxels, result.labels.voxels);
    EXPECT_EQ(again->labels.grid, kStageGrid);
    EXPECT_EQ(again->text, result.text);
    EXPECT_FALSE(again->text_edited);
    EXPECT_EQ(again->record.key, result.record.key);
    EXPECT_EQ(again->record.seconds, 1.5);
    EXPECT_FALSE(again->record.corrected);
    EXPECT_EQ(again->record.notes, result.record.notes);
    EXPECT_EQ(again->record.atlases, result.record.atlases);
    EXPECT_TRUE(again->record.virtual_ducts);
    EXPECT_FALSE(again->record.labels_replaced);
    EXPECT_EQ(resultDigest(*again), resultDigest(result));
    for (const char* file : {"labels.ctbl", "axial.png", "axial-labels.png", "coronal.png", "sagittal.png"})
        EXPECT_TRUE(fs::exists(folder() / file)) << file;
    EXPECT_EQ(folder().filename(), "07-liver");
}

TEST_F(StageStoreTest, StageWithoutRecordIsUnfinished) {
    fs::remove(folder() / "stage.json");
    EXPECT_FALSE(load());
    EXPECT_FALSE(store.load(8, "vessels", kStageGrid, ""));
}

TEST_F(StageStoreTest, EditedLabelsAreMarkedCorrected) {
    LabelVolume edited = result.labels;
    edited[{1, 1, 1}] = 18;
    patient::writeNifti(folder() / "labels.nii.gz", edited);
    const auto again = load();
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->record.corrected);
    EXPECT_FALSE(again->text_edited);
    EXPECT_EQ(again->labels.voxels, edited.voxels);
}

TEST_F(StageStoreTest, ChangedLabelsAreFound) {
    const auto changed = [&](std::uint8_t inside, std::uint8_t elsewhere) {
        LabelVolume edited = result.labels;
        edited[{3, 4, 5}] = inside, edited[{1, 1, 1}] = elsewhere;
        patient::writeNifti(folder() / "labels.nii.gz", edited);
        std::vector<int> ids;
        const std::array<bool, 256> all = load()->changed.value();
        for (int id = 0; id < 256; ++id)
            if (all[std::size_t(id)]) ids.push_back(id);
        return ids;
    };
    EXPECT_THAT(changed(18, 18), testing::ElementsAre(18));  // grown
    EXPECT_THAT(changed(18, 7), testing::ElementsAre(7));    // another one painted
    EXPECT_THAT(changed(7, 0), testing::ElementsAre(7));     // painted over it
    EXPECT_THAT(changed(0, 0), testing::ElementsAre(18));    // erased
    // Labels passed on the command line are compared with those of the program too.
    StageResult replaced = *load();
    replaced.record.labels_replaced = true;
    store.save(7, "liver", replaced, CtVolume(kStageGrid), targetTable(), "points.txt");
    EXPECT_FALSE(load()->labels_edited);
    EXPECT_TRUE(load()->changed.value()[18]);
    fs::remove(folder() / "automatic.nii.gz");
    EXPECT_FALSE(load()->changed);
}

TEST_F(StageStoreTest, EditedTextIsDetected) {
    std::ofstream(folder() / "points.txt") << "r 13\n";
    const auto again = load();
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->text_edited);
    EXPECT_FALSE(again->record.corrected);
}

// HZ-TEACH-07
TEST_F(StageStoreTest, OnAnotherGridOnlyEditedTextIsKept) {
    const Grid finer{kStageGrid.dims * 2, kStageGrid.spacing_m * 0.5, kStageGrid.origin_m};
    EXPECT_FALSE(store.load(7, "liver", finer, "points.txt"));
    std::ofstream(folder() / "points.txt") << "r 13\n";
    const auto again = store.load(7, "liver", finer, "points.txt");
    ASSERT_TRUE(again);
    EXPECT_EQ(again->text, "r 13\n");
    EXPECT_EQ(again->labels.grid.dims, finer.dims);
}

// HZ-RECORD-07
TEST_F(StageStoreTest, DamagedFilesAreNamed) {
    const auto why = [&] { return test::errorText<DataError>([&] { load(); }); };
    std::vector<std::string> damaged{"", "{", "[]", R"({"key": "xyz"})", R"({"key": 1})"};
    StageFile odd;
    odd.record.seconds = -1.0;
    damaged.push_back(writeStageFile(odd));
    odd.record = {};
    std::string minus = writeStageFile(odd);
    damaged.push_back(minus.replace(minus.find("\"0000"), 3, "\"-0"));
    minus = writeStageFile(odd);
    const std::string notes = "\"notes\": []";
    damaged.push_back(minus.replace(minus.find(notes), notes.size(), "\"notes\": [\"a \\u001b[31m note\"]"));
    for (const auto& [from, to] :
         {std::pair{"\"virtual_ducts\": false", "\"virtual_ducts\": \"no\""},
          std::pair{"\"virtual_ducts\"", "\"virtual_tubes\""},
          std::pair{"\"labels_replaced\": false", "\"labels_replaced\": true"},
          std::pair{"\"atlases\": []", "\"atlases\": \"A\""},
          std::pair{"\"atlases\": []", "\"atlases\": [1]"}, std::pair{"\"atlases\": [],", ""},
          std::pair{"\"atlases\"", "\"colour\": 1, \"atlases\""}}) {
        minus = writeStageFile(odd);
        damaged.push_back(minus.replace(minus.find(from), std::strlen(from), to));
    }
    for (const std::string& text : damaged) {
        std::ofstream(folder() / "stage.json") << text;
        EXPECT_THAT(why(), testing::HasSubstr("stage.json: file: is damaged")) << text;
    }
    store.save(7, "liver", result, CtVolume(kStageGrid), targetTable(), "points.txt");
    patient::writeNifti(folder() / "labels.nii.gz", LabelVolume({{2, 2, 2}, Vec3(0.002), {}}));
    EXPECT_THAT(why(), testing::HasSubstr("labels.nii.gz: dim:"));
}

// A note may quote names from files. Control characters and invalid UTF-8 in it must not damage the record.
// HZ-RECORD-11
TEST_F(StageStoreTest, NotesAreKeptOnOneLine) {
    StageFile file;
    file.record.notes = {"atlases: \"A\nB\033[31m\"", "\xff"};
    const StageFile again = parseStageFile("stage.json", writeStageFile(file));
    ASSERT_EQ(again.record.notes.size(), 2u);
    EXPECT_EQ(again.record.notes[0], "atlases: \"A B [31m\"");
}

// Notes are for people: texts that earlier versions parsed change nothing.
TEST_F(StageStoreTest, NotesCarryNoResults) {
    StageFile file;
    file.record.notes = {"atlases: \"A\"", "these ducts are virtual: bile is painted into the CT",
                         "corrected by hand"};
    const StageFile again = parseStageFile("stage.json", writeStageFile(file));
    EXPECT_TRUE(again.record.atlases.empty());
    EXPECT_FALSE(again.record.virtual_ducts || again.record.labels_replaced || again.record.corrected);
}

TEST_F(StageStoreTest, FileInPlaceOfTheFolderIsRefused) {
    std::ofstream(temp.path() / "file") << "x";
    EXPECT_THROW(StageStore(temp.path() / "file" / "below"), ImportError);
}

}  // namespace
}  // namespace stylet::modeller
