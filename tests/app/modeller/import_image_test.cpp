#include "app/modeller/image/import_image.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <fstream>

#include "app/modeller/image/image_handover.h"
#include "image_files.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using test::reader;
using test::refusal;
using test::stack;
using test::TempFolder;
using test::writeStack;

// The parent process: whatever the child does, the result is one sentence.
// HZ-RECORD-14
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
    EXPECT_NE(with("exec sleep 600 >&-", 1).find("stopped after 1 s"), std::string::npos);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(300));
    EXPECT_NE(with("while :; do echo on and on; done", 1).find("stopped after 1 s"), std::string::npos);
    EXPECT_NE(with("kill -SEGV $$", 20).find("crashed the reader"), std::string::npos);
    EXPECT_NE(with("exit 1", 20).find("failed without a message"), std::string::npos);
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

// A reader process that the file has compromised may return any data.
// HZ-RECORD-14
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
