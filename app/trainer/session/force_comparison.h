// Compares the needle force on two segmentations of one patient: the felt one and another one. The force on
// the full segmentation is the reference. The error is that of the partial segmentation
// (patient/package/segmentation.h). The comparison is never felt, recorded or hashed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "haptics/loop/simulation.h"

namespace stylet::trainer {

// Error (partial minus full) over the ticks in which the needle is in the body in at least one segmentation.
struct ForceError {
    std::uint64_t ticks = 0, equal_ticks = 0;  // equal: error exactly 0
    double largest_n = 0.0;                    // absolute value
    double largest_depth_m = 0.0;              // depth of the felt needle at the largest error
    double sum_n2 = 0.0;

    double rms_n() const;
};

struct ForceComparisonReading {
    bool known = false;  // there is a second segmentation
    bool felt_is_full = true;
    bool inside = false;  // the needle is in the body in at least one segmentation
    double full_n = 0.0, partial_n = 0.0;
    std::uint32_t insertions = 0;
    ForceError insertion, all;  // the current or last insertion; all insertions

    double error_n() const { return partial_n - full_n; }
    double other_n() const { return felt_is_full ? partial_n : full_n; }  // the force that is not felt
};

// The same patient with another segmentation. ForceComparison keeps a reference to `patient`.
struct OtherSegmentation {
    std::unique_ptr<const patient::Package> package;  // null: uses the felt patient's package
    std::unique_ptr<const patient::Patient> patient;
    bool felt_is_full = true;
};
// If `full` is not empty, returns the package in that folder. Throws DataError if its CT is not that of
// `felt` or if it is not fully segmented. If `full` is empty, returns `felt` with the partial segmentation,
// or nullopt if `felt` is not fully segmented.
std::optional<OtherSegmentation> loadOtherSegmentation(const patient::Patient& felt,
                                                       const std::filesystem::path& full);

// Session thread. Runs the needle force model tick by tick on the other segmentation.
class ForceComparison {
  public:
    // `other.patient` must outlive this object.
    ForceComparison(const OtherSegmentation& other, const haptics::NeedleSettings&);
    void update(const haptics::TickOutput&);
    const ForceComparisonReading& reading() const { return reading_; }

  private:
    void step(const haptics::TickOutput&);

    const patient::Patient* other_;
    haptics::NeedleSettings settings_;
    haptics::NeedleState needle_;
    haptics::NeedleEvents events_;
    haptics::Incisions incisions_;
    std::uint32_t begun_ = 0;
    ForceComparisonReading reading_;
};

}  // namespace stylet::trainer
