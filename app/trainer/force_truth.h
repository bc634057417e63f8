// The force-truth meter: what the needle would feel in the same patient segmented otherwise, beside what is
// felt. The truth is the force over the full segmentation, the error that of the partial one (patient/
// segmentation.h). Nothing of it is felt, recorded or hashed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "haptics/simulation.h"

namespace stylet::trainer {

// Partial minus full, over ticks with the needle in the body in either of the two.
struct ForceError {
    std::uint64_t ticks = 0, equal_ticks = 0;  // equal: to the last bit
    double largest_n = 0.0;                    // without its sign
    double largest_depth_m = 0.0;              // of the felt needle, there
    double sum_n2 = 0.0;

    double rms_n() const;
};

struct ForceTruthReading {
    bool known = false;  // there is a full segmentation
    bool felt_is_full = true;
    bool inside = false;  // in either of the two
    double full_n = 0.0, partial_n = 0.0;
    std::uint32_t insertions = 0;
    ForceError insertion, all;  // the present one or the last; all of them

    double error_n() const { return partial_n - full_n; }
    double other_n() const { return felt_is_full ? partial_n : full_n; }  // what is not felt
};

// A patient as another has segmented him. Stays where it is: the meter keeps a reference.
struct OtherSegmentation {
    std::unique_ptr<const patient::Package> package;  // null: the felt one's
    std::unique_ptr<const patient::Patient> patient;
    bool felt_is_full = true;
};
// Of a fully segmented patient the partial one. Of another the full one in `full`, a package on the same CT;
// nothing where that is empty. Throws patient::DataError: not this patient, or not fully segmented.
std::optional<OtherSegmentation> otherSegmentation(const patient::Patient& felt,
                                                   const std::filesystem::path& full);

// Session thread. The force model itself, tick by tick, on the other patient.
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
