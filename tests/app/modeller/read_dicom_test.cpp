// Reads DICOM folders with the real reader program. Accepted images have every voxel in its place. All
// others are refused with one sentence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/app/modeller/image_files.h"
#include "tests/app/modeller/run_model.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using test::DicomSlice;
using test::makeStack;
using test::reader;
using test::readError;
using test::TempFolder;
using test::writeStack;

// HZ-TEACH-03
TEST(ReadDicom, VoxelPositionsArePreserved) {
    TempFolder temp;
    // Three orientations: axial, axial prone, and sagittal with columns running downwards.
    const std::array<double, 6> orientations[] = {
        {1, 0, 0, 0, 1, 0}, {-1, 0, 0, 0, -1, 0}, {0, 1, 0, 0, 0, -1}};
    for (const auto& o : orientations) {
        const Vec3 row(o[0], o[1], o[2]), column(o[3], o[4], o[5]), normal = glm::cross(row, column);
        std::vector<DicomSlice> slices = makeStack(5);
        for (int k = 0; k < 5; ++k) {
            DicomSlice& s = slices[std::size_t(k)];
            const Vec3 p = Vec3(-30, 12, 100) + 2.5 * k * normal;
            s.position_mm = {p.x, p.y, p.z};
            s.orientation = o;
            s.spacing_mm = {0.5, 0.8};
            s.slope = 2.0, s.intercept = -1000.0;
        }
        const fs::path folder = temp / ("o" + std::to_string(&o - orientations));
        writeStack(folder, slices);
        const CtVolume ct = readImage(folder, ImageKind::ct, reader());
        ASSERT_EQ(ct.voxels.size(), 60u);
        for (int k = 0; k < 5; ++k)
            for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 4; ++i) {
                    const Vec3 lps = Vec3(-30, 12, 100) + 0.8 * i * row + 0.5 * j * column + 2.5 * k * normal;
                    const Vec3 ras = 1e-3 * Vec3(-lps.x, -lps.y, lps.z);
                    EXPECT_EQ(ct.nearestOr(ras, -9999), 2 * (i + 10 * j + 100 * k) - 1000);
                    const Vec3 off = ct.grid.toVoxels(ras) - glm::round(ct.grid.toVoxels(ras));
                    EXPECT_LT(glm::length(off), 1e-6);
                }
    }
}

// Applies the same change to every slice of a stack.
template <typename Change>
auto all(Change change) {
    return [change](std::vector<DicomSlice>& slices) {
        for (DicomSlice& s : slices)
            change(s);
    };
}

// Expects one sentence that starts with the folder, is short enough for a log line, and contains `words`.
void expectSentence(const std::string& why, const fs::path& folder, const char* words) {
    EXPECT_EQ(why.rfind(folder.string() + ": ", 0), 0u) << why;
    EXPECT_THAT(why, testing::HasSubstr(words));
    EXPECT_THAT(why, testing::Not(testing::HasSubstr("\n")));
    EXPECT_LT(why.size(), folder.string().size() + 600) << why;
}

template <typename Corrupt>
void expectStackRefused(Corrupt corrupt, const char* words) {
    TempFolder temp;
    std::vector<DicomSlice> slices = makeStack(6);
    corrupt(slices);
    writeStack(temp / "ct", slices);
    expectSentence(readError(temp / "ct"), temp / "ct", words);
}

TEST(ReadDicom, MissingSlicesAreRefused) {
    expectStackRefused(
        [](auto& s) { s.erase(s.begin() + 3); },
        "ImagePositionPatient (0020,0032): slices are missing between slice898 and slice897: a gap "
        "of 5 mm where 2.5 mm is usual");
    expectStackRefused([](auto& s) { s[3].position_mm[2] += 0.6; },
                       "the slice spacing is uneven: 3.1 mm between");
}

TEST(ReadDicom, DuplicateSlicesAreRefused) {
    expectStackRefused([](auto& s) { s.push_back(s[2]); }, "lie in the same place; remove one of them");
    expectStackRefused(
        [](auto& s) {
            for (int k = 0; k < 6; ++k)
                s.push_back(s[std::size_t(k)]);
        },
        "several phases or reconstructions; put one into a folder of its own");
}

