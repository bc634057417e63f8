// The patient package: a folder that 3D Slicer opens.
//   patient.toml    tissue table, thresholds, label table with provenance, breath, licence
//   ct.nii.gz       int16 HU        labels.nii.gz  uint8 with labels.ctbl
//   motion.nii.gz   how breath moves it (optional; see motion_io.h)
//   paths.json      bookmarked reference paths (optional; see planning.h)
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "patient/motion.h"
#include "patient/tissue.h"

namespace stylet::patient {

// Bad data: what() reads "FILE: FIELD: reason".
class DataError : public std::runtime_error {
  public:
    DataError(const std::filesystem::path& file, const std::string& field, const std::string& reason)
        : std::runtime_error(file.string() + ": " + field + ": " + reason) {}
};

struct Package {
    std::string name;  // "reference patient, seed 1"
    std::string licence;
    std::string provenance;  // how the package came to be, one line
    CtVolume ct;
    LabelVolume labels;  // same grid
    std::vector<Label> label_table;
    TissueTable tissues{};
    ElasticityTable elasticity{};
    Thresholds thresholds;
    std::string reference_phase = "exhale";  // "exhale", "inhale" or "v=0.35": the breath of the CT
    MotionModel motion;                      // how breath moves it
    BreathingSignal signal;                  // the breath at rest
};

// What a package starts from: the [[tissue]] and [thresholds] tables of a TOML file
// (assets/tissue/ptcd.toml).
struct TissueDefaults {
    TissueTable tissues{};
    ElasticityTable elasticity{};
    Thresholds thresholds;
};
TissueDefaults loadTissueDefaults(const std::filesystem::path& toml);

// Throws DataError; sizes are bounded (volume.h) before anything is allocated.
Package loadPackage(const std::filesystem::path& folder);
// Writes into a temporary sibling and renames: a crash leaves no half package. Same package, same bytes.
void savePackage(const Package&, const std::filesystem::path& folder);

// 3D Slicer's colour table of labels, as labels.ctbl: id, name, red, green, blue, alpha.
std::string colourTable(const std::vector<Label>&);

// 64 bits over all that forces depend on: table, thresholds, labels, CT, breathing.
std::uint64_t digest(const Package&);

// A package made ready for look-up: dense palettes instead of lists. Keeps a reference to the package.
class Patient {
  public:
    explicit Patient(const Package&);
    // As if nobody had segmented more than these labels: thresholds decide in the others.
    Patient(const Package&, bool (*segmented)(const Label&));

    const Package& package() const noexcept { return *package_; }
    const Grid& grid() const noexcept { return package_->ct.grid; }
    const TissueRow& row(Tissue t) const noexcept { return package_->tissues[std::size_t(t)]; }
    // Null for id 0 and ids without an entry.
    const Label* label(std::uint8_t id) const noexcept { return palette_[id]; }

    // Algorithm 1 at the voxel `i` (air outside the grid). Haptics thread. noexcept, no allocation.
    TissueSample at(const Index3& i, TrackFlags) const noexcept;
    TissueSample at(const Vec3& reference_m, TrackFlags flags) const noexcept {
        return at(grid().nearest(reference_m), flags);
    }
    // What entering a voxel proves about the track: any tissue but skin lies past the skin (air does not: a
    // needle grazes the corners of a slanted surface); fascia, liver and abdominal labels past both. Haptics
    // thread. noexcept, no allocation.
    TrackFlags flagsAfterEntering(const TissueSample&, TrackFlags before) const noexcept;

  private:
    const Package* package_;
    std::array<const Label*, 256> palette_{};
};

}  // namespace stylet::patient
