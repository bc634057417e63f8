// Reads NIfTI files with the real reader program.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "tests/app/modeller/image_files.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using test::reader;
using test::readError;
using test::TempFolder;

// HZ-TEACH-03
TEST(ReadNifti, VoxelPositionsArePreserved) {
    TempFolder temp;
    test::writeBytes(temp / "ct.nii", test::validNifti());
    const CtVolume ct = readImage(temp / "ct.nii", ImageKind::ct, reader());
    EXPECT_EQ(ct.grid.dims, Index3(3, 4, 5));
    EXPECT_LT(glm::length(ct.grid.origin_m - Vec3(-0.010, 0.020, 0.030)), 1e-7);
    EXPECT_LT(glm::length(ct.grid.spacing_m - Vec3(0.001, 0.002, 0.003)), 1e-7);
    for (int i = 0; i < 60; ++i)
        EXPECT_EQ(ct.voxels[std::size_t(i)], i);

    test::Bytes mirrored = test::validNifti();  // x stored from right to left
    test::put(mirrored, 280, -1.0f), test::put(mirrored, 292, 10.0f);
    test::writeBytes(temp / "mirrored.nii", mirrored);
    const CtVolume flipped = readImage(temp / "mirrored.nii", ImageKind::ct, reader());
    EXPECT_EQ(flipped.nearestOr({0.010, 0.020, 0.030}, -1), 0);
    EXPECT_EQ(flipped.nearestOr({0.008, 0.020, 0.030}, -1), 2);
}

// Error message for a good file after `change`, or empty if it is accepted.
template <typename Change>
std::string acceptedOrError(Change change, ImageKind kind = ImageKind::ct) {
    TempFolder temp;
    test::Bytes bytes = test::validNifti();
    change(bytes);
    test::writeBytes(temp / "image.nii", bytes);
    return readError(temp / "image.nii", kind, reader());
}

// Error message for a good file after `corrupt`. Expects that it is one line and names the file.
template <typename Corrupt>
std::string readCorrupted(Corrupt corrupt, ImageKind kind = ImageKind::ct) {
    const std::string why = acceptedOrError(corrupt, kind);
    EXPECT_THAT(why, testing::HasSubstr("image.nii: "));
    EXPECT_THAT(why, testing::Not(testing::HasSubstr("\n")));
    return why;
}

template <typename Corrupt>
void expectNiftiRefused(Corrupt corrupt, const char* words, ImageKind kind = ImageKind::ct) {
    const std::string why = readCorrupted(corrupt, kind);
    EXPECT_THAT(why, testing::HasSubstr(words));
}

// Stores the good file's voxels as floats.
void makeReal(test::Bytes& b, float first) {
    b.resize(352 + 60 * 4);
    test::put(b, 70, std::int16_t(16)), test::put(b, 72, std::int16_t(32));
    for (std::size_t i = 0; i < 60; ++i)
        test::put(b, 352 + 4 * i, i == 0 ? first : float(i));
}

TEST(ReadNifti, NonNiftiFilesAreRefused) {
    expectNiftiRefused([](auto& b) { b.resize(300); }, "not a NIfTI file: too short");
    expectNiftiRefused([](auto& b) { test::put(b, 0, std::int32_t(77)); }, "sizeof_hdr: not a NIfTI file");
    expectNiftiRefused([](auto& b) { test::put(b, 0, std::int32_t(540)); },
                       "a NIfTI-2 file; save it as NIfTI-1");
    expectNiftiRefused([](auto& b) { test::put(b, 344, std::int32_t(0)); }, "magic: not a NIfTI-1 file");
    expectNiftiRefused([](auto& b) { std::memcpy(b.data() + 344, "ni1", 4); },
                       "in two files; save it as one");
    expectNiftiRefused([](auto& b) { std::memcpy(b.data() + 128, "DICM", 4); },
                       "one DICOM file; name the folder of its series");
}

TEST(ReadNifti, InvalidSizesAreRefused) {
    expectNiftiRefused([](auto& b) { test::put(b, 42, std::int16_t(32000)); },
                       "dim: a size of 32000 along axis 1");
    expectNiftiRefused([](auto& b) { test::put(b, 44, std::int16_t(-3)); }, "dim: a size of -3 along axis 2");
    expectNiftiRefused(
        [](auto& b) {
            for (std::size_t at : {42, 44, 46})
                test::put(b, at, std::int16_t(2000));
        },
        "dim: ");
    expectNiftiRefused([](auto& b) { test::put(b, 40, std::int16_t(2)); },
                       "dim: fewer than three dimensions");
    expectNiftiRefused(
        [](auto& b) {
            test::put(b, 40, std::int16_t(4)), test::put(b, 48, std::int16_t(5));
            b.resize(352 + 5 * 60 * 2);
        },
        "dim: more than three dimensions (5 volumes); save one of them alone");
    expectNiftiRefused([](auto& b) { test::put(b, 70, std::int16_t(128)); }, "datatype: 128 is not read");
    expectNiftiRefused([](auto& b) { test::put(b, 70, std::int16_t(16)); },
                       "bitpix: does not fit the datatype");
    expectNiftiRefused([](auto& b) { test::put(b, 108, -8.0f); }, "vox_offset: -8 is impossible");
}