TEST(ReadDicom, TiltedGantryIsRefusedWithItsAngle) {
    // The gantry is tilted by 15 degrees. The table still moves along z.
    expectStackRefused(
        [](auto& s) {
            for (DicomSlice& one : s)
                one.orientation = {1, 0, 0, 0, 0.9659258, -0.2588190};
        },
        "sheared by 15 degrees (a tilted gantry); export the series resampled to upright slices");
    expectStackRefused(
        [](auto& s) {
            for (int k = 0; k < 6; ++k)
                s[std::size_t(k)].position_mm[1] += 1.0 * k;
        },
        "sheared by 21.8 degrees");
}

TEST(ReadDicom, ObliqueOrientationsAreRefused) {
    expectStackRefused(
        [](auto& s) { s[4].orientation = {0, 1, 0, 0, 0, -1}; },
        "ImageOrientationPatient (0020,0037): lie at different angles; put the axial slices alone");
    expectStackRefused(all([](DicomSlice& s) { s.orientation = {0.9397, 0.3420, 0, -0.3420, 0.9397, 0}; }),
                       "tilted by more than 5 degrees (20 degrees)");
}

TEST(ReadDicom, FewerThanThreeSlicesAreRefused) {
    expectStackRefused([](auto& s) { s.resize(1); }, "only 1 slice; a volume needs three");
    expectStackRefused([](auto& s) { s.resize(2); }, "only 2 slices; a volume needs three");
}

TEST(ReadDicom, OtherModalitiesAreRefused) {
    expectStackRefused(all([](DicomSlice& s) { s.modality = "MR"; }),
                       "Modality (0008,0060): modality MR, not CT");
}

TEST(ReadDicom, MissingTagsAreNamed) {
    const auto without = [](std::uint32_t tag) {
        return all([tag](DicomSlice& s) { s.without.insert(tag); });
    };
    expectStackRefused(without(0x00200032), "ImagePositionPatient (0020,0032): is missing");
    expectStackRefused(without(0x00200037), "ImageOrientationPatient (0020,0037): is missing");
    expectStackRefused(without(0x00280030), "PixelSpacing (0028,0030): is missing");
}

TEST(ReadDicom, OutOfRangeValuesAreNamed) {
    for (const double slope : {0.0, -1.0, 1e9, 1e-9, double(NAN)})
        expectStackRefused(all([slope](DicomSlice& s) { s.slope = slope; }), "RescaleSlope (0028,1053): ");
    for (const double intercept : {1e6, -1e9, double(INFINITY)})
        expectStackRefused(all([intercept](DicomSlice& s) { s.intercept = intercept; }),
                           "RescaleIntercept (0028,1052): ");
    expectStackRefused([](auto& s) { s[5].spacing_mm = {0.9, 0.9}; },
                       "PixelSpacing (0028,0030): their pixel spacing");
    expectStackRefused(all([](DicomSlice& s) { s.spacing_mm = {80.0, 80.0}; }),
                       "spacing of 80 mm is outside");
    expectStackRefused(all([](DicomSlice& s) { s.spacing_mm = {0.001, 0.001}; }),
                       "spacing of 0.001 mm is outside");
    expectStackRefused([](auto& s) { s[1].columns = 3, s[1].rows = 4; },
                       "Rows and Columns (0028,0010): differ");
    expectStackRefused(all([](DicomSlice& s) { s.columns = 60000, s.rows = 60000; }),
                       "size: a side of 60000 voxels");
    expectStackRefused(all([](DicomSlice& s) {
                           s.frames = 3;
                           const auto once = s.stored;
                           for (int k = 1; k < 3; ++k)
                               s.stored.insert(s.stored.end(), once.begin(), once.end());
                       }),
                       "NumberOfFrames (0028,0008): holds several frames");
}

