#include "app/modeller/image/import_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <fstream>

#include "app/modeller/image/image_handover.h"
#include "tests/app/modeller/image_files.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using test::makeStack;
using test::reader;
using test::readError;
using test::TempFolder;
using test::writeStack;

// The parent process reports one sentence, whatever the child does.
// HZ-RECORD-14
TEST(ImportImage, ChildProcessLimitsAreEnforced) {
    TempFolder temp;
    writeStack(temp / "ct", makeStack(4));
    const auto with = [&](const std::string& script, int wall_s) {
        ReaderLimits limits = reader();
        limits.program = temp / "fake-reader";
        limits.wall_s = wall_s;
        std::ofstream(limits.program) << "#!/bin/sh\n" << script << '\n';
        fs::permissions(limits.program, fs::perms::owner_all);
        return readError(temp / "ct", ImageKind::ct, limits);
    };
    EXPECT_THAT(with("exec sleep 20", 1), testing::HasSubstr("stopped after 1 s"));
    const auto start = std::chrono::steady_clock::now();
    EXPECT_THAT(with("exec sleep 600 >&-", 1), testing::HasSubstr("stopped after 1 s"));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(300));
    EXPECT_THAT(with("while :; do echo on and on; done", 1), testing::HasSubstr("stopped after 1 s"));
    EXPECT_THAT(with("kill -SEGV $$", 20), testing::HasSubstr("crashed the reader"));
    EXPECT_THAT(with("exit 1", 20), testing::HasSubstr("failed without a message"));
    EXPECT_THAT(with("exit 0", 20), testing::HasSubstr("no image"));
    EXPECT_THAT(with("mkfifo \"$3\"", 20), testing::HasSubstr("no image"));
    EXPECT_THAT(with("printf STYLIMG1 > \"$3\"", 20), testing::HasSubstr("no image"));
    const std::string odd = with("printf 'odd \\033[31m words\\nmore'; exit 1", 20);
    EXPECT_THAT(odd, testing::HasSubstr("odd ?[31m words"));
    EXPECT_THAT(odd, testing::Not(testing::HasSubstr("more")));

    ReaderLimits tight = reader();
    tight.memory_bytes = std::size_t(8) << 20;
    EXPECT_NE(readError(temp / "ct", ImageKind::ct, tight), "");
    ReaderLimits absent = reader();
    absent.program = temp / "not-there";
    EXPECT_THAT(test::errorText<EnvironmentError>([&] { readImage(temp / "ct", ImageKind::ct, absent); }),
                testing::HasSubstr("the program is missing"));
}

// A reader process that the file has compromised may return any data.
// HZ-RECORD-14
TEST(ImportImage, ChildProcessOutputIsValidated) {
    TempFolder temp;
    test::writeBytes(temp / "image.nii", test::validNifti());
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
        return readError(temp / "image.nii", kind, limits);
    };
    ImageHandover h;
    h.dims = {2, 2, 1};
    h.spacing_mm = {1.0, 1.0, 1.0};
    EXPECT_EQ(handedOver(h, {0, 1, 2, 32767}), "");
    EXPECT_EQ(handedOver(h, {0, -7, 2, 3}, ImageKind::ct), "");
    const std::string negative = handedOver(h, {0, -7, 2, -1});
    EXPECT_THAT(negative, testing::HasSubstr("a label of -7, which is below 0"));
    EXPECT_THAT(handedOver(h, {0, 1, 2}), testing::HasSubstr("cut short"));
    const auto sized = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
        ImageHandover odd = h;
        odd.dims = {x, y, z};
        return handedOver(odd, {0, 1, 2, 3});
    };
    EXPECT_THAT(sized(-2, -2, 1), testing::HasSubstr("impossible size"));
    EXPECT_THAT(sized(0, 2, 2), testing::HasSubstr("impossible size"));
    EXPECT_THAT(sized(std::int64_t(1) << 62, 4, 1), testing::HasSubstr("impossible size"));
    EXPECT_THAT(sized(2048, 2048, 2048), testing::HasSubstr("cut short"));
    h.spacing_mm[1] = 0.0;
    EXPECT_THAT(handedOver(h, {0, 1, 2, 3}), testing::HasSubstr("impossible scale"));
}

}  // namespace
}  // namespace stylet::modeller
