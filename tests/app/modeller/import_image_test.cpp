#include "app/modeller/import_image.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "app/modeller/image_handover.h"
#include "dicom_bytes.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using patient::Vec3;
using test::DicomSlice;
using test::TempFolder;

ReaderLimits reader() {
    ReaderLimits limits;
    limits.program = fs::path(std::getenv("STYLET_BIN")) / "stylet-image-reader";
    limits.wall_s = 30;
    return limits;
}

// What reading says when it refuses; empty when it does not.
std::string refusal(const fs::path& path, ImageKind kind, const ReaderLimits& limits) {
    try {
        readImage(path, kind, limits);
    } catch (const ImportError& e) {
        return e.what();
    }
    return "";
}
std::string refusal(const fs::path& path) {
    return refusal(path, ImageKind::ct, reader());
}

// A stack of `count` slices, 2.5 mm apart, whose stored values tell column, row and slice.
std::vector<DicomSlice> stack(int count) {
    std::vector<DicomSlice> slices;
    for (int k = 0; k < count; ++k) {
        DicomSlice s;
        s.position_mm = {-30.0, 12.0, 100.0 + 2.5 * k};
        s.instance = "1.2.3.4." + std::to_string(k + 1);
        for (int j = 0; j < s.rows; ++j)
            for (int i = 0; i < s.columns; ++i)
                s.stored.push_back(std::int16_t(i + 10 * j + 100 * k));
        slices.push_back(s);
    }
    return slices;
}

void writeStack(const fs::path& folder, const std::vector<DicomSlice>& slices) {
    fs::create_directories(folder);
    // File names run against the slices' order: only the position may decide.
    for (std::size_t k = 0; k < slices.size(); ++k)
        test::writeFile(folder / ("slice" + std::to_string(900 - k)), test::dicomBytes(slices[k]));
}

