// Errors that fail an exam whatever the score. Derived from the ticks, one after another.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/training/metric_table.h"

namespace stylet::training {

class SafetyWatch {
  public:
    // A vessel is major if it is the heart, an artery or the vena cava, or if the needle runs this far in it:
    // a portal or hepatic branch that does not close by itself.
    static constexpr double kMajorVessel_m = 0.006;
    // Each puncture of the liver's capsule can bleed. Punctures closer together than kSameHole_m are one.
    static constexpr int kMaxCapsulePunctures = 3;
    static constexpr double kSameHole_m = 0.003;
    // Lidocaine 1 %: more than 30 ml (300 mg) is beyond the label's greatest dose for an adult. 5 ml (50 mg)
    // in a vessel is half of what is injected against arrhythmia.
    static constexpr double kMaxAnaesthetic_m3 = 30e-6, kMaxInVessel_m3 = 5e-6;
    // A wire that has gone this far without proof lies in a duct, a vessel or a crevice, and nobody knows
    // which. In solid liver it buckles before.
    static constexpr double kBlindWire_m = 0.010;

    // `patient` must outlive this object.
    explicit SafetyWatch(const patient::Patient& patient) : patient_(&patient) {}

    // Session thread. Processes the next tick. No allocation.
    void update(const haptics::TickOutput&, const TickFacts&) noexcept;
    void judgeDose(const patient::AnaestheticVolumes&) noexcept;
    // `proven`: bile or contrast medium has shown in this insertion that the needle is in a duct.
    void judgeWire(const haptics::AccessStatus&, bool proven) noexcept;
    std::uint32_t errors() const noexcept { return errors_; }  // bit mask, 1 << CriticalError
    int capsulePunctures() const noexcept { return punctures_; }

  private:
    std::optional<CriticalError> findError(const haptics::TickOutput&) const noexcept;
    void followVessel(const haptics::TickOutput&, bool in_vessel) noexcept;
    void countCapsule(const haptics::TickOutput&) noexcept;
    void add(CriticalError error) noexcept { errors_ |= 1u << unsigned(error); }

    const patient::Patient* patient_;
    std::uint32_t errors_ = 0;
    bool in_vessel_ = false, in_liver_ = false;
    Vec3 vessel_entry_m_{0.0};
    int punctures_ = 0;
    std::array<Vec3, kMaxCapsulePunctures + 1> holes_m_{};
};

}  // namespace stylet::training