// A study as a hospital delivers it: a scout, two phases and a dose report.
TEST(ReadDicom, MultipleSeriesAreListedAndOneCanBeSelected) {
    TempFolder temp;
    std::vector<DicomSlice> portal = makeStack(5), arterial = makeStack(4), scout = makeStack(1),
                            report = makeStack(1);
    for (DicomSlice& s : portal)
        s.series = "1.2.3.77", s.description = "Abdomen portal venous", s.intercept = 7.0;
    for (DicomSlice& s : arterial)
        s.series = "1.2.3.55", s.description = "Abdomen arterial";
    scout[0].series = "1.2.3.11", scout[0].without = {0x00200032, 0x00200037};
    report[0].sop_class = "1.2.840.10008.5.1.4.1.1.88.67", report[0].modality = "SR";
    report[0].without = {0x00280010, 0x00280011};
    writeStack(temp / "ct" / "portal", portal);
    writeStack(temp / "ct" / "arterial", arterial);
    writeStack(temp / "ct" / "scout", scout);
    writeStack(temp / "ct" / "report", report);

    const std::string why = readError(temp / "ct");
    expectSentence(why, temp / "ct",
                   "holds 3 series; choose one with --series UID, or put it into a folder of its own: "
                   "1.2.3.77 (CT, 5 slices, \"Abdomen portal "
                   "venous\"), 1.2.3.55 (CT, 4 slices, \"Abdomen arterial\"), 1.2.3.11 (CT, 1 slice)");

    const CtVolume ct = readImage(temp / "ct", ImageKind::ct, reader(), "1.2.3.77");
    EXPECT_EQ(ct.grid.dims, Index3(4, 3, 5));
    EXPECT_EQ(*std::min_element(ct.voxels.begin(), ct.voxels.end()), 7);
    EXPECT_EQ(readImage(temp / "ct", ImageKind::ct, reader(), "1.2.3.55").grid.dims.z, 4);
    const auto chosen = [&](const char* uid) { return readError(temp / "ct", ImageKind::ct, reader(), uid); };
    expectSentence(chosen("1.2.3.99"), temp / "ct", "holds no series \"1.2.3.99\"; it holds 1.2.3.77 (CT");
    expectSentence(chosen("1.2.3.11"), temp / "ct", "ImagePositionPatient (0020,0032): is missing");
}

// Even a long list of series must fit into the sentence that the parent process quotes.
TEST(ReadDicom, LongSeriesListIsTruncated) {
    TempFolder temp;
    for (int i = 0; i < 30; ++i) {
        std::vector<DicomSlice> one = makeStack(1);
        one[0].series =
            "1.2.840.113619.2.55.3.2831868886.135.1258106417.8888888888." + std::to_string(10 + i);
        one[0].description = std::string(60, 'x');
        writeStack(temp / "ct" / std::to_string(i), one);
    }
    const std::string why = readError(temp / "ct");
    EXPECT_THAT(why, testing::HasSubstr("holds 30 series"));
    EXPECT_EQ(why.substr(why.size() - 11), "and 24 more") << why;
}

TEST(ReadDicom, RunLengthCompressionIsRead) {
    TempFolder temp;
    std::vector<DicomSlice> slices = makeStack(4);
    for (DicomSlice& s : slices)
        s.run_length = true, s.syntax = test::kRunLength;
    writeStack(temp / "ct", slices);
    const CtVolume ct = readImage(temp / "ct", ImageKind::ct, reader());
    std::vector<std::int16_t> sorted = ct.voxels, stored;
    for (const DicomSlice& s : slices)
        stored.insert(stored.end(), s.stored.begin(), s.stored.end());
    std::sort(sorted.begin(), sorted.end());
    std::sort(stored.begin(), stored.end());
    EXPECT_EQ(sorted, stored);

    std::vector<char> cut = test::dicomBytes(slices[2]);
    cut.resize(cut.size() - 24);
    test::writeFile(temp / "ct" / "slice898", cut);
    expectSentence(readError(temp / "ct"), temp / "ct", "slice898: its ");
}

