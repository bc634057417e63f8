// The patient package: a folder whose images open in 3D Slicer.
//   patient.toml    tissue table, thresholds, label table with roles, breath, licence
//   ct.nii.gz       int16 HU        labels.nii.gz  uint8 with labels.ctbl
//   motion.nii.gz   breathing motion (optional; see motion_io.h)
//   paths.json      bookmarked reference paths (optional; see planning.h)
#pragma once

#include <filesystem>
#include <string>

#include "base/errors.h"
#include "patient/motion/motion.h"
#include "patient/tissue/tissue.h"

namespace stylet::patient {

// Properties of the scan that the package's CT lacks, because it was resampled and the air around the body
// was cut away. 0: unknown.
struct ScanProperties {
    double slice_m = 0.0;        // distance between slices
    double blur_within_m = 0.0;  // standard deviation of the blur within slices
};

struct Package {
    std::string name;  // "reference patient, seed 1"
    std::string licence;
    std::string provenance;            // origin of the package, one line
    std::vector<std::string> atlases;  // names of the packages whose labels were used to find these
    CtVolume ct;
    LabelVolume labels;  // same grid
    std::vector<Label> label_table;
    TissueTable tissues{};
    ElasticityTable elasticity{};
    Thresholds thresholds;
    std::string reference_phase = "exhale";  // breathing state of the CT: "exhale", "inhale" or "v=0.35"
    ScanProperties scan;
    MotionModel motion;      // breathing motion
    BreathingSignal signal;  // breathing at rest
};

// Initial values of a package: the [[tissue]] and [thresholds] tables of a TOML file
// (assets/tissue/ptcd.toml).
struct TissueDefaults {
    TissueTable tissues{};
    ElasticityTable elasticity{};
    Thresholds thresholds;
};
TissueDefaults loadTissueDefaults(const std::filesystem::path& toml);

// Throws DataError. Sizes are checked against volume.h's limits before anything is allocated.
Package loadPackage(const std::filesystem::path& folder);
// Writes to a temporary sibling folder and renames it, so a crash leaves no partial package. The same
// package gives the same bytes.
void savePackage(const Package&, const std::filesystem::path& folder);

// Throws DataError if the folder contains anything but a package, which savePackage() would refuse to
// replace.
void checkPackageFolder(const std::filesystem::path& folder);

// Contents of labels.ctbl, 3D Slicer's colour table: id, name, red, green, blue, alpha.
std::string colourTable(const std::vector<Label>&);

// 64-bit hash of everything that an attempt's state depends on: table, thresholds, labels with their roles,
// CT, breathing. Names, colours and provenance are not part of it.
std::uint64_t digest(const Package&);

// A package with tables for fast look-up. Keeps a reference to the package, which must outlive it.
class Patient {
  public:
    explicit Patient(const Package&);
    // Simulates a partial segmentation. Only labels accepted by `segmented` are used. A voxel with any other
    // label is treated as unlabelled: HU thresholds determine its tissue.
    Patient(const Package&, bool (*segmented)(const Label&));

    const Package& package() const noexcept { return *package_; }
    const Grid& grid() const noexcept { return package_->ct.grid; }
    const TissueRow& row(Tissue t) const noexcept { return package_->tissues[std::size_t(t)]; }
    // Null for id 0 and for ids without an entry.
    const Label* label(std::uint8_t id) const noexcept { return palette_[id]; }

    // Haptics thread. Returns the tissue at voxel `i` by Algorithm 1 of Mastmeyer et al. 2017; air outside
    // the grid. Does not allocate.
    TissueSample at(const Index3& i, TrackFlags) const noexcept;
    TissueSample at(const Vec3& reference_m, TrackFlags flags) const noexcept {
        return at(grid().nearest(reference_m), flags);
    }
    // Haptics thread. Returns the track flags after the needle has entered a voxel with this tissue. Any
    // tissue except skin and air sets the flag "past the skin". Air does not set it, because a needle outside
    // the body can graze voxel corners of a slanted surface. Fascia, liver and abdominal labels set both
    // flags, "past the skin" and "past the fascia". Does not allocate.
    TrackFlags flagsAfterEntering(const TissueSample&, TrackFlags before) const noexcept;

  private:
    const Package* package_;
    std::array<const Label*, 256> palette_{};
};

}  // namespace stylet::patient