TEST(ReadNifti, InvalidOrientationsAreRefused) {
    expectNiftiRefused([](auto& b) { test::put(b, 254, std::int16_t(0)); },
                       "qform_code and sform_code: are both 0, so left and right are unknown");
    // Rotated by 20 degrees about z, once as a matrix and once as a quaternion.
    const float c = 0.9396926f, s = 0.3420201f;
    const float oblique[12] = {c, -2 * s, 0, -10, s, 2 * c, 0, 20, 0, 0, 3, 30};
    expectNiftiRefused([&](auto& b) { std::memcpy(b.data() + 280, oblique, sizeof oblique); },
                       "srow: its axes are tilted by 20 degrees, more than 5");
    expectNiftiRefused(
        [&](auto& b) {
            test::put(b, 252, std::int16_t(1)), test::put(b, 254, std::int16_t(0));
            test::put(b, 264, std::sin(0.1745329f));  // quatern_d: sine of half the angle
        },
        "orientation: its axes are tilted by more than 5 degrees (20 degrees)");
    expectNiftiRefused([](auto& b) { test::put(b, 280, float(NAN)); }, "srow: is no map");
    const float flat[12] = {};
    expectNiftiRefused([&](auto& b) { std::memcpy(b.data() + 280, flat, sizeof flat); }, "srow: is no map");
}

TEST(ReadNifti, InvalidVoxelValuesAreRefused) {
    expectNiftiRefused([](auto& b) { makeReal(b, float(NAN)); }, "voxels: some are not numbers; write -1024");
    expectNiftiRefused([](auto& b) { makeReal(b, float(INFINITY)); }, "voxels: some are not numbers");
    for (const float slope : {-1.0f, 1e9f, 1e-9f, float(NAN)})
        expectNiftiRefused([slope](auto& b) { test::put(b, 112, slope); }, "scl_slope: ");
    expectNiftiRefused([](auto& b) { test::put(b, 112, 1.0f), test::put(b, 116, 1e8f); }, "scl_inter: ");
    expectNiftiRefused([](auto& b) { test::put(b, 352, std::int16_t(-1)); }, "a label of -1",
                       ImageKind::labels);
    expectNiftiRefused([](auto& b) { makeReal(b, 0.5f); }, "a label of 0.5", ImageKind::labels);
}

// The good file with its place in the qform instead of the sform.
void useQform(test::Bytes& b) {
    test::put(b, 252, std::int16_t(1)), test::put(b, 254, std::int16_t(0));
    test::put(b, 268, -10.0f), test::put(b, 272, 20.0f), test::put(b, 276, 30.0f);
}

// ITK would use 1 mm.
TEST(ReadNifti, UnknownVoxelSizesAreRefused) {
    EXPECT_EQ(acceptedOrError([](auto& b) { useQform(b); }), "");
    for (const float size : {0.0f, float(NAN), -3.0f, float(INFINITY)}) {
        const std::string words = fmt::format("pixdim[3]: {:g} is no voxel size", size);
        expectNiftiRefused([&](auto& b) { test::put(b, 88, size); }, words.c_str());
        expectNiftiRefused([&](auto& b) { useQform(b), test::put(b, 88, size); }, words.c_str());
    }
    // The file of a breathing phase may lack it.
    const auto unknown = [](auto& b) {
        test::put(b, 254, std::int16_t(0));
        for (std::size_t at : {80, 84, 88})
            test::put(b, at, 0.0f);
    };
    EXPECT_EQ(acceptedOrError(unknown, ImageKind::phase), "");
    expectNiftiRefused([](auto& b) { test::put(b, 88, float(NAN)); }, "pixdim[3]: nan", ImageKind::phase);
}

TEST(ReadNifti, ImpossiblePositionsAreRefused) {
    for (const float at : {float(NAN), float(INFINITY), 1e9f}) {
        const std::string value = fmt::format("{:g} is impossible", at);
        const auto expect = [&](bool qform, std::size_t offset, const std::string& field) {
            for (const ImageKind kind : {ImageKind::ct, ImageKind::labels, ImageKind::phase})
                expectNiftiRefused(
                    [&](auto& b) {
                        if (qform) useQform(b);
                        test::put(b, offset, at);
                    },
                    (field + ": " + value).c_str(), kind);
        };
        expect(true, 256, "quatern_b");
        expect(true, 264, "quatern_d");
        expect(true, 268, "qoffset_x");
        expect(true, 276, "qoffset_z");
        expect(false, 292, "srow_x[3]");
        expect(false, 324, "srow_z[3]");
    }
    expectNiftiRefused([](auto& b) { useQform(b), test::put(b, 76, float(NAN)); },
                       "pixdim[0]: nan is neither 1 nor -1");
}

