// The cases of the stability campaign: a Latin hypercube over device, tissues, hand, rate, delay, jitter,
// encoder, physical damping and friction, breathing, and hand motion.
#pragma once

#include <array>
#include <deque>
#include <vector>

#include "haptics/haptics.h"
#include "tests/support/simulated_device.h"

namespace stylet::stress {

enum class HandKind { none, light, firm };  // none: a light hand lets go after the approach
enum class Pattern { push, pullBack, inSteps, trembling };
// Half of the cases run at 1 kHz and a third at 2 kHz, because the run time grows with the number of ticks.
inline constexpr std::array kRates_hz{1000, 1000, 1000, 2000, 2000, 4000};
inline constexpr double kMeanRate_hz = 11000.0 / 6.0;
inline constexpr double kCase_s = 5.0, kRest_s = 3.2;  // from kRest_s on the hand tries to be still

// Parameters of one case. The same count and seed give the same cases.
struct StressCase {
    const haptics::DeviceProfile* device = nullptr;
    std::size_t tissues = 0;  // index in Tissues
    HandKind hand = HandKind::light;
    int rate_hz = 1000;
    double delay_s = 0.0, jitter_s = 0.0;
    double resolution_m = 0.0, mass_kg = 0.0, damping_n_s_per_m = 0.0, friction_n = 0.0;
    double breath_amplitude = 0.0, breath_period_s = 4.0;
    Pattern pattern = Pattern::push;
    double begin_s = 0.0, depth_m = 0.0, speed_m_s = 0.0, tilt_rad = 0.0;
    double weight_share = 0.0;  // share of the liver's rendered friction; acts once the hand has let go
    std::uint64_t seed = 0;
};
std::vector<StressCase> latinHypercube(int count, std::uint64_t seed);

// Patients that the cases share: layers along +x from x = 0. Breathing moves them along z, 15 mm at v = 1.
inline constexpr double kTravel_m = -0.015;
class Tissues {
  public:
    Tissues();
    const haptics::OutputSettings& output() const { return output_; }
    const patient::Patient& at(std::size_t i) const { return patients_[i]; }
    static constexpr std::size_t kLiver = 5;  // index of the patient that is all liver
    static std::size_t count();
    static const char* name(std::size_t i);

  private:
    std::deque<patient::Package> packages_;
    std::deque<patient::Patient> patients_;
    haptics::OutputSettings output_;
};

// The inputs of one run of a case.
struct CaseInput {
    haptics::Trace wanted;
    haptics::DeviceProfile profile;
    test::SimulatedBody body;
    haptics::SimulationSettings settings;
    Vec3 axis{0.0};  // of the needle, into the body
};
CaseInput prepareCase(const StressCase&, const Tissues&, bool controller);

}  // namespace stylet::stress