TEST(ImportImage, DicomKeepsEveryVoxelInItsPlace) {
    TempFolder temp;
    // Three orientations: axial, axial lying prone, sagittal with columns running down.
    const std::array<double, 6> orientations[] = {
        {1, 0, 0, 0, 1, 0}, {-1, 0, 0, 0, -1, 0}, {0, 1, 0, 0, 0, -1}};
    for (const auto& o : orientations) {
        const Vec3 row(o[0], o[1], o[2]), column(o[3], o[4], o[5]), normal = glm::cross(row, column);
        std::vector<DicomSlice> slices = stack(5);
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
        const patient::CtVolume ct = readImage(folder, ImageKind::ct, reader());
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

TEST(ImportImage, AMissingSliceIsNamed) {
    TempFolder temp;
    std::vector<DicomSlice> slices = stack(6);
    slices.erase(slices.begin() + 3);
    writeStack(temp / "ct", slices);
    const std::string why = refusal(temp / "ct");
    EXPECT_NE(why.find("slices are missing between"), std::string::npos) << why;
    EXPECT_NE(why.find("5 mm where 2.5 mm"), std::string::npos) << why;
}

TEST(ImportImage, WhatIsNotOneUprightCtSeriesIsRefusedInWords) {
    const auto spoiled = [](auto&& spoil) {
        TempFolder temp;
        std::vector<DicomSlice> slices = stack(6);
        spoil(slices);
        writeStack(temp / "ct", slices);
        return refusal(temp / "ct");
    };
    const auto expect = [&](auto&& spoil, const char* words) {
        const std::string why = spoiled(spoil);
        EXPECT_NE(why.find(words), std::string::npos) << "wanted: " << words << "\ngot: " << why;
    };
    expect([](auto& s) { s[2].series = "1.2.3.5"; }, "holds 2 series");
    expect(
        [](auto& s) {
            for (auto& one : s)
                one.modality = "MR";
        },
        "modality MR, not CT");
    expect([](auto& s) { s[3].position_mm = s[2].position_mm; }, "lie in the same place");
    expect([](auto& s) { s[5].spacing_mm = {0.9, 0.9}; }, "pixel spacing differs");
    expect(
        [](auto& s) {
            for (int k = 0; k < 6; ++k)
                s[std::size_t(k)].position_mm[1] += 1.0 * k;
        },
        "sheared");
    expect([](auto& s) { s.resize(2); }, "a volume needs three");
    expect(
        [](auto& s) {
            for (auto& one : s)
                one.orientation = {0.9397, 0.3420, 0, -0.3420, 0.9397, 0};
        },
        "tilted by more than 5 degrees");
}

TEST(ImportImage, EmptyAndForeignFoldersAreRefused) {
    TempFolder temp;
    fs::create_directories(temp / "ct");
    EXPECT_NE(refusal(temp / "ct").find("no DICOM slice among its 0 files"), std::string::npos);
    std::ofstream(temp / "ct" / "notes.txt") << "nothing medical";
    EXPECT_NE(refusal(temp / "ct").find("no DICOM slice among its 1 files"), std::string::npos);
    EXPECT_NE(refusal(temp / "nowhere").find("no such file"), std::string::npos);
}

TEST(ImportImage, HostileDicomEndsInASentence) {
    const std::vector<char> good = test::dicomBytes(stack(1)[0]);
    std::uint32_t seed = 12345;
    const auto random = [&] { return seed = seed * 1664525u + 1013904223u; };
    for (int round = 0; round < 24; ++round) {
        TempFolder temp;
        writeStack(temp / "ct", stack(4));
        std::vector<char> bad = good;
        if (round < 8) {
            bad.resize(132 + (good.size() - 133) * std::size_t(round) / 8);  // cut short
        } else if (round < 16) {
            for (std::size_t i = 132; i < bad.size(); ++i)
                bad[i] = char(random() >> 24);  // garbage
        } else {
            for (int hits = 0; hits < 12; ++hits)  // lengths and tags spoiled
                bad[132 + random() % (bad.size() - 132)] = char(random() >> 24);
        }
        test::writeFile(temp / "ct" / "slice900", bad);
        try {
            const patient::CtVolume ct = readImage(temp / "ct", ImageKind::ct, reader());
            EXPECT_GE(round, 16) << "a slice that is cut short or garbage was taken";
            EXPECT_EQ(ct.voxels.size(), 48u);
        } catch (const ImportError& e) {
            EXPECT_GT(std::string(e.what()).size(), (temp / "ct").string().size() + 10) << e.what();
        }
    }
}

TEST(ImportImage, NiftiIsReadWhereItLies) {
    TempFolder temp;
    test::writeBytes(temp / "ct.nii", test::goodNifti());
    const patient::CtVolume ct = readImage(temp / "ct.nii", ImageKind::ct, reader());
    EXPECT_EQ(ct.grid.dims, patient::Index3(3, 4, 5));
    EXPECT_LT(glm::length(ct.grid.origin_m - Vec3(-0.010, 0.020, 0.030)), 1e-7);
    EXPECT_LT(glm::length(ct.grid.spacing_m - Vec3(0.001, 0.002, 0.003)), 1e-7);
    for (int i = 0; i < 60; ++i)
        EXPECT_EQ(ct.voxels[std::size_t(i)], i);

    test::Bytes mirrored = test::goodNifti();  // x stored from right to left
    test::put(mirrored, 280, -1.0f), test::put(mirrored, 292, 10.0f);
    test::writeBytes(temp / "mirrored.nii", mirrored);
    const patient::CtVolume flipped = readImage(temp / "mirrored.nii", ImageKind::ct, reader());
    EXPECT_EQ(flipped.nearestOr({0.010, 0.020, 0.030}, -1), 0);
    EXPECT_EQ(flipped.nearestOr({0.008, 0.020, 0.030}, -1), 2);
}

TEST(ImportImage, HostileNiftiEndsInASentence) {
    const auto spoiled = [](auto&& spoil, ImageKind kind = ImageKind::ct) {
        TempFolder temp;
        test::Bytes bytes = test::goodNifti();
        spoil(bytes);
        test::writeBytes(temp / "image.nii", bytes);
        return refusal(temp / "image.nii", kind, reader());
    };
    EXPECT_NE(spoiled([](auto& b) { b.resize(300); }), "");
    EXPECT_NE(spoiled([](auto& b) { b.resize(380); }), "");
    EXPECT_NE(spoiled([](auto& b) { test::put(b, 344, std::int32_t(0)); }), "");
    EXPECT_NE(spoiled([](auto& b) { test::put(b, 42, std::int16_t(32000)); }), "");
    EXPECT_NE(spoiled([](auto& b) { test::put(b, 42, std::int16_t(-3)); }), "");
    EXPECT_NE(spoiled([](auto& b) { test::put(b, 70, std::int16_t(77)); }), "");
    EXPECT_NE(spoiled([](auto& b) { test::put(b, 352, std::int16_t(-1)); }, ImageKind::labels)
                  .find("a label of -1"),
              std::string::npos);
}

// The parent's side: whatever the child does, one sentence comes back.
TEST(ImportImage, TheChildIsHeldToItsLimits) {
    TempFolder temp;
    writeStack(temp / "ct", stack(4));
    const auto with = [&](const std::string& script, int wall_s) {
        ReaderLimits limits = reader();
        limits.program = temp / "fake-reader";
        limits.wall_s = wall_s;
        std::ofstream(limits.program) << "#!/bin/sh\n" << script << '\n';
        fs::permissions(limits.program, fs::perms::owner_all);
        return refusal(temp / "ct", ImageKind::ct, limits);
    };
    EXPECT_NE(with("exec sleep 20", 1).find("stopped after 1 s"), std::string::npos);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_NE(with("exec sleep 20 >&-", 1).find("stopped after 1 s"), std::string::npos);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
    EXPECT_NE(with("while :; do echo on and on; done", 1).find("stopped after 1 s"), std::string::npos);
    EXPECT_NE(with("kill -SEGV $$", 20).find("crashed the reader"), std::string::npos);
    EXPECT_NE(with("exit 1", 20).find("gave up without a word"), std::string::npos);
    EXPECT_NE(with("exit 0", 20).find("no image"), std::string::npos);
    EXPECT_NE(with("mkfifo \"$3\"", 20).find("no image"), std::string::npos);
    EXPECT_NE(with("printf STYLIMG1 > \"$3\"", 20).find("no image"), std::string::npos);
    const std::string odd = with("printf 'odd \\033[31m words\\nmore'; exit 1", 20);
    EXPECT_NE(odd.find("odd ?[31m words"), std::string::npos) << odd;
    EXPECT_EQ(odd.find("more"), std::string::npos) << odd;

    ReaderLimits tight = reader();
    tight.memory_bytes = std::size_t(8) << 20;
    EXPECT_NE(refusal(temp / "ct", ImageKind::ct, tight), "");
    ReaderLimits absent = reader();
    absent.program = temp / "not-there";
    EXPECT_NE(refusal(temp / "ct", ImageKind::ct, absent).find("the program is missing"), std::string::npos);
}

// A reader taken over by the file it reads hands over whatever it likes.
TEST(ImportImage, WhatTheChildHandsOverIsCheckedAgain) {
    TempFolder temp;
    test::writeBytes(temp / "image.nii", test::goodNifti());
    const auto handedOver = [&](const ImageHandover& h, const std::vector<std::int16_t>& voxels,
                                ImageKind kind = ImageKind::labels) {
        std::vector<char> bytes(sizeof h + voxels.size() * 2);
        std::memcpy(bytes.data(), &h, sizeof h);
        std::memcpy(bytes.data() + sizeof h, voxels.data(), voxels.size() * 2);
        test::writeFile(temp / "handover", bytes);
        ReaderLimits limits = reader();
        limits.program = temp / "fake-reader";
        std::ofstream(limits.program) << "#!/bin/sh\ncp '" << (temp / "handover").string() << "' \"$3\"\n";
        fs::permissions(limits.program, fs::perms::owner_all);
        return refusal(temp / "image.nii", kind, limits);
    };
    ImageHandover h;
    h.dims = {2, 2, 1};
    h.spacing_mm = {1.0, 1.0, 1.0};
    EXPECT_EQ(handedOver(h, {0, 1, 2, 32767}), "");
    EXPECT_EQ(handedOver(h, {0, -7, 2, 3}, ImageKind::ct), "");
    const std::string negative = handedOver(h, {0, -7, 2, -1});
    EXPECT_NE(negative.find("a label of -7, which is below 0"), std::string::npos) << negative;
    EXPECT_NE(handedOver(h, {0, 1, 2}).find("cut short"), std::string::npos);
    const auto sized = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
        ImageHandover odd = h;
        odd.dims = {x, y, z};
        return handedOver(odd, {0, 1, 2, 3});
    };
    EXPECT_NE(sized(-2, -2, 1).find("impossible size"), std::string::npos);
    EXPECT_NE(sized(0, 2, 2).find("impossible size"), std::string::npos);
    EXPECT_NE(sized(std::int64_t(1) << 62, 4, 1).find("impossible size"), std::string::npos);
    EXPECT_NE(sized(2048, 2048, 2048).find("cut short"), std::string::npos);
    h.spacing_mm[1] = 0.0;
    EXPECT_NE(handedOver(h, {0, 1, 2, 3}).find("impossible scale"), std::string::npos);
}

}  // namespace
}  // namespace stylet::modeller