TEST(ReadNifti, ContradictoryVoxelSizesAreRefused) {
    const auto ones = [](auto& b) {
        for (std::size_t at : {80, 84, 88})
            test::put(b, at, 1.0f);
    };
    const char* words = "pixdim[2]: 1 mm, but srow's column for that axis is 2 mm long";
    expectNiftiRefused(ones, words);
    // ITK would use the qform.
    expectNiftiRefused([&](auto& b) { ones(b), test::put(b, 252, std::int16_t(1)); }, words);
}

// ITK would use one of the two without a word. Half a voxel of 1 mm is rounding.
TEST(ReadNifti, TwoPositionsAreRefused) {
    const auto both = [](auto& b, float z_mm) {
        useQform(b);
        test::put(b, 254, std::int16_t(1));
        test::put(b, 276, z_mm);
    };
    EXPECT_EQ(acceptedOrError([&](auto& b) { both(b, 30.4f); }), "");
    for (const ImageKind kind : {ImageKind::ct, ImageKind::labels, ImageKind::phase})
        expectNiftiRefused([&](auto& b) { both(b, -42.0f); },
                           "qoffset_z and srow_z[3]: the first voxel is at -42 mm and at 30 mm", kind);
}

// ITK would convert the spacing only.
TEST(ReadNifti, UnitsOtherThanMillimetresAreRefused) {
    expectNiftiRefused([](auto& b) { test::put(b, 123, std::uint8_t(1)); },
                       "xyzt_units: metres; write the file in mm");
    expectNiftiRefused([](auto& b) { test::put(b, 123, std::uint8_t(3 | 8)); },
                       "xyzt_units: micrometres; write the file in mm");
    EXPECT_EQ(acceptedOrError([](auto& b) { test::put(b, 123, std::uint8_t(0)); }), "");
}

// ITK would add the intercept.
TEST(ReadNifti, AnInterceptWithoutASlopeIsRefused) {
    EXPECT_EQ(acceptedOrError([](auto& b) { test::put(b, 112, 0.0f); }), "");
    for (const float intercept : {-1024.0f, float(NAN)})
        expectNiftiRefused([&](auto& b) { test::put(b, 112, 0.0f), test::put(b, 116, intercept); },
                           "but scl_slope is 0, which means no scaling");
}

TEST(ReadNifti, MissingLabelsAreZeros) {
    expectNiftiRefused([](auto& b) { makeReal(b, float(NAN)); }, "write 0 where nothing is labelled",
                       ImageKind::labels);
}

TEST(ReadNifti, OtherReasonsAreNotCalledDamage) {
    expectNiftiRefused([](auto& b) { test::put(b, 284, 0.05f); }, "ITK cannot read it: ITK only supports");
    TempFolder temp;
    test::writeBytes(temp / "image.nii", test::validNifti());
    ASSERT_EQ(std::system(("gzip '" + (temp / "image.nii").string() + "'").c_str()), 0);
    fs::rename(temp / "image.nii.gz", temp / "zipped.nii");
    EXPECT_THAT(readError(temp / "zipped.nii"),
                testing::HasSubstr("name: its data is compressed by gzip; name it .nii.gz"));
    fs::rename(temp / "zipped.nii", temp / "image");
    EXPECT_THAT(readError(temp / "image"), testing::HasSubstr("name: does not end in .nii or .nii.gz"));
}

TEST(ReadNifti, TruncatedOrDamagedFilesAreRefused) {
    expectNiftiRefused([](auto& b) { b.resize(380); }, "voxels: cut short or damaged");
    TempFolder temp;
    const std::string plain = (temp / "image.nii").string();
    test::writeBytes(plain, test::validNifti());
    ASSERT_EQ(std::system(("gzip -k '" + plain + "'").c_str()), 0);
    const test::Bytes whole = test::fileBytes(temp / "image.nii.gz");
    EXPECT_EQ(readError(temp / "image.nii.gz", ImageKind::ct, reader()), "");
    for (const std::size_t size :
         {std::size_t(5), std::size_t(40), whole.size() / 2, whole.size() - 9, whole.size() - 3}) {
        test::Bytes cut = whole;
        cut.resize(size);
        test::writeBytes(temp / "cut.nii.gz", cut);
        const std::string why = readError(temp / "cut.nii.gz", ImageKind::ct, reader());
        EXPECT_THAT(why, testing::HasSubstr("cut.nii.gz: ")) << size;
    }
    test::Bytes wrong = whole;
    wrong[whole.size() - 6] ^= std::byte{1};  // the checksum
    test::writeBytes(temp / "wrong.nii.gz", wrong);
    EXPECT_THAT(readError(temp / "wrong.nii.gz", ImageKind::ct, reader()), testing::HasSubstr("damaged"));
}

}  // namespace
}  // namespace stylet::modeller
