#include "patient/package/nifti.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "patient/package/package.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

using test::Bytes;
using test::expectRefused;
using test::put;
using test::validNifti;

const std::filesystem::path kFile = "in.nii";

CtVolume parsed(const Bytes& bytes) {
    return parseNifti<std::int16_t>(kFile, bytes);
}

void expectRefusedAt(const std::string& field, const std::function<void(Bytes&)>& spoil) {
    Bytes bytes = validNifti();
    spoil(bytes);
    expectRefused([&] { parsed(bytes); }, "in.nii", field);
}

template <typename Value>
void expectRefusedWith(const std::string& field, std::size_t at, Value value) {
    expectRefusedAt(field, [&](Bytes& bytes) { put(bytes, at, value); });
}

// The same volume in another stored type.
template <typename Stored>
Bytes storedAs(int code, const std::vector<Stored>& values) {
    Bytes bytes = validNifti();
    bytes.resize(352 + 60 * sizeof(Stored));
    put(bytes, 70, std::int16_t(code)), put(bytes, 72, std::int16_t(8 * sizeof(Stored)));
    for (std::size_t i = 0; i < 60; ++i)
        put(bytes, 352 + i * sizeof(Stored), values[i % values.size()]);
    return bytes;
}

template <typename Stored>
void reverseAt(Bytes& bytes, std::size_t at) {
    std::reverse(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + sizeof(Stored)));
}

Bytes zipped(const Bytes& plain) {
    const test::TempFolder folder;
    const CtVolume volume = parsed(plain);
    writeNifti(folder / "a.nii.gz", volume);
    return test::fileBytes(folder / "a.nii.gz");
}

TEST(Nifti, ReadsGridAndValues) {
    const CtVolume v = parsed(validNifti());
    EXPECT_EQ(v.grid.dims, Index3(3, 4, 5));
    EXPECT_EQ(v.grid.spacing_m, Vec3(0.001, 0.002, 0.003));
    EXPECT_EQ(v.grid.origin_m, Vec3(-0.010, 0.020, 0.030));
    for (std::size_t i = 0; i < 60; ++i)
        EXPECT_EQ(v.voxels[i], int(i));
}

TEST(Nifti, RoundTripPlainAndZipped) {
    const test::TempFolder folder;
    Grid grid;
    grid.dims = {31, 17, 9};
    grid.spacing_m = Vec3(0.0005);
    CtVolume ct(grid);
    LabelVolume labels(grid);
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        ct.voxels[i] = std::int16_t(i * 977);
        labels.voxels[i] = std::uint8_t(i * 31);
    }
    for (const char* name : {"ct.nii", "ct.nii.gz"}) {
        writeNifti(folder / name, ct);
        const CtVolume back = readNifti<std::int16_t>(folder / name);
        EXPECT_EQ(back.grid, grid);
        EXPECT_EQ(back.voxels, ct.voxels);
    }
    writeNifti(folder / "labels.nii.gz", labels);
    EXPECT_EQ(readNifti<std::uint8_t>(folder / "labels.nii.gz").voxels, labels.voxels);
}

TEST(Nifti, SameVolumeGivesSameBytesWithoutTimeStamp) {
    const Bytes a = zipped(validNifti());
    EXPECT_EQ(a, zipped(validNifti()));
    for (std::size_t i = 4; i < 8; ++i)
        EXPECT_EQ(a[i], std::byte{0});
}

// HZ-TEACH-03
TEST(Nifti, FlippedAxesAreUndone) {
    const CtVolume straight = parsed(validNifti());
    for (int axis = 0; axis < 3; ++axis) {
        Bytes bytes = validNifti();
        const std::size_t row = 280 + 16 * std::size_t(axis);
        const double spacing_mm = axis + 1.0;
        put(bytes, row + 4 * std::size_t(axis), float(-spacing_mm));
        const CtVolume v = parsed(bytes);
        EXPECT_EQ(v.grid.spacing_m, straight.grid.spacing_m);
        const double shift_m = spacing_mm / 1000 * (v.grid.dims[axis] - 1);
        EXPECT_NEAR(v.grid.origin_m[axis], straight.grid.origin_m[axis] - shift_m, 1e-12);
        Index3 mirrored{1, 2, 3};
        mirrored[axis] = v.grid.dims[axis] - 1 - mirrored[axis];
        EXPECT_EQ(v[mirrored], straight[Index3(1, 2, 3)]);
    }
}

