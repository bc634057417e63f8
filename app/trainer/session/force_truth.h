// Compares the needle force on two segmentations of one patient: the one that is felt, and another one. The
// force on the full segmentation is the reference. The error is that of the partial segmentation
// (patient/package/segmentation.h). None of this is felt, recorded or hashed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "haptics/loop/simulation.h"

namespace stylet::trainer {

// Error (partial minus full) over the ticks in which the needle is in the body in either of the two.
struct ForceError {
    std::uint64_t ticks = 0, equal_ticks = 0;  // equal: error exactly 0
    double largest_n = 0.0;                    // absolute value
    double largest_depth_m = 0.0;              // depth of the felt needle at the largest error
    double sum_n2 = 0.0;

    double rms_n() const;
};

struct ForceTruthReading {
    bool known = false;  // there is a second segmentation
    bool felt_is_full = true;
    bool inside = false;  // needle in the body in either of the two
    double full_n = 0.0, partial_n = 0.0;
    std::uint32_t insertions = 0;
    ForceError insertion, all;  // the current or last insertion; all insertions

    double error_n() const { return partial_n - full_n; }
    double other_n() const { return felt_is_full ? partial_n : full_n; }  // the force that is not felt
};

// The same patient with another segmentation. The meter keeps a reference to it, so it must stay in place.
struct OtherSegmentation {
    std::unique_ptr<const patient::Package> package;  // null: uses the felt patient's package
    std::unique_ptr<const patient::Patient> patient;
    bool felt_is_full = true;
};
// If `full` is empty: the partial segmentation of a fully segmented `felt`, or nothing if `felt` is not
// fully segmented. Otherwise: the fully segmented package in `full`, which must have the same CT. Throws
// DataError if it is another patient or not fully segmented.
std::optional<OtherSegmentation> otherSegmentation(const patient::Patient& felt,
                                                   const std::filesystem::path& full);

// Session thread. Runs the needle force model on the other patient, tick by tick.
class ForceTruth {
  public:
    // `other.patient` must outlive it.
    ForceTruth(const OtherSegmentation& other, const haptics::NeedleSettings&);
    void take(const haptics::TickOutput&);
    const ForceTruthReading& reading() const { return reading_; }

  private:
    void step(const haptics::TickOutput&);

    const patient::Patient* other_;
    haptics::NeedleSettings settings_;
    haptics::NeedleState needle_;
    haptics::NeedleEvents events_;
    haptics::Incisions incisions_;
    std::uint32_t begun_ = 0;
    ForceTruthReading reading_;
};

}  // namespace stylet::trainer
