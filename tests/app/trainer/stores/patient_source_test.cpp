// Patients in the user's cache. Several programs may read and rebuild them at the same time.
#include "app/trainer/stores/patient_source.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

namespace fs = std::filesystem;

class CachedPackageTest : public testing::Test {
  protected:
    CachedPackageTest() { patient::savePackage(package_, kept_); }
    void damage() const { fs::resize_file(kept_ / "ct.nii.gz", fs::file_size(kept_ / "ct.nii.gz") / 2); }
    std::size_t entries() const {
        return std::size_t(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()));
    }
    const patient::Package package_ = test::ductPhantom();
    const std::uint64_t digest_ = patient::digest(package_);
    test::TempFolder folder_;
    const fs::path kept_ = folder_ / "kept";
};

TEST_F(CachedPackageTest, DamagedPackageIsRemoved) {
    const auto found = loadCachedPackage(kept_);
    ASSERT_TRUE(found);
    EXPECT_EQ(patient::digest(*found), digest_);
    EXPECT_FALSE(loadCachedPackage(folder_ / "none"));
    damage();
    EXPECT_FALSE(loadCachedPackage(kept_));
    EXPECT_EQ(entries(), 0u);
}

// Another program has found the same damage and replaced the package before this one could remove it.
TEST_F(CachedPackageTest, ValidPackageOfAnotherProgramStays) {
    damage();
    int loads = 0;
    const auto found = loadCachedPackage(kept_, [&](const fs::path& folder) {
        if (++loads > 1) return patient::loadPackage(folder);
        try {
            return patient::loadPackage(folder);
        } catch (const DataError&) {
            patient::savePackage(package_, kept_);
            throw;
        }
    });
    EXPECT_EQ(loads, 2);
    ASSERT_TRUE(found);
    EXPECT_EQ(patient::digest(*found), digest_);
    EXPECT_EQ(patient::digest(patient::loadPackage(kept_)), digest_);
    EXPECT_EQ(entries(), 1u);
}

// Another program has removed the damaged package and is rebuilding it.
TEST_F(CachedPackageTest, ConcurrentRemovalIsReportedAsMissing) {
    EXPECT_FALSE(loadCachedPackage(kept_, [&](const fs::path& folder) -> patient::Package {
        fs::remove_all(folder);
        return patient::loadPackage(folder);
    }));
    EXPECT_EQ(entries(), 0u);
}

// Another program replaced the package while this one checked the old one.
TEST_F(CachedPackageTest, ConcurrentCreationIsUsed) {
    int loads = 0;
    const auto found = loadCachedPackage(kept_, [&](const fs::path& folder) -> patient::Package {
        if (++loads == 1) throw DataError(folder, "file", "read while it was replaced");
        patient::savePackage(package_, kept_);
        return patient::loadPackage(folder);
    });
    ASSERT_TRUE(found);
    EXPECT_EQ(patient::digest(patient::loadPackage(kept_)), digest_);
    EXPECT_EQ(entries(), 1u);
}

// A file that cannot be opened does not prove that the package is damaged.
TEST_F(CachedPackageTest, UnreadablePackageIsNotTreatedAsDamaged) {
    fs::remove(kept_ / "labels.nii.gz");
    fs::create_symlink(folder_ / "a disk that is not there", kept_ / "labels.nii.gz");
    EXPECT_THROW(loadCachedPackage(kept_), DataError);
    EXPECT_TRUE(fs::exists(kept_ / "ct.nii.gz"));
    EXPECT_EQ(entries(), 1u);
}

// HZ-TEACH-22
TEST_F(CachedPackageTest, RefusedPatientOpensOnTheInstructorsWordOnly) {
    const auto open = [&](bool accept_implausible) {
        PatientRequest request;
        request.folder = kept_;
        request.accept_implausible = accept_implausible;
        return openPatient(request).check;
    };
    EXPECT_EQ(open(false), patient::kNotChecked);
    patient::saveVerdict({digest_, false, {}}, kept_);
    EXPECT_EQ(open(false), "");
    patient::saveVerdict({digest_, true, {"REFUSED  skin: 0 ml"}}, kept_);
    EXPECT_THROW(open(false), DataError);
    EXPECT_NE(open(true).find("skin: 0 ml"), std::string::npos);
    patient::saveVerdict({digest_ + 1, false, {}}, kept_);  // the patient was changed after its check
    EXPECT_THROW(open(false), DataError);
    EXPECT_EQ(open(true).rfind("overruled: ", 0), 0u);
}

}  // namespace
}  // namespace stylet::trainer