TEST(Nifti, QformAloneIsEnough) {
    Bytes bytes = validNifti();
    put(bytes, 254, std::int16_t(0)), put(bytes, 252, std::int16_t(1));
    put(bytes, 268, -10.0f), put(bytes, 272, 20.0f), put(bytes, 276, 30.0f);
    EXPECT_EQ(parsed(bytes).grid, parsed(validNifti()).grid);
    put(bytes, 76, -1.0f);  // a left-handed third axis
    EXPECT_NEAR(parsed(bytes).grid.origin_m.z, 0.030 - 4 * 0.003, 1e-12);
    // Half a turn about z: the LPS volumes of many scanners.
    put(bytes, 76, 1.0f), put(bytes, 264, 1.0f);
    const CtVolume turned = parsed(bytes);
    EXPECT_NEAR(turned.grid.origin_m.x, -0.012, 1e-9);
    EXPECT_NEAR(turned.grid.origin_m.y, 0.014, 1e-9);
    EXPECT_EQ(turned[Index3(0)], parsed(validNifti())[Index3(2, 3, 0)]);
}

TEST(Nifti, BigEndian) {
    Bytes bytes = validNifti();
    reverseAt<std::int32_t>(bytes, 0);
    for (std::size_t at = 40; at < 56; at += 2)
        reverseAt<std::int16_t>(bytes, at);
    for (const std::size_t at : {70u, 72u, 252u, 254u})
        reverseAt<std::int16_t>(bytes, at);
    for (std::size_t at = 76; at < 120; at += 4)
        reverseAt<float>(bytes, at);
    for (std::size_t at = 256; at < 328; at += 4)
        reverseAt<float>(bytes, at);
    for (std::size_t at = 352; at < bytes.size(); at += 2)
        reverseAt<std::int16_t>(bytes, at);
    EXPECT_EQ(parsed(bytes).voxels, parsed(validNifti()).voxels);
    EXPECT_EQ(parsed(bytes).grid, parsed(validNifti()).grid);
}

TEST(Nifti, OtherTypesAndScaling) {
    Bytes scaled = storedAs<std::uint16_t>(512, {24, 1024, 65535});
    put(scaled, 112, 0.5f), put(scaled, 116, -12.0f);
    EXPECT_EQ(parsed(scaled).voxels[0], 0);
    EXPECT_EQ(parsed(scaled).voxels[2], 32756);  // 32755.5, halves round up
    EXPECT_EQ(parsed(storedAs<float>(16, {-1000.4f, 3.5f})).voxels[1], 4);
    EXPECT_EQ(parsed(storedAs<double>(64, {-1000.4})).voxels[0], -1000);
    EXPECT_EQ(parsed(storedAs<std::int32_t>(8, {-32768})).voxels[0], -32768);
    EXPECT_EQ(parsed(storedAs<std::uint8_t>(2, {255})).voxels[0], 255);
    EXPECT_EQ(parseNifti<std::uint8_t>(kFile, storedAs<float>(16, {7.0f})).voxels[0], 7);
}

TEST(NiftiHostile, InvalidHeadersAreRejected) {
    expectRefusedWith("sizeof_hdr", 0, std::int32_t(540));
    expectRefusedWith("magic", 344, 'N');
    expectRefusedAt("magic", [](Bytes& b) { std::memcpy(b.data() + 344, "ni1", 4); });
    expectRefusedAt("magic", [](Bytes& b) { std::memcpy(b.data() + 344, "n+2", 4); });
    expectRefused([] { parsed({}); }, "in.nii", "header");
    expectRefused([] { parsed(Bytes(1000)); }, "in.nii", "sizeof_hdr");
}

TEST(NiftiHostile, TruncatedAnywhere) {
    const Bytes plain = validNifti(), zip = zipped(plain);
    for (std::size_t n = 0; n < plain.size(); ++n)
        EXPECT_THROW(parsed(Bytes(plain.begin(), plain.begin() + std::ptrdiff_t(n))), DataError) << n;
    for (std::size_t n = 0; n < zip.size(); ++n)
        EXPECT_THROW(parsed(Bytes(zip.begin(), zip.begin() + std::ptrdiff_t(n))), DataError) << n;
}

TEST(NiftiHostile, ExtraBytes) {
    expectRefusedAt("voxels", [](Bytes& b) { b.push_back(std::byte{0}); });
    Bytes zip = zipped(validNifti());
    zip.push_back(std::byte{0});
    expectRefused([&] { parsed(zip); }, "in.nii", "voxels");
}