TEST(ReadDicom, UnsupportedCompressionIsNamed) {
    TempFolder temp;
    std::vector<DicomSlice> slices = makeStack(4);
    for (DicomSlice& s : slices)
        s.run_length = true, s.syntax = "1.2.840.10008.1.2.4.102";  // MPEG-4
    writeStack(temp / "ct", slices);
    expectSentence(
        readError(temp / "ct"), temp / "ct",
        "(TransferSyntaxUID (0002,0010) is 1.2.840.10008.1.2.4.102); export it again, uncompressed");
}

// Runs the commands. They print one line with the reason and create neither a patient nor stages.
TEST(ReadDicom, RefusedScanLeavesNoFiles) {
    TempFolder temp;
    std::vector<DicomSlice> gap = makeStack(6);
    gap.erase(gap.begin() + 2);
    writeStack(temp / "gap", gap);
    writeStack(temp / "lifted", makeStack(6));  // its values start at 0
    std::ofstream(temp / "map.csv") << "source_id,tissue\n1,liver\n";
    const auto errorOutput = [&](const std::string& command, const char* ct) {
        const test::ModelRun run = test::runModel(command + " --ct '" + (temp / ct).string() + "' --out '" +
                                                  (temp / "out").string() + "'");
        EXPECT_EQ(run.status, 2) << command;
        EXPECT_FALSE(fs::exists(temp / "out"));
        EXPECT_FALSE(fs::exists(temp / "out-stages"));
        return run.err;
    };
    const std::string import = "import --labels '" + (temp / "labels.nii").string() + "' --map '" +
                               (temp / "map.csv").string() + "'";
    for (const std::string& command : {std::string("build"), import}) {
        EXPECT_THAT(errorOutput(command, "gap"), testing::HasSubstr("slices are missing between"));
        EXPECT_THAT(errorOutput(command, "lifted"),
                    testing::HasSubstr("voxels: the lowest value is 0, but air or lung shows below"));
        EXPECT_THAT(errorOutput(command + " --series 1.2.3.9", "gap"),
                    testing::HasSubstr("holds no series \"1.2.3.9\""));
    }
}

TEST(ReadDicom, EmptyAndForeignFoldersAreRefused) {
    TempFolder temp;
    fs::create_directories(temp / "ct");
    EXPECT_THAT(readError(temp / "ct"), testing::HasSubstr("no DICOM slice among its 0 files"));
    std::ofstream(temp / "ct" / "notes.txt") << "nothing medical";
    EXPECT_THAT(readError(temp / "ct"), testing::HasSubstr("no DICOM slice among its 1 files"));
    EXPECT_THAT(readError(temp / "nowhere"), testing::HasSubstr("no such file"));
}

// HZ-RECORD-14
TEST(ReadDicom, HostileFilesAreRefusedWithAMessage) {
    const std::vector<char> good = test::dicomBytes(makeStack(1)[0]);
    std::uint32_t seed = 12345;
    const auto random = [&] { return seed = seed * 1664525u + 1013904223u; };
    for (int round = 0; round < 24; ++round) {
        TempFolder temp;
        writeStack(temp / "ct", makeStack(4));
        std::vector<char> bad = good;
        if (round < 8) {
            bad.resize(132 + (good.size() - 133) * std::size_t(round) / 8);  // truncated
        } else if (round < 16) {
            for (std::size_t i = 132; i < bad.size(); ++i)
                bad[i] = char(random() >> 24);  // garbage
        } else {
            for (int hits = 0; hits < 12; ++hits)  // corrupt lengths and tags
                bad[132 + random() % (bad.size() - 132)] = char(random() >> 24);
        }
        test::writeFile(temp / "ct" / "slice900", bad);
        try {
            const CtVolume ct = readImage(temp / "ct", ImageKind::ct, reader());
            EXPECT_GE(round, 16) << "a slice that is cut short or garbage was taken";
            EXPECT_EQ(ct.voxels.size(), 48u);
        } catch (const ImportError& e) {
            EXPECT_GT(std::string(e.what()).size(), (temp / "ct").string().size() + 10) << e.what();
        }
    }
}

}  // namespace
}  // namespace stylet::modeller