// HZ-RECORD-14
TEST(NiftiHostile, AbsurdSizes) {
    expectRefusedWith("dim[0]", 40, std::int16_t(0));
    expectRefusedWith("dim[0]", 40, std::int16_t(8));
    expectRefusedWith("dim[1]", 42, std::int16_t(0));
    expectRefusedWith("dim[2]", 44, std::int16_t(-4));
    expectRefusedWith("dim[3]", 46, std::int16_t(1025));
    expectRefusedAt("dim[4]", [](Bytes& b) { put(b, 40, std::int16_t(4)), put(b, 48, std::int16_t(2)); });
    const auto sides = [](Bytes& b, std::int16_t x, std::int16_t y, std::int16_t z) {
        put(b, 42, x), put(b, 44, y), put(b, 46, z);
    };
    expectRefusedAt("dim", [&](Bytes& b) { sides(b, 1024, 1024, 1024); });
    // Within the limits, but the file has only 472 bytes. It must be rejected before a gigabyte is
    // allocated.
    expectRefusedAt("dim", [&](Bytes& b) { sides(b, 1024, 1024, 512); });
}

TEST(NiftiHostile, FieldsOutOfRange) {
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    expectRefusedWith("datatype", 70, std::int16_t(128));
    expectRefusedWith("bitpix", 72, std::int16_t(8));
    for (const float offset : {nan, inf, 0.0f, 351.0f, 352.5f, 1e9f})
        expectRefusedWith("vox_offset", 108, offset);
    for (const float slope : {nan, inf, 1e30f})
        expectRefusedWith("scl_slope", 112, slope);
    expectRefusedAt("scl_inter", [&](Bytes& b) { put(b, 112, 1.0f), put(b, 116, nan); });
    expectRefusedWith("xyzt_units", 123, std::uint8_t(1));
    expectRefusedWith("srow", 280, nan);
    for (const float spacing : {0.0f, 0.001f, 100.0f})
        expectRefusedWith("spacing", 280, spacing);
    for (const float offset : {nan, inf})
        expectRefusedWith("srow", 292, offset);
    expectRefusedWith("offset", 292, 1e6f);
}

// HZ-TEACH-03
TEST(NiftiHostile, Orientation) {
    expectRefusedWith("sform_code", 254, std::int16_t(0));
    expectRefusedWith("sform", 284, 0.1f);   // oblique
    expectRefusedAt("sform", [](Bytes& b) {  // x and y swapped
        put(b, 280, 0.0f), put(b, 284, 1.0f), put(b, 296, 2.0f), put(b, 300, 0.0f);
    });
    expectRefusedWith("sform", 252, std::int16_t(1));  // a qform that contradicts the sform
    expectRefusedAt("quatern", [](Bytes& b) {
        put(b, 254, std::int16_t(0)), put(b, 252, std::int16_t(1)), put(b, 256, 2.0f);
    });
}

TEST(NiftiHostile, Values) {
    expectRefused([] { parsed(storedAs<float>(16, {std::nanf("")})); }, "in.nii", "voxels");
    expectRefused([] { parsed(storedAs<float>(16, {40000.0f})); }, "in.nii", "voxels");
    expectRefused([] { parseNifti<std::uint8_t>(kFile, storedAs<float>(16, {1.5f})); }, "in.nii", "voxels");
    expectRefused([] { parseNifti<std::uint8_t>(kFile, storedAs<std::int16_t>(4, {256})); }, "in.nii",
                  "voxels");
}

// Flips every single bit. Each flip gives a volume or a DataError.
// HZ-RECORD-14
TEST(NiftiHostile, BitFlips) {
    const Bytes plain = validNifti(), zip = zipped(plain);
    int refused = 0;
    for (const Bytes& good : {plain, zip})
        for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
            Bytes bytes = good;
            bytes[bit / 8] ^= std::byte(1 << (bit % 8));
            try {
                parsed(bytes);
            } catch (const DataError&) {
                ++refused;
            }
        }
    EXPECT_GT(refused, 1000);
}

// A flipped bit in an unused code length changes nothing. The loader detects every other flip, at the latest
// by the checksum.
TEST(NiftiHostile, EveryBitFlipInAVoxelIsDetected) {
    const Bytes zip = zipped(validNifti());
    for (std::size_t bit = 8 * 10; bit < 8 * zip.size(); ++bit) {
        Bytes bytes = zip;
        bytes[bit / 8] ^= std::byte(1 << (bit % 8));
        try {
            EXPECT_EQ(parsed(bytes).voxels, parsed(validNifti()).voxels) << bit;
        } catch (const DataError&) {
        }
    }
}

TEST(NiftiHostile, MissingFile) {
    expectRefused([] { readNifti<std::int16_t>("nowhere/ct.nii"); }, "ct.nii", "file");
}

}  // namespace
}  // namespace stylet::patient
